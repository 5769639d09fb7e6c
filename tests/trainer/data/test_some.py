"""Some of a source's pictures: as many as asked for, of those that are trained on, the same ones each time."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from trainer import processes
from trainer.config import SceneConfig
from trainer.data.fresh import fresh_views
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.source import FolderPictures, PictureSource
from trainer.data.streaming import open_shards

SCENE = SceneConfig(32, 24)
CHAIRS = RenderSettings("chair", seed=3, supersampling=2)
IN_ALL, HELD_OUT = 20, 4


@pytest.fixture(scope="module")
def loose(tmp_path_factory: pytest.TempPathFactory) -> ImageSet:
    folder = tmp_path_factory.mktemp("loose") / "chair"
    render_folder(folder, CHAIRS, SCENE, IN_ALL, 1, 1, show_progress=False)
    return load_image_folder(folder, SCENE.width, SCENE.height)


@pytest.fixture(scope="module")
def shards(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five shards of four pictures, one of which is held out."""
    folder = tmp_path_factory.mktemp("shards") / "chair"
    render_folder(folder, replace(CHAIRS, shard_pictures=4), SCENE, IN_ALL, 1, 1, show_progress=False)
    return folder


@pytest.fixture(params=["folder", "shards", "fresh"])
def source(request: pytest.FixtureRequest, loose: ImageSet, shards: Path) -> PictureSource:
    match request.param:
        case "folder":
            return FolderPictures(loose, torch.arange(HELD_OUT, IN_ALL), torch.arange(HELD_OUT))
        case "shards":
            return open_shards(shards, SCENE.width, SCENE.height, SCENE, 0.2, 2)
        case _:
            return fresh_views(CHAIRS, SCENE, IN_ALL, 0.2, 0, 2**30)


def test_as_many_as_asked_for_and_no_two_the_same(source: PictureSource) -> None:
    found = source.some(7, 0)
    assert found.pictures.shape == (7, 3, SCENE.height, SCENE.width)
    assert len(np.unique(found.pictures.reshape(7, -1), axis=0)) == 7
    assert found.scene == source.scene


def test_seed_alone_decides(source: PictureSource, monkeypatch: pytest.MonkeyPatch) -> None:
    first = source.some(7, 0)
    assert np.array_equal(source.some(7, 0).pictures, first.pictures)
    assert not np.array_equal(source.some(7, 1).pictures, first.pictures)
    monkeypatch.setattr(processes, "number", lambda: 1)
    monkeypatch.setattr(processes, "count", lambda: 2)
    assert np.array_equal(source.some(7, 0).pictures, first.pictures)


def test_none_is_held_out_and_where_there_are_no_more_all_come(source: PictureSource, loose: ImageSet) -> None:
    assert source.training == IN_ALL - HELD_OUT
    found = source.some(100, 0).pictures.reshape(-1, 3 * SCENE.height * SCENE.width)
    everything = {picture.tobytes() for picture in loose.pictures}
    if len(found) == 100:
        # Fresh views have no end.
        assert not everything & {picture.tobytes() for picture in found}
        return
    assert len(found) == len({picture.tobytes() for picture in found} & everything) == IN_ALL - HELD_OUT
    shown = np.clip(np.round(source.shown().numpy() * 4095), 0, 4095)
    linear = np.clip(np.round(source.some(100, 0).batch(range(len(found))).numpy() * 4095), 0, 4095)
    assert not {picture.tobytes() for picture in shown} & {picture.tobytes() for picture in linear}
