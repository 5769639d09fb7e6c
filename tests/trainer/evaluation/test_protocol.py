"""The judge against predictors whose figures are known: a perfect one, one with a frame of its own, a wrong one."""

import dataclasses
import json
import math
import shutil
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import torch
import trimesh
from torch import Tensor

from trainer.config import CameraConfig, SceneConfig, TrainConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.metadata import METADATA_FILE
from trainer.data.picture import draw
from trainer.data.plan import SETTINGS_FILE, RenderSettings
from trainer.data.render import render_folder
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh
from trainer.errors import DataError
from trainer.evaluation.protocol import Pictures, as_json, fit_offset, from_folder, from_meshes, judge, mean_of
from trainer.evaluation.voxels import voxelise
from trainer.geometry.conventions import rotation_about_y
from trainer.model.posterior import Posterior, bin_centres
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint

SCENE = SceneConfig(width=40, height=30)
BINS = 12


class Oracle:
    """Knows the pictures: answers each with its true shape and azimuth, in a frame turned by `frame` radians.

    A shape turned by `frame` in its own frame looks as before at an azimuth that is smaller by as much.
    """

    def __init__(
        self, images: Tensor, azimuths: np.ndarray, shapes: list[Mesh], objects: np.ndarray, frame: float
    ) -> None:
        self.faces = torch.tensor(shapes[0].faces)
        self.images, self.frame = images, frame
        self.azimuths = torch.tensor(azimuths - frame, dtype=torch.float32)
        vertices = torch.tensor(np.stack([shape.vertices for shape in shapes]), dtype=torch.float32)
        self.vertices = (vertices @ rotation_about_y(torch.tensor(frame)).T)[torch.tensor(objects)]

    def encode(self, images: Tensor) -> Posterior:
        (number,) = torch.nonzero((images[:, None] == self.images).flatten(2).all(2), as_tuple=True)[1:]
        assert len(number) == len(images)
        azimuth = self.azimuths[number]
        away = torch.remainder(azimuth[:, None] - bin_centres(BINS, azimuth) + math.pi, 2 * math.pi) - math.pi
        fine = away.gather(1, away.abs().argmin(1, keepdim=True)).squeeze(1)
        return Posterior(
            number[:, None].float(), torch.ones(len(number), 1), -away.abs(), fine, torch.ones(len(number))
        )

    def decode(self, shape_code: Tensor) -> Tensor:
        return self.vertices[shape_code.squeeze(1).long()]


def checkpoint_of(oracle: Oracle) -> Checkpoint:
    return Checkpoint(TrainConfig(), SCENE, "car", 1, cast(Model, oracle), {}, {"seconds": 1.0})


def stretched(seed: int) -> Mesh:
    """One shape in several proportions, so that all share their faces; none has a symmetry about +Y."""
    mesh = make_shape("chair", 3)
    x, y, z = mesh.vertices.T
    leaning = np.stack((x + 0.15 * z, y, z), 1) * np.random.default_rng(seed).uniform(0.75, 1, 3)
    return Mesh(leaning, mesh.faces)


@pytest.fixture(scope="module")
def mesh_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("meshes") / "chairs"
    folder.mkdir()
    for seed in range(3):
        trimesh.Trimesh(*stretched(seed), process=False).export(folder / f"{seed}.obj", digits=17)
    return folder


@pytest.fixture(scope="module")
def shapes(mesh_folder: Path) -> list[Mesh]:
    """As the judge reads them: normalised."""
    return [load_mesh(path) for path in mesh_files(mesh_folder)]


@pytest.fixture(scope="module")
def tested(mesh_folder: Path, shapes: list[Mesh]) -> Pictures:
    """Eight pictures of each mesh. The shapes are sound, so their truth can be had as the predictions' occupancy is."""
    pictures = from_meshes(mesh_folder, SCENE, 8)
    return replace(pictures, truth=[voxelise(*shape) for shape in shapes])


@pytest.fixture(scope="module")
def validation_folder(tmp_path_factory: pytest.TempPathFactory, mesh_folder: Path) -> Path:
    folder = tmp_path_factory.mktemp("validation") / "pictures"
    render_folder(folder, RenderSettings(str(mesh_folder), seed=1), SCENE, None, 6, 1, show_progress=False)
    return folder


