"""Pictures whose truth is known: from folders and from mesh files, by one convention."""

import logging
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imaging.srgb import decode_table, encode
from tests.trainer.evaluation.conftest import SCENE
from trainer.config import CameraConfig
from trainer.data.metadata import METADATA_FILE
from trainer.data.picture import draw
from trainer.data.plan import SETTINGS_FILE, RenderSettings
from trainer.data.render import render_folder
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh
from trainer.errors import DataError
from trainer.evaluation.fill import fill
from trainer.evaluation.pictures import Pictures, Validation, from_folder, from_meshes, linear_batches, validation_from


def test_pictures_of_meshes_and_of_a_folder_follow_one_convention(
    tested: Pictures, validation_folder: Path, shapes: list[Mesh]
) -> None:
    """The same object at the same azimuth is the same picture, and both know the same shape."""
    folder = from_folder(validation_folder, SCENE)
    for mine, theirs in zip(folder.truth, tested.truth, strict=True):
        np.testing.assert_array_equal(mine.voxels, theirs.voxels)
        np.testing.assert_array_equal(mine.surface.points, theirs.surface.points)
        assert mine.order == theirs.order == 1
    np.testing.assert_array_equal(folder.objects, np.repeat([0, 1, 2], 6))
    np.testing.assert_array_equal(tested.objects, np.repeat([0, 1, 2], 8))
    np.testing.assert_allclose(np.degrees(tested.azimuths), np.tile(np.arange(-157.5, 180, 45), 3))
    for pictures in (folder, tested):
        assert pictures.light_azimuths is None
        for codes, azimuth, index in zip(pictures.codes, pictures.azimuths, pictures.objects, strict=True):
            np.testing.assert_array_equal(codes, _drawn(shapes[index], azimuth))
            assert np.abs(codes - _drawn(shapes[index], azimuth + math.pi).astype(int)).mean() > 2


def _drawn(mesh: Mesh, azimuth: float) -> np.ndarray:
    return encode(draw(mesh, azimuth, 0.0, SCENE)[0]).transpose(2, 0, 1)


def test_the_truth_is_that_of_the_shapes(tested: Pictures, shapes: list[Mesh]) -> None:
    for truth, shape in zip(tested.truth, shapes, strict=True):
        np.testing.assert_array_equal(truth.voxels, fill(*shape).full)


def test_procedural_truth_is_the_shape_that_the_seed_names(tmp_path: Path) -> None:
    render_folder(tmp_path, RenderSettings("car", seed=4, supersampling=1), SCENE, 2, 2, 1, show_progress=False)
    pictures, validation = from_folder(tmp_path, SCENE), validation_from(tmp_path, SCENE)
    assert validation.voxels is not None
    for index in range(2):
        expected = fill(*make_shape("car", 4_000_000 + index)).full
        np.testing.assert_array_equal(pictures.truth[index].voxels, expected)
        np.testing.assert_array_equal(validation.voxels[index], expected)
    np.testing.assert_array_equal(pictures.objects, [0, 0, 1, 1])
    np.testing.assert_array_equal(validation.codes, pictures.codes)


def test_lights_that_turn_are_known(tmp_path: Path) -> None:
    settings = RenderSettings("car", rotate_lights=True, supersampling=1)
    render_folder(tmp_path, settings, SCENE, 2, 3, 1, show_progress=False)
    lights = from_folder(tmp_path, SCENE).light_azimuths
    assert lights is not None
    assert len(np.unique(lights)) == 6


def test_a_folder_without_the_truth_is_refused(validation_folder: Path, tmp_path: Path) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(validation_folder, folder)
    (folder / SETTINGS_FILE).unlink()
    assert validation_from(folder, SCENE).voxels is None
    with pytest.raises(DataError, match=r"no render\.json, so its shapes are not known\. Expected a folder"):
        from_folder(folder, SCENE)
    (folder / METADATA_FILE).unlink()
    for read in (from_folder, validation_from):
        with pytest.raises(DataError, match=r"no azimuths in metadata\.csv\. Expected a folder"):
            read(folder, SCENE)


def test_mesh_files_that_cannot_be_read_are_named_and_skipped(
    mesh_folder: Path, tested: Pictures, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = tmp_path / "mixed"
    shutil.copytree(mesh_folder, folder)
    (folder / "0a.glb").write_bytes(b"rubbish")
    (folder / "9.obj").write_text("v 0 0 0\n")
    with caplog.at_level(logging.WARNING):
        found = from_meshes(folder, SCENE, 8)
    assert [Path(sentence.split()[0].rstrip(":")).name for sentence in found.skipped] == ["0a.glb", "9.obj"]
    assert [message.startswith("skipped: ") for message in caplog.messages] == [True, True]
    np.testing.assert_array_equal(found.codes, tested.codes)
    np.testing.assert_array_equal(found.objects, tested.objects)
    for path in folder.glob("[0-2].obj"):
        path.unlink()
    with pytest.raises(DataError, match=r"none of the 2 meshes in .* can be read; first: .*0a\.glb"):
        from_meshes(folder, SCENE, 8)


def test_the_camera_is_the_model_s(mesh_folder: Path, tested: Pictures) -> None:
    level = replace(SCENE, camera=CameraConfig(elevation_degrees=0.0))
    assert (from_meshes(mesh_folder, level, 8).codes != tested.codes).any()


def test_batches_are_linear_and_complete(validation: Validation) -> None:
    codes = np.concatenate([validation.codes] * 15)
    batches = list(linear_batches(codes))
    assert [len(batch) for batch in batches] == [256, 14]
    np.testing.assert_array_equal(np.concatenate(batches), decode_table()[codes])
