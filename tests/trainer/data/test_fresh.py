"""Views that are drawn for each step: right, uniform, never the same twice, and the same in every run."""

import itertools
import math
import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh

from trainer.config import SceneConfig
from trainer.data.fresh import FreshViews, fresh_views
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings, load_instance, poses
from trainer.data.shapes.catalogue import make_shape
from trainer.data.source import MOST_SHOWN, Minibatch
from trainer.errors import DataError

SCENE = SceneConfig(32, 24)
CARS = RenderSettings("car", supersampling=2)


def views(
    settings: RenderSettings = CARS, count: int | None = 12, share: float = 0.25, memory: int = 2**30
) -> FreshViews:
    return fresh_views(settings, SCENE, count, share, 0, memory)


def first(source: FreshViews, count: int, size: int = 6, seed: int = 0, start: int = 0) -> list[Minibatch]:
    with closing(source.minibatches(size, seed, start)) as minibatches:
        return list(itertools.islice(minibatches, count))


def test_a_picture_is_of_the_object_and_the_azimuth_that_it_says() -> None:
    """Of two objects only, so that one of them must explain each picture."""
    source = views(count=2, share=0.0)
    (batch,) = first(source, 1)
    assert batch.pictures.shape == (6, 3, 24, 32)
    assert batch.azimuths is not None
    meshes = [load_instance(CARS, name) for name in source.names]
    for picture, azimuth in zip(batch.pictures, batch.azimuths, strict=True):
        drawn = [draw(mesh, float(azimuth), 0.0, SCENE, 2)[0].transpose(2, 0, 1) for mesh in meshes]
        assert min(np.abs(picture.numpy() - one).max() for one in drawn) < 1e-3
        assert max(np.abs(picture.numpy() - one).max() for one in drawn) > 0.1


def test_no_view_comes_twice() -> None:
    batches = first(views(count=3, share=0.0), 40)
    azimuths = torch.cat([batch.azimuths for batch in batches if batch.azimuths is not None])
    assert len(azimuths.unique()) == 240
    pictures = torch.cat([batch.pictures for batch in batches]).flatten(1)
    assert len(pictures.unique(dim=0)) == 240
    # Kolmogorov and Smirnov: a deviation of 1.63/√n happens once in a hundred samples.
    share = np.sort((azimuths.double().numpy() + math.pi) / (2 * math.pi))
    assert share.min() >= 0
    assert share.max() <= 1
    assert np.abs(share - (np.arange(240) + 0.5) / 240).max() < 1.63 / math.sqrt(240)


def test_a_step_is_the_same_in_every_run_and_from_every_start() -> None:
    whole, resumed = first(views(), 6), first(views(), 3, start=3)
    for one, other in zip(whole[3:], resumed, strict=True):
        assert torch.equal(one.pictures, other.pictures)
        assert one.azimuths is not None
        assert other.azimuths is not None
        assert torch.equal(one.azimuths, other.azimuths)
        assert torch.equal(one.generator.get_state(), other.generator.get_state())
    other_seed = first(views(), 1, seed=1)
    assert not torch.equal(whole[0].pictures, other_seed[0].pictures)


def test_memory_changes_nothing_but_time() -> None:
    for one, other in zip(first(views(), 4), first(views(memory=1), 4), strict=True):
        assert torch.equal(one.pictures, other.pictures)


def test_held_out_objects_are_shown_and_never_trained_on() -> None:
    source = views()
    assert (source.training, source.validation) == (9, 3)
    assert not set(source.names) & set(source.held_out)
    drawn: list[str] = []
    store, load = source.store, source.store._load

    def noting(name: str) -> object:
        drawn.append(name)
        return load(name)

    store._load = noting  # type: ignore[assignment]
    first(source, 20)
    assert set(drawn) == set(source.names)
    shown = source.shown()
    assert torch.equal(shown, source.shown())
    for picture, name in zip(shown, source.held_out, strict=True):
        (pose,) = poses(CARS, name, 1)
        expected = draw(load_instance(CARS, name), math.radians(pose.azimuth_degrees or 0.0), 0.0, SCENE, 2)[0]
        np.testing.assert_allclose(picture.numpy(), expected.transpose(2, 0, 1), atol=1e-3)
    assert len(views(share=0.0).shown()) == MOST_SHOWN


def test_lights_turn_where_they_are_asked_to() -> None:
    fixed, turned = first(views(), 1), first(views(replace(CARS, rotate_lights=True)), 1)
    assert fixed[0].azimuths is not None
    assert turned[0].azimuths is not None
    assert torch.equal(fixed[0].azimuths, turned[0].azimuths)
    lit = fixed[0].pictures.amax(1) > 0
    assert torch.equal(lit, turned[0].pictures.amax(1) > 0)
    assert (fixed[0].pictures - turned[0].pictures).abs().mean((1, 2, 3)).min() > 1e-3


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for seed in range(4):
        vertices, faces = make_shape("chair", seed)
        trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / f"chair{seed}.ply")
    return tmp_path


def test_broken_meshes_are_told_once_and_others_drawn_instead(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    (folder / "broken.obj").write_text("v 0 0 0\n")
    source = views(RenderSettings(str(folder), supersampling=1), None, 0.0)
    assert source.training == 5
    whole = first(source, 8)
    assert len(caplog.messages) == 1
    assert "broken.obj: expected a mesh with faces" in caplog.messages[0]
    again = first(views(RenderSettings(str(folder), supersampling=1), None, 0.0), 8)
    assert all(torch.equal(one.pictures, other.pictures) for one, other in zip(whole, again, strict=True))
    assert all(batch.pictures.amax((1, 2, 3)).min() > 0.1 for batch in whole)


def test_a_training_goes_on_where_no_held_out_mesh_can_be_read(folder: Path) -> None:
    settings = RenderSettings(str(folder), supersampling=1)
    (lost,) = views(settings, None, 0.25).held_out
    (folder / lost).write_text("nothing")
    assert len(views(settings, None, 0.25).shown()) == 3


def test_a_folder_of_broken_meshes_ends_in_a_sentence(folder: Path) -> None:
    for path in folder.iterdir():
        path.write_text("nothing")
    source = views(RenderSettings(str(folder)), None, 0.0)
    with pytest.raises(DataError, match=r"none of the 4 meshes in .* can be read; first: .*chair0\.ply cannot be read"):
        first(source, 1)
    with pytest.raises(DataError, match="none of the 4 meshes"):
        views(RenderSettings(str(folder)), None, 0.0).shown()


def test_too_few_objects_are_refused(folder: Path) -> None:
    with pytest.raises(DataError, match="Expected at least 2 objects to train on, found 1 in car"):
        views(count=2, share=0.5)
    shutil.rmtree(folder)
    with pytest.raises(DataError, match="found nothing"):
        views(RenderSettings(str(folder)), None)