@pytest.fixture(scope="module")
def validation(validation_folder: Path) -> ImageSet:
    return load_image_folder(validation_folder, SCENE.width, SCENE.height)


def oracle_for(pictures: Pictures, shapes: list[Mesh], frame: float) -> Checkpoint:
    return checkpoint_of(Oracle(pictures.images, pictures.azimuths, shapes, pictures.objects, frame))


def validating_oracle(images: ImageSet, shapes: list[Mesh], frame: float) -> Checkpoint:
    assert images.azimuths is not None
    everything = images.batch(np.arange(len(images)))
    return checkpoint_of(Oracle(everything, images.azimuths, shapes, images.instances, frame))


@pytest.mark.parametrize("frame_degrees", [0.0, 70.0, -160.0])
def test_a_perfect_predictor_scores_perfectly_whatever_its_frame(
    tested: Pictures, validation: ImageSet, shapes: list[Mesh], frame_degrees: float
) -> None:
    frame = math.radians(frame_degrees)
    offset = fit_offset(validating_oracle(validation, shapes, frame), validation)
    assert offset == pytest.approx(frame, abs=1e-5)
    report = judge(oracle_for(tested, shapes, frame), tested, offset, None)
    assert (report.objects, report.pictures, report.mean_shape_iou) == (3, 24, None)
    # To the rounding of vertices in single precision, which may move a surface over the centre of a voxel.
    assert report.iou.value == pytest.approx(1, abs=0.003)
    assert report.iou.low <= report.iou.value <= report.iou.high
    assert report.azimuth_error_degrees.value < 1e-3
    assert report.azimuth_accuracy == (1.0, 1.0, 1.0)
    assert report.flipped == 0
    assert report.azimuth_offset_degrees == pytest.approx(frame_degrees, abs=1e-3)
    # Corner normals of the data are sharp at creases, those of a model are smooth: shading differs, outlines do not.
    assert report.picture_error < 0.02


def test_a_wrong_sign_of_the_offset_would_fail(tested: Pictures, shapes: list[Mesh]) -> None:
    frame = math.radians(70)
    right, wrong = (judge(oracle_for(tested, shapes, frame), tested, sign * frame, None) for sign in (1, -1))
    assert wrong.azimuth_error_degrees.value == pytest.approx(140, abs=1e-3)
    assert wrong.azimuth_accuracy.value == 0
    assert wrong.iou.value < 0.6 * right.iou.value


def test_errors_are_counted_in_azimuth_and_shape_apart(tested: Pictures, shapes: list[Mesh]) -> None:
    """A quarter of the pictures is taken for their own backs; every shape is right."""
    oracle = Oracle(tested.images, tested.azimuths, shapes, tested.objects, 0.0)
    oracle.azimuths[::4] += math.pi
    report = judge(checkpoint_of(oracle), tested, 0.0, None)
    assert report.flipped == 0.25
    assert report.azimuth_accuracy.value == 0.75
    assert report.azimuth_error_degrees.value < 1e-3
    assert report.iou.value == pytest.approx(1, abs=0.003)


def test_another_shape_is_a_worse_one(tested: Pictures, shapes: list[Mesh]) -> None:
    oracle = Oracle(tested.images, tested.azimuths, shapes, np.roll(tested.objects, 8), 0.0)
    report = judge(checkpoint_of(oracle), tested, 0.0, tested.truth[0])
    a, b, c = tested.truth
    assert report.iou.value == pytest.approx((overlap(a, b) + overlap(b, c) + overlap(c, a)) / 3, abs=0.003)
    assert report.iou.value < 0.7
    assert report.azimuth_accuracy.value == 1
    assert report.mean_shape_iou == pytest.approx((1 + overlap(a, b) + overlap(a, c)) / 3)


def overlap(first: np.ndarray, second: np.ndarray) -> float:
    return float((first & second).sum() / (first | second).sum())


