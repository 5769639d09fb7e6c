"""Minibatches in which several pictures show one object."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import torch

from trainer.config import SceneConfig
from trainer.data.fresh import FreshViews, fresh_views
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.mesh_store import Ready
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.source import FolderPictures, grouped_indices, step_generator


@pytest.mark.parametrize("views", [1, 2, 3])
def test_views_stand_together_and_differ_and_objects_are_drawn_alike(views: int) -> None:
    instances = np.array([4, 0, 4, 2, 0, 4, 2, 0, 2, 4, 7, 7, 7])
    pictures = torch.tensor([0, 1, 2, 3, 4, 5, 6, 7, 8, 9])
    chosen = grouped_indices(pictures, instances, 3000, views, step_generator(0, 5)).numpy().reshape(3000, views)
    assert set(chosen.flatten()) == set(range(10))
    shown = instances[chosen]
    assert (shown == shown[:, :1]).all()
    assert all(len(set(row)) == views for row in chosen.tolist())
    # Three objects, whichever has more pictures: 1000 of each, with a standard deviation of 26.
    assert all(abs(count - 1000) < 130 for count in Counter(shown[:, 0].tolist()).values())


def test_a_folder_s_minibatches_hold_whole_objects(tmp_path: Path) -> None:
    render_folder(tmp_path, RenderSettings("car", seed=2, supersampling=1), SceneConfig(32, 24), 4, 3, 1, False)
    images: ImageSet = load_image_folder(tmp_path, 32, 24)
    source = FolderPictures(images, torch.arange(12), torch.arange(0))
    batch = next(source.minibatches(6, 0, 0, views=3))
    again = next(source.minibatches(6, 0, 0, views=3))
    assert torch.equal(batch.pictures, again.pictures)
    every, instances = images.batch(np.arange(12)), []
    for picture in batch.pictures:
        (number,) = [n for n in range(12) if torch.equal(every[n], picture)]
        instances.append(images.instances[number])
    assert instances[:3] == instances[:1] * 3
    assert instances[3:] == instances[3:4] * 3


def test_fresh_views_of_an_object_stand_together(monkeypatch: pytest.MonkeyPatch) -> None:
    views = fresh_views(RenderSettings("car", seed=1, supersampling=1), SceneConfig(32, 24), 8, 0.0, 0, 2**30)
    shown: list[float] = []

    def note(self: FreshViews, ready: Ready, azimuth: float, light_azimuth: float) -> np.ndarray:
        shown.append(float(np.abs(ready.mesh.vertices).sum()))
        return np.zeros((3, 24, 32), np.float32)

    monkeypatch.setattr(FreshViews, "_picture", note)
    views.drawn(60, 0, 0, views=3)
    groups = np.array(shown).reshape(20, 3)
    assert (groups == groups[:, :1]).all()
    assert 3 < len(set(shown)) <= 8
