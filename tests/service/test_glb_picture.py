"""A GLB file tells the whole story: OpenGL renders it from its own camera under its own lights, and finds the picture.

Everything that is drawn is read out of the file; the picture is drawn as training pictures are.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from rasteriser import supersample
from service.glb import write_glb
from service.inference import Engine, decode, sample_shape_code
from service.manifest import Light
from tests.service.reading import array_of, document_of, rotation_matrix
from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.data.picture import draw
from trainer.data.shapes.solid import Mesh

SAMPLES = 8
LIGHTS = ((30.0, 35.0, (0.6, 0.1, 0.0)), (150.0, 10.0, (0.0, 0.5, 0.2)), (-80.0, -30.0, (0.1, 0.0, 0.6)))
AMBIENT = (0.1, 0.05, 0.0)


def picture_by_opengl(glb: bytes, width: int, height: int) -> np.ndarray:
    """[height, width, 3] linear. A white, matt surface is shaded as KHR_lights_punctual says, at its vertices."""
    pyrender = pytest.importorskip("pyrender", reason="pyrender is what renders the GLB")
    document = document_of(glb)
    scene = pyrender.Scene(ambient_light=(1.0, 1.0, 1.0), bg_color=(0.0, 0.0, 0.0, 1.0))
    lights = document["extensions"]["KHR_lights_punctual"]["lights"]
    for node in document["nodes"]:
        if "mesh" in node:
            (part,) = document["meshes"][node["mesh"]]["primitives"]
            normals = array_of(glb, part["attributes"]["NORMAL"])
            colours = np.tile(document["materials"][part["material"]]["emissiveFactor"], (len(normals), 1))
            for other in document["nodes"]:
                if "extensions" in other:
                    light = lights[other["extensions"]["KHR_lights_punctual"]["light"]]
                    towards = rotation_matrix(other["rotation"])[:, 2]
                    radiance = light["intensity"] * np.array(light["color"]) / math.pi
                    colours = colours + np.maximum(0, normals @ towards)[:, None] * radiance
            faces = array_of(glb, part["indices"]).reshape(-1, 3)
            corners = array_of(glb, part["attributes"]["POSITION"])[faces].reshape(-1, 3)
            shaded = colours.clip(0, 1)[faces].reshape(-1, 3)
            scene.add(pyrender.Mesh([pyrender.Primitive(positions=corners, color_0=shaded, mode=4)]))
        if "camera" in node:
            lens = document["cameras"][node["camera"]]["perspective"]
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = rotation_matrix(node["rotation"]), node["translation"]
            camera = pyrender.PerspectiveCamera(
                lens["yfov"], znear=lens["znear"], zfar=lens["zfar"], aspectRatio=lens["aspectRatio"]
            )
            scene.add(camera, pose=pose)
    try:
        renderer = pyrender.OffscreenRenderer(width * SAMPLES, height * SAMPLES)
    except Exception as error:  # what is missing shows as one of many errors of PyOpenGL's
        pytest.skip(f"OpenGL cannot be had off screen: {error}")
    flags = pyrender.RenderFlags.FLAT | pyrender.RenderFlags.SKIP_CULL_FACES
    try:
        samples = renderer.render(scene, flags)[0]
    finally:
        renderer.delete()
    return samples.reshape(height, SAMPLES, width, SAMPLES, 3).mean((1, 3)) / 255


@pytest.mark.parametrize(("azimuth", "light_azimuth"), [(0.0, 0.0), (0.9, 0.0), (-2.4, 1.1)])
def test_the_glb_renders_as_the_picture(engine: Engine, azimuth: float, light_azimuth: float) -> None:
    camera = CameraConfig(elevation_degrees=24.0, distance=2.2, field_of_view_degrees=35.0)
    scene = SceneConfig(64, 48, camera, tuple(DirectionalLight(*light) for light in LIGHTS), AMBIENT)
    manifest = replace(
        engine.manifest,
        camera=replace(engine.manifest.camera, elevation_degrees=24.0, distance=2.2, field_of_view_degrees=35.0),
        lights=tuple(Light(*light) for light in LIGHTS),
        ambient=AMBIENT,
    )
    surface = decode(engine, sample_shape_code(5, engine.manifest.latent, 0.3))
    mesh = Mesh(surface.vertices.astype(np.float64), engine.faces)
    normals = surface.normals.astype(np.float64)[engine.faces]
    picture = draw(mesh, azimuth, light_azimuth, scene, SAMPLES, normals)
    assert isinstance(picture, supersample.Picture)
    assert 0.05 < picture.alpha.mean() < 0.8
    found = picture_by_opengl(write_glb(surface, manifest, azimuth, {}, light_azimuth), 64, 48)
    # OpenGL rounds to 8 bits, and one sample in sixty-four may fall to the other side of an edge.
    differences = np.abs(found - picture.colour)
    assert differences.mean() < 0.002
    assert np.quantile(differences, 0.99) < 0.03
    turned = picture_by_opengl(write_glb(surface, manifest, azimuth + 0.1, {}, light_azimuth), 64, 48)
    assert np.abs(turned - picture.colour).mean() > 5 * differences.mean()
