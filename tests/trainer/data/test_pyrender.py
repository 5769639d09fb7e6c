"""An outside opinion: pyrender draws the same mesh with its own camera, and finds the lit colours where we put them."""

import dataclasses
import math
import os

import numpy as np
import pytest

os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
pyrender = pytest.importorskip("pyrender", reason="pyrender needs EGL: apt install libegl1 libgl1", exc_type=Exception)

from trainer.config import DirectionalLight, SceneConfig
from trainer.data.normals import corner_normals
from trainer.data.picture import draw, rotation_about_y
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh

SUPERSAMPLING = 8
SCENE = SceneConfig(
    lights=(DirectionalLight(40.0, 25.0, (0.9, 0.6, 0.3)), DirectionalLight(150.0, 60.0, (0.0, 0.3, 0.6)))
)


def outside_opinion(mesh: Mesh, azimuth: float) -> np.ndarray:
    """The picture by OpenGL: poses, normals and light written down anew as 4 × 4 matrices and dot products."""
    scene = pyrender.Scene(ambient_light=(1.0, 1.0, 1.0), bg_color=(0.0, 0.0, 0.0, 1.0))
    turn = np.eye(4)
    turn[:3, :3] = [
        (math.cos(azimuth), 0, math.sin(azimuth)), (0, 1, 0), (-math.sin(azimuth), 0, math.cos(azimuth))
    ]  # fmt: skip
    normals = corner_normals(mesh).reshape(-1, 3) @ turn[:3, :3].T
    colours = np.zeros((len(normals), 3))
    for light in SCENE.lights:
        up, around = math.radians(light.elevation_degrees), math.radians(light.azimuth_degrees)
        direction = (math.cos(up) * math.sin(around), math.sin(up), math.cos(up) * math.cos(around))
        colours += np.abs(normals @ direction)[:, None] * light.colour
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    primitive = pyrender.Primitive(positions=corners, normals=normals, color_0=np.clip(colours, 0, 1), mode=4)
    scene.add(pyrender.Mesh([primitive]), pose=turn)
    elevation, distance = math.radians(SCENE.camera.elevation_degrees), SCENE.camera.distance
    pose = np.eye(4)
    pose[:3, :3] = [
        (1, 0, 0), (0, math.cos(elevation), math.sin(elevation)), (0, -math.sin(elevation), math.cos(elevation))
    ]  # fmt: skip
    pose[:3, 3] = distance * pose[:3, 2]
    scene.add(pyrender.PerspectiveCamera(math.radians(SCENE.camera.field_of_view_degrees), znear=0.1), pose=pose)
    renderer = pyrender.OffscreenRenderer(SCENE.width * SUPERSAMPLING, SCENE.height * SUPERSAMPLING)
    try:
        flags = pyrender.RenderFlags.FLAT | pyrender.RenderFlags.SKIP_CULL_FACES
        picture = renderer.render(scene, flags)[0]
    finally:
        renderer.delete()
    return (picture / 255.0).reshape(SCENE.height, SUPERSAMPLING, SCENE.width, SUPERSAMPLING, 3).mean((1, 3))


@pytest.fixture(scope="module")
def opinion() -> np.ndarray:
    return outside_opinion(make_shape("car", 2), 0.6)


def test_we_draw_what_opengl_draws(opinion: np.ndarray) -> None:
    ours = draw(make_shape("car", 2), 0.6, 0.0, SCENE, SUPERSAMPLING)[0]
    difference = np.abs(ours - opinion)
    assert opinion.max() > 0.8
    assert difference.mean() < 5e-4
    assert np.percentile(difference, 99.5) < 0.02


@pytest.mark.parametrize("mistake", ["transposed rotation", "mirrored light", "light from below", "one degree off"])
def test_the_comparison_would_notice(opinion: np.ndarray, mistake: str) -> None:
    mesh, azimuth, scene = make_shape("car", 2), 0.6, SCENE
    match mistake:
        case "transposed rotation":
            azimuth = -azimuth
        case "mirrored light":
            lights = tuple(dataclasses.replace(one, azimuth_degrees=-one.azimuth_degrees) for one in scene.lights)
            scene = dataclasses.replace(scene, lights=lights)
        case "light from below":
            lights = tuple(dataclasses.replace(one, elevation_degrees=-one.elevation_degrees) for one in scene.lights)
            scene = dataclasses.replace(scene, lights=lights)
        case "one degree off":
            mesh = Mesh(mesh.vertices @ rotation_about_y(0.02).T, mesh.faces)
    assert np.abs(draw(mesh, azimuth, 0.0, scene, SUPERSAMPLING)[0] - opinion).mean() > 3e-3