def test_the_truth_of_mesh_files_is_theirs_as_a_solid(mesh_folder: Path, shapes: list[Mesh]) -> None:
    """Made for meshes as they are found, and within a tenth of the winding number's on sound and slender ones."""
    for found, shape in zip(from_meshes(mesh_folder, SCENE, 1).truth, shapes, strict=True):
        assert overlap(found, voxelise(*shape)) > 0.9


def test_pictures_of_meshes_and_of_a_folder_follow_one_convention(
    mesh_folder: Path, validation_folder: Path, shapes: list[Mesh]
) -> None:
    """The same object at the same azimuth is the same picture, and both know the same shape."""
    meshes = from_meshes(mesh_folder, SCENE, 8)
    folder = from_folder(validation_folder, SCENE)
    for mine, theirs in zip(folder.truth, meshes.truth, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(folder.objects, np.repeat([0, 1, 2], 6))
    np.testing.assert_array_equal(meshes.objects, np.repeat([0, 1, 2], 8))
    np.testing.assert_allclose(np.degrees(meshes.azimuths), np.tile(np.arange(-157.5, 180, 45), 3))
    for pictures in (folder, meshes):
        for image, azimuth, index in zip(pictures.images, pictures.azimuths, pictures.objects, strict=True):
            # Files hold 8 bits a channel.
            assert (image - _drawn(shapes[index], azimuth)).abs().max() < 0.01
            assert (image - _drawn(shapes[index], azimuth + math.pi)).abs().mean() > 0.01


def _drawn(mesh: Mesh, azimuth: float) -> Tensor:
    return torch.from_numpy(draw(mesh, azimuth, 0.0, SCENE)[0]).permute(2, 0, 1)


def test_procedural_truth_is_the_shape_that_the_seed_names(tmp_path: Path) -> None:
    render_folder(tmp_path, RenderSettings("car", seed=4, supersampling=1), SCENE, 2, 2, 1, show_progress=False)
    pictures = from_folder(tmp_path, SCENE)
    for index in range(2):
        np.testing.assert_array_equal(pictures.truth[index], voxelise(*make_shape("car", 4_000_000 + index)))
    np.testing.assert_array_equal(pictures.objects, [0, 0, 1, 1])
    images = load_image_folder(tmp_path, SCENE.width, SCENE.height)
    mean = mean_of(tmp_path, images)
    assert mean is not None
    assert mean.any()
    assert (mean <= (pictures.truth[0] | pictures.truth[1])).all()


def test_a_folder_without_the_truth_is_refused(validation_folder: Path, tmp_path: Path, validation: ImageSet) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(validation_folder, folder)
    (folder / SETTINGS_FILE).unlink()
    assert mean_of(folder, validation) is None
    with pytest.raises(DataError, match=r"no render\.json, so its shapes are not known\. Expected a folder"):
        from_folder(folder, SCENE)
    (folder / METADATA_FILE).unlink()
    with pytest.raises(DataError, match=r"no azimuths in metadata\.csv\. Expected a folder"):
        from_folder(folder, SCENE)
    with pytest.raises(DataError, match=r"metadata\.csv names none\. Render some with"):
        fit_offset(checkpoint_of(cast(Oracle, None)), replace(validation, azimuths=None))


def test_the_report_is_plain_json(tested: Pictures, shapes: list[Mesh]) -> None:
    report = judge(oracle_for(tested, shapes, 0.0), tested, 0.0, None)
    flat = json.loads(json.dumps(as_json(report), allow_nan=False))
    intervals = {"iou", "azimuth_error_degrees", "azimuth_accuracy"}
    assert flat.keys() == {field.name for field in dataclasses.fields(report)} | {
        f"{name}_interval" for name in intervals
    }
    assert flat["azimuth_accuracy_interval"] == [1.0, 1.0]
    assert flat["mean_shape_iou"] is None


def test_the_camera_of_the_judge_is_the_checkpoint_s(mesh_folder: Path) -> None:
    level = replace(SCENE, camera=CameraConfig(elevation_degrees=0.0))
    assert (from_meshes(mesh_folder, level, 1).images != from_meshes(mesh_folder, SCENE, 1).images).any()
