"""An outside opinion: OpenGL draws the same mesh with its own camera, and finds the lit colours where we put them."""

import ctypes.util
import dataclasses
import importlib.util
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from imaging.srgb import decode_table
from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.data.metadata import read_metadata
from trainer.data.normals import corner_normals
from trainer.data.opengl import opengl
from trainer.data.picture import draw, rotation_about_y
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.rig import load_rig
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh
from trainer.errors import ConfigError, DataError

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("pyrender") is None or ctypes.util.find_library("EGL") is None,
    reason="pyrender or EGL is missing: pip install pyrender==0.1.45, apt install libegl1 libgl1",
)

SUPERSAMPLING = 8
SCENE = SceneConfig(
    lights=(DirectionalLight(40.0, 25.0, (0.9, 0.6, 0.3)), DirectionalLight(150.0, 60.0, (0.0, 0.3, 0.6))),
    ambient=(0.0, 0.1, 0.0),
)
SMALL = SceneConfig(40, 30)


def outside_opinion(mesh: Mesh, azimuth: float, light_azimuth: float, scene: SceneConfig = SCENE) -> np.ndarray:
    with opengl(scene, SUPERSAMPLING) as draws:
        return draws(mesh, azimuth, light_azimuth, corner_normals(mesh))


@pytest.fixture(scope="module")
def opinion() -> np.ndarray:
    return outside_opinion(make_shape("car", 2), 0.6, 0.2)


def test_we_draw_what_opengl_draws(opinion: np.ndarray) -> None:
    ours = draw(make_shape("car", 2), 0.6, 0.2, SCENE, SUPERSAMPLING)[0]
    difference = np.abs(ours - opinion)
    assert opinion.max() > 0.8
    assert difference.mean() < 5e-4
    assert np.percentile(difference, 99.5) < 0.02


@pytest.mark.parametrize(
    "mistake", ["transposed rotation", "mirrored light", "light from below", "light turned back", "one degree off"]
)
def test_the_comparison_would_notice(opinion: np.ndarray, mistake: str) -> None:
    mesh, azimuth, light_azimuth, scene = make_shape("car", 2), 0.6, 0.2, SCENE
    match mistake:
        case "transposed rotation":
            azimuth = -azimuth
        case "mirrored light":
            lights = tuple(dataclasses.replace(one, azimuth_degrees=-one.azimuth_degrees) for one in scene.lights)
            scene = dataclasses.replace(scene, lights=lights)
        case "light from below":
            lights = tuple(dataclasses.replace(one, elevation_degrees=-one.elevation_degrees) for one in scene.lights)
            scene = dataclasses.replace(scene, lights=lights)
        case "light turned back":
            light_azimuth = -light_azimuth
        case "one degree off":
            mesh = Mesh(mesh.vertices @ rotation_about_y(0.02).T, mesh.faces)
    assert np.abs(draw(mesh, azimuth, light_azimuth, scene, SUPERSAMPLING)[0] - opinion).mean() > 3e-3


@pytest.mark.parametrize(
    "camera", [CameraConfig(-20.0, 0.6, 120.0), CameraConfig(89.0, 9000.0, 0.1), CameraConfig(10.0, 3.0, 60.0)]
)
def test_cameras_near_and_far_agree(camera: CameraConfig) -> None:
    mesh, scene = make_shape("chair", 3), SceneConfig(60, 80, camera)
    theirs = outside_opinion(mesh, 2.0, 0.0, scene)
    assert theirs.max() > 0.3
    assert np.abs(draw(mesh, 2.0, 0.0, scene, SUPERSAMPLING)[0] - theirs).mean() < 1e-3


def test_a_folder_that_opengl_renders_is_ours_but_for_rounding(tmp_path: Path) -> None:
    rig = load_rig("white")
    scene = dataclasses.replace(SMALL, lights=rig.lights, ambient=rig.ambient)
    theirs = RenderSettings("car", 3, rotate_lights=True, supersampling=SUPERSAMPLING, renderer="pyrender")
    render_folder(tmp_path / "theirs", theirs, scene, 3, 2, 1, show_progress=False)
    ours = dataclasses.replace(theirs, renderer="chiaro")
    render_folder(tmp_path / "ours", ours, scene, 3, 2, 1, show_progress=False)
    names = list(read_metadata(tmp_path / "ours") or {})
    assert list(read_metadata(tmp_path / "theirs") or {}) == names
    for name in names:
        pair = [decode_table()[np.asarray(Image.open(tmp_path / who / name))] for who in ("ours", "theirs")]
        assert pair[0].max() > 0.5
        assert np.abs(pair[0] - pair[1]).mean() < 2e-3
    with pytest.raises(
        DataError, match=r"render\.json holds .*: renderer: expected chiaro, found pyrender; render into"
    ):
        render_folder(tmp_path / "theirs", ours, scene, 3, 2, 1, show_progress=False)


def test_several_processes_open_opengl_each(tmp_path: Path) -> None:
    settings = RenderSettings("chair", supersampling=1, renderer="pyrender")
    for workers in (1, 2):
        render_folder(tmp_path / str(workers), settings, SMALL, 80, 1, workers, show_progress=False)
    for path in sorted((tmp_path / "1").rglob("*.png")):
        assert path.read_bytes() == (tmp_path / "2" / path.relative_to(tmp_path / "1")).read_bytes()
    assert len(list((tmp_path / "2").rglob("*.png"))) == 80


def test_without_pyrender_a_sentence_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyrender", None)
    with pytest.raises(ConfigError, match=r"Expected pyrender and EGL, .*pip install pyrender==0\.1\.45 .*libegl1"):
        render_folder(tmp_path / "out", RenderSettings("car", renderer="pyrender"), SMALL, 2, 1, 1, show_progress=False)
    assert not (tmp_path / "out").exists()


def test_a_light_in_the_surface_adds_nothing() -> None:
    """In closed form: an upright wall, head-on, under a light at 60° to it and one along it."""
    camera = CameraConfig(elevation_degrees=0.0, distance=2.0, field_of_view_degrees=2 * math.degrees(math.atan(0.24)))
    lights = (DirectionalLight(60.0, 0.0, (1.0, 0.5, 0.25)), DirectionalLight(0.0, 90.0, (1.0, 1.0, 1.0)))
    wall = Mesh(
        np.array([(-0.2, -0.1, 0.0), (0.2, -0.1, 0.0), (0.2, 0.1, 0.0), (-0.2, 0.1, 0.0)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    picture = outside_opinion(wall, 0.0, 0.0, SceneConfig(96, 96, camera, lights))
    np.testing.assert_allclose(picture[40:56, 30:66], np.broadcast_to((0.5, 0.25, 0.125), (16, 36, 3)), atol=1 / 255)
    assert not picture[:36].any()
    assert not picture[:, :26].any()
