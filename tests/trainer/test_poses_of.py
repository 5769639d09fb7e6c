"""`trainer train --poses-of`: a training that is told what a former one found."""

import csv
import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from rich.console import Console

from tests.trainer.command_line import SMALL, answer
from tests.trainer.new_model import HEIGHT, WIDTH, new_model, save_model
from trainer.commands.render import RenderCommand
from trainer.commands.teaching import teacher_at, told_poses
from trainer.data.images import ImageSet, load_image_folder
from trainer.errors import CheckpointError, DataError
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.subject import predict
from trainer.training.checkpoint import load_checkpoint

QUIET = Console(file=io.StringIO())
OPTIONS = ["--optimiser.batch-size", "4", "--threads", "1", "--model.encoder-channels", "4", "4", "4", "4", "4", "8"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("told") / "pictures"
    RenderCommand(path, category="car", instances=8, width=WIDTH, height=HEIGHT, workers=1).run()
    return path


@pytest.fixture(scope="module")
def teacher(folder: Path) -> Path:
    save_model(folder.parent / "teacher.safetensors", new_model())
    return folder.parent / "teacher.safetensors"


def pictures(folder: Path) -> ImageSet:
    return load_image_folder(folder, WIDTH, HEIGHT)


def test_the_poses_are_those_that_the_teacher_sees(folder: Path, teacher: Path) -> None:
    images, subject = pictures(folder), teacher_at(teacher)
    seen = predict(subject, images.pictures).azimuths.numpy()
    told = told_poses(images, folder, subject, False, QUIET)
    np.testing.assert_allclose(told.azimuths, seen, atol=1e-6)
    assert images.azimuths is not None
    assert np.abs(images.azimuths - seen).max() > 0.1


def test_of_mirrored_shapes_they_are_told_from_the_mirror(folder: Path, teacher: Path) -> None:
    """Objects whose frame is turned back by as much look the same."""
    images, subject = pictures(folder), teacher_at(teacher)
    plain, told = (told_poses(images, folder, subject, mirrored, QUIET).azimuths for mirrored in (False, True))
    assert plain is not None
    assert told is not None
    turn = mirror_plane(predict(subject, images.pictures).vertices.numpy(), subject.faces.numpy())
    assert abs(turn) > 0.05
    np.testing.assert_allclose(np.exp(1j * told), np.exp(1j * (plain + turn)), atol=1e-6)
    assert np.abs(told).max() <= math.pi


def test_a_picture_that_the_teacher_cannot_use_is_named(folder: Path, teacher: Path) -> None:
    images = pictures(folder)
    another = replace(images, names=("car/another.png", *images.names[1:]))
    with pytest.raises(DataError, match=r"found 1 that .* the first car/another\.png"):
        told_poses(another, folder, teacher_at(teacher), False, QUIET)


def test_a_training_is_told_and_goes_on_so(
    folder: Path, teacher: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What metadata.csv says of azimuths, or does not, is nothing to it."""
    own = tmp_path / "own"
    own.symlink_to(folder)
    monkeypatch.chdir(teacher.parent)
    status, _, errors = answer(
        capsys, "train", "--images", own, "--run", tmp_path / "run", "--poses-of", teacher.name, "--class", "car",
        "--model.symmetry", "mirror", "--optimiser.steps", "2", "--reframing-share", "0", *SMALL, *OPTIONS,
    )  # fmt: skip
    assert (status, "told the poses that a former training finds, mirrored in" in errors) == (0, True), errors
    monkeypatch.chdir("/")
    status, _, errors = answer(
        capsys, "train", "--run", tmp_path / "run", "--resume", "--optimiser.steps", "3", "--reframing-share", "0"
    )
    assert (status, "told the poses" in errors) == (0, True), errors
    run = load_checkpoint(tmp_path / "run")
    assert (run.step, run.config.loss.pose_supervision) == (3, "azimuth")
    assert run.run["poses_of"] == str(teacher)


def test_it_differs_from_one_that_is_told_the_truth(
    folder: Path, teacher: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = {}
    for name, option in (("told", ["--poses-of", teacher]), ("true", ["--loss.pose-supervision", "azimuth"])):
        status, _, errors = answer(
            capsys, "train", "--images", folder, "--run", tmp_path / name, *option, "--class", "car",
            "--optimiser.steps", "1", "--reframing-share", "0", *SMALL, *OPTIONS,
        )  # fmt: skip
        assert status == 0, errors
        runs[name] = load_checkpoint(tmp_path / name).model.state_dict()
    weights = runs["told"]["heads.azimuth_logits.bias"], runs["true"]["heads.azimuth_logits.bias"]
    assert not torch.equal(*weights)


@pytest.mark.parametrize("pictures", [["--class", "car"], ["--shards", "here"]])
def test_only_pictures_in_a_folder_are_told_of(
    pictures: list[str], teacher: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, errors = answer(capsys, "train", *pictures, "--run", tmp_path / "run", "--poses-of", teacher)
    assert (status, "only beside --images DIR" in errors) == (2, True), errors
    assert not (tmp_path / "run").exists()


def test_no_teacher_is_an_error_that_says_so(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="nowhere"):
        teacher_at(tmp_path / "nowhere")


def test_a_bundle_can_teach(folder: Path) -> None:
    images = pictures(folder)
    told = told_poses(images, folder, teacher_at(Path(__file__).parents[2] / "models" / "car"), True, QUIET)
    with (folder / "metadata.csv").open() as lines:
        truth = {row["file_name"]: math.radians(float(row["azimuth_degrees"])) for row in csv.DictReader(lines)}
    assert told.azimuths is not None
    errors = np.angle(np.exp(1j * (told.azimuths - [truth[name] for name in told.names])))
    # Their mirror lies along them: at most half a turn is left.
    assert np.median(np.abs(np.angle(np.exp(2j * errors)))) < math.radians(20)
