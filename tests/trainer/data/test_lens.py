"""Zooming in: the same as a longer lens, as far as objects allow, of folders, shards and drawn views alike."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imaging.srgb import decode_table
from trainer import processes
from trainer.commands.fresh import FreshOptions, open_fresh
from trainer.config import CameraConfig, SceneConfig, TrainConfig
from trainer.data.images import load_image_folder
from trainer.data.lens import MOST_ZOOM, largest_zoom, zoomed
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.scene import read_scene
from trainer.data.streaming import open_shards

SCENE = SceneConfig(64, 48)
SETTINGS = RenderSettings("airplane", seed=3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures") / "airplane"
    render_folder(folder, SETTINGS, SCENE, 12, 1, 1, show_progress=False)
    return folder


def test_there_and_back_again_is_the_same_scene() -> None:
    for zoom in (1.0, 1.37, 2.0, 7.99):
        closer = zoomed(SCENE, zoom)
        assert closer.zoom == zoom
        assert zoomed(closer, zoom) is closer
        back = zoomed(zoomed(closer, 3.0), 1.0)
        assert back.camera.field_of_view_degrees == pytest.approx(30.0, abs=1e-9)
        assert replace(back, camera=SCENE.camera) == SCENE
    assert zoomed(SCENE, 2.0).camera.field_of_view_degrees == pytest.approx(15.2608, abs=1e-3)


def test_zooming_into_pictures_is_drawing_them_through_a_longer_lens(folder: Path, tmp_path: Path) -> None:
    near = load_image_folder(folder, 32, 24, zoom=2.0)
    assert near.scene == zoomed(replace(SCENE, width=32, height=24), 2.0)
    drawn = replace(near.scene, zoom=1.0)
    render_folder(tmp_path, replace(SETTINGS, supersampling=8), drawn, 12, 1, 1, show_progress=False)
    expected = decode_table()[load_image_folder(tmp_path, 32, 24).pictures]
    found = decode_table()[near.pictures]
    # As they are, they are something else.
    plain = decode_table()[load_image_folder(folder, 32, 24).pictures]
    assert np.abs(found - expected).mean() < 0.1 * np.abs(plain - expected).mean()


def test_a_model_s_scene_zooms_into_every_folder(folder: Path) -> None:
    own = zoomed(replace(SCENE, width=32, height=24), 1.5)
    shown = load_image_folder(folder, 32, 24, own)
    assert shown.scene == own
    np.testing.assert_array_equal(shown.pictures, load_image_folder(folder, 32, 24, zoom=1.5).pictures)


def test_objects_reach_about_to_the_border(folder: Path) -> None:
    near = load_image_folder(folder, 64, 48, zoom=0)
    assert 1.2 < near.scene.zoom < 2.2
    assert near.scene == zoomed(SCENE, near.scene.zoom)
    seen = near.pictures.max(1) > 8
    middle = seen[:, 3:-3, 3:-3]
    assert 0 < seen.sum() - middle.sum() < 0.1 * seen.sum()
    np.testing.assert_array_equal(near.pictures, load_image_folder(folder, 64, 48, zoom=near.scene.zoom).pictures)


def test_how_far_one_can_zoom() -> None:
    pictures = np.zeros((2, 3, 48, 64), np.uint8)
    pictures[0, :, 12:36, 20:40] = 200
    # Up and down to half of the way, from side to side to 24 of 64.
    assert largest_zoom(pictures) == pytest.approx(2.0, abs=0.03)
    pictures[1, 1, 20:28, 8:56] = 200
    assert largest_zoom(pictures) == pytest.approx(4 / 3, abs=0.02)
    # A pixel of a thousand does not decide, nor does what compression makes of black.
    pictures[1, :, 0, 0] = 255
    pictures[0, :, :, 0] = 8
    assert largest_zoom(pictures) == pytest.approx(4 / 3, abs=0.02)
    pictures[:] = 200
    assert largest_zoom(pictures) == 1
    speck = np.zeros((1, 3, 48, 64), np.uint8)
    speck[0, :, 23:25, 31:33] = 200
    assert largest_zoom(speck) == MOST_ZOOM
    assert largest_zoom(np.zeros_like(speck)) == 1


def test_shards_zoom_as_folders_do(folder: Path, tmp_path: Path) -> None:
    render_folder(tmp_path, replace(SETTINGS, shard_pictures=6), SCENE, 12, 1, 1, show_progress=False)
    source = open_shards(tmp_path, 32, 24, SCENE, 0.0, 2, zoom=1.5)
    images = source.load(source.shards)
    loose = load_image_folder(folder, 32, 24, zoom=1.5)
    assert source.scene == images.scene == loose.scene
    np.testing.assert_array_equal(images.pictures, loose.pictures)
    found = open_shards(tmp_path, 64, 48, SCENE, 0.0, 2, zoom=0).scene.zoom
    first = load_image_folder(folder, 64, 48).pictures[:6]
    assert found == largest_zoom(first) > 1.2


def test_processes_that_train_together_zoom_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for number in (0, 1):
        monkeypatch.setattr(processes, "share", lambda size, number=number: slice(number, size, 2))
        views = open_fresh(FreshOptions(instances=8), "airplane", TrainConfig(width=32, height=24, zoom=0))
        found.append((views.scene, views.drawn(4, 0, 0)[0]))
    assert found[0][0] == found[1][0]
    assert found[0][1].shape == (2, 3, 24, 32)
    assert not found[0][1].equal(found[1][1])


@pytest.mark.parametrize("zoom", [0.0, 1.5])
def test_drawn_views_are_drawn_as_near(zoom: float) -> None:
    options = FreshOptions(instances=8, camera=CameraConfig(elevation_degrees=20.0))
    config = TrainConfig(width=32, height=24, zoom=zoom)
    near = open_fresh(options, "airplane", config)
    plain = open_fresh(options, "airplane", replace(config, zoom=1.0))
    assert near.scene == zoomed(plain.scene, near.scene.zoom)
    assert near.scene.zoom == zoom or 1.2 < near.scene.zoom < 2.2
    light = [source.drawn(16, 0, 0)[0].mean() for source in (near, plain)]
    assert light[0] / light[1] == pytest.approx(near.scene.zoom**2, rel=0.05)


def test_a_model_is_shown_what_its_own_camera_sees(folder: Path, tmp_path: Path) -> None:
    """Whatever the lens was: that of the pictures it was trained on, its own, or a third."""
    own = zoomed(replace(SCENE, width=32, height=24), 1.6)
    expected = decode_table()[load_image_folder(folder, 32, 24, own).pictures]
    others = {"own": own, "third": zoomed(replace(SCENE, width=96, height=72), 1.2)}
    for name, scene in others.items():
        render_folder(tmp_path / name, replace(SETTINGS, supersampling=8), scene, 12, 1, 1, show_progress=False)
        assert read_scene(tmp_path / name) == replace(scene, zoom=1.0)
        shown = load_image_folder(tmp_path / name, 32, 24, own)
        assert shown.scene == own
        assert np.abs(decode_table()[shown.pictures] - expected).mean() < 0.01
    # From another place, there is nothing to compare.
    elsewhere = replace(own, camera=replace(own.camera, distance=3.0))
    found = load_image_folder(folder, 32, 24, elsewhere)
    np.testing.assert_array_equal(decode_table()[found.pictures], expected)
    assert found.scene.camera.distance == 2
