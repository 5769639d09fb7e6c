"""What is photographed here is what `trainer render` writes and the judge reads."""

from pathlib import Path

import numpy as np

from tests.trainer.stability.conftest import SCENE
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.evaluation.pictures import from_folder
from trainer.stability.objects import TEST_SEED, exhibits, photographs, pictures_of, truths


def test_photographs_are_those_of_a_rendered_folder(tmp_path: Path) -> None:
    render_folder(tmp_path / "car", RenderSettings("car", seed=TEST_SEED), SCENE, 3, 2, 1, show_progress=False)
    expected = from_folder(tmp_path / "car", SCENE)
    shown = exhibits("car", TEST_SEED, 3, 2)
    found = pictures_of(photographs(shown, SCENE, 2), shown, truths(shown), 2)
    assert np.array_equal(found.codes, expected.codes)
    assert np.allclose(found.azimuths, expected.azimuths)
    assert np.array_equal(found.objects, expected.objects)
    for mine, judges in zip(found.truth, expected.truth, strict=True):
        assert np.array_equal(mine.voxels, judges.voxels)
        assert mine.order == judges.order
