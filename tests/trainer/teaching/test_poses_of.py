"""`trainer train --poses-of`: a training that is told what a former one found."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.command_line import SMALL, answer
from tests.trainer.new_model import HEIGHT, WIDTH
from tests.trainer.teaching.short import QUIET, SHORT
from trainer.commands import former, teaching
from trainer.commands.render import RenderCommand
from trainer.commands.teaching import POSES_FILE, kept_poses, teacher_at, told_poses
from trainer.data.images import ImageSet, load_image_folder
from trainer.errors import CheckpointError, DataError
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.subject import predict
from trainer.training.checkpoint import load_checkpoint


def test_the_poses_are_those_that_the_teacher_sees_from_its_mirror(
    folder: Path, images: ImageSet, teacher: Path
) -> None:
    """Objects whose frame is turned back by as much look the same."""
    subject = teacher_at(teacher)
    prediction = predict(subject, images.pictures)
    turn = mirror_plane(prediction.vertices.numpy(), subject.faces.numpy())
    assert abs(turn) > 0.05
    told = told_poses(images, folder, subject, "found", QUIET)
    assert told.azimuths is not None
    assert images.azimuths is not None
    np.testing.assert_allclose(np.exp(1j * told.azimuths), np.exp(1j * (prediction.azimuths.numpy() + turn)), atol=1e-6)
    assert np.abs(told.azimuths).max() <= math.pi
    assert np.abs(np.exp(1j * told.azimuths) - np.exp(1j * images.azimuths)).max() > 0.1


def test_what_stands_back_to_front_is_turned_round(
    folder: Path, images: ImageSet, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    subject = teacher_at(teacher)
    turned = np.arange(len(images)) % 3 == 1
    monkeypatch.setattr(teaching, "back_to_front", lambda shapes, faces: turned)
    found, alike = (told_poses(images, folder, subject, fronts, QUIET).azimuths for fronts in ("found", "alike"))
    assert found is not None
    assert alike is not None
    np.testing.assert_allclose(np.exp(1j * alike), np.where(turned, -1, 1) * np.exp(1j * found), atol=1e-6)


def test_what_stands_by_quarters_beside_the_others_is_turned_back(
    folder: Path, images: ImageSet, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A shape that is turned left-handedly is seen from as much farther round."""
    subject, quarters = teacher_at(teacher), np.arange(len(images)) % 4
    monkeypatch.setattr(teaching, "quarter_turns", lambda shapes, faces: quarters)
    found, turned = (told_poses(images, folder, subject, fronts, QUIET).azimuths for fronts in ("found", "quarters"))
    assert found is not None
    assert turned is not None
    np.testing.assert_allclose(np.exp(1j * turned), 1j**quarters * np.exp(1j * found), atol=1e-6)
    assert np.abs(turned).max() <= math.pi


def test_fronts_are_settled_of_shapes_in_their_mirror(
    folder: Path, images: ImageSet, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    subject, seen = teacher_at(teacher), []

    def look(shapes: np.ndarray, faces: np.ndarray) -> np.ndarray:
        seen.append(mirror_plane(shapes, faces))
        return np.zeros(len(shapes), np.bool_)

    monkeypatch.setattr(teaching, "back_to_front", look)
    told_poses(images, folder, subject, "alike", QUIET)
    assert abs(seen[0]) < math.radians(2)


def test_a_picture_that_the_teacher_cannot_use_is_named(folder: Path, images: ImageSet, teacher: Path) -> None:
    another = replace(images, names=("car/another.png", *images.names[1:]))
    with pytest.raises(DataError, match=r"found 1 that .* the first car/another\.png"):
        told_poses(another, folder, teacher_at(teacher), "found", QUIET)


def test_a_training_is_told_and_goes_on_so(
    folder: Path,
    images: ImageSet,
    teacher: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What metadata.csv says of azimuths, or does not, is nothing to it."""
    own = tmp_path / "own"
    own.symlink_to(folder)
    monkeypatch.chdir(teacher.parent)
    status, _, errors = answer(
        capsys, "train", "--images", own, "--run", tmp_path / "run", "--poses-of", teacher.name, "--fronts", "alike",
        "--class", "car", "--model.symmetry", "mirror", "--optimiser.steps", "2", "--reframing-share", "0",
        *SMALL, *SHORT,
    )  # fmt: skip
    assert (status, "told the poses that a former training finds" in errors) == (0, True), errors
    assert "of 8 objects are turned round" in errors
    monkeypatch.chdir("/")
    told: list[ImageSet] = []
    monkeypatch.setattr(former, "kept_poses", lambda *given: told.append(kept_poses(*given)) or told[0])
    # Its teacher is needed no more: another one may stand in its place by then.
    monkeypatch.setattr(former, "teacher_at", lambda path: pytest.fail("asked again"))
    again = ["--run", tmp_path / "run", "--resume", "--optimiser.steps", "3", "--reframing-share", "0"]
    status, _, errors = answer(capsys, "train", *again)
    assert status == 0, errors
    expected = told_poses(images, folder, teacher_at(teacher), "alike", QUIET).azimuths
    np.testing.assert_array_equal(told[0].azimuths, expected)
    for option in (["--fronts", "found"], ["--poses-of", tmp_path / "another"]):
        status, _, errors = answer(capsys, "train", *again, *option)
        assert (status, "Leave such options away" in errors) == (2, True), errors
    run = load_checkpoint(tmp_path / "run")
    assert (run.step, run.config.loss.pose_supervision) == (3, "azimuth")
    assert (run.run["poses_of"], run.run["fronts"]) == (str(teacher), "alike")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (None, "No such file"),
        ("car/a.png,much\n", "much"),
        ("", "not enough values"),
        ("car/a.png,0.5\n", "of others, 1"),
    ],
)
def test_poses_that_are_not_those_of_the_pictures_are_refused(
    images: ImageSet, tmp_path: Path, text: str | None, found: str
) -> None:
    if text is not None:
        (tmp_path / POSES_FILE).write_text(text)
    with pytest.raises(DataError, match=found):
        kept_poses(images, tmp_path)


def test_it_differs_from_one_that_is_told_the_truth(
    folder: Path, teacher: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = {}
    for name, option in (("told", ["--poses-of", teacher]), ("true", ["--loss.pose-supervision", "azimuth"])):
        status, _, errors = answer(
            capsys, "train", "--images", folder, "--run", tmp_path / name, *option, "--class", "car",
            "--optimiser.steps", "1", "--reframing-share", "0", *SMALL, *SHORT,
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


def test_fronts_are_turned_only_of_poses_that_are_told(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, errors = answer(capsys, "train", "--images", folder, "--run", tmp_path / "run", "--fronts", "alike")
    assert (status, "only beside --poses-of RUN" in errors) == (2, True), errors


def test_no_teacher_is_an_error_that_says_so(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="nowhere"):
        teacher_at(tmp_path / "nowhere")


def test_a_bundle_can_teach(tmp_path: Path) -> None:
    folder, teacher = tmp_path / "pictures", teacher_at(Path(__file__).parents[3] / "models" / "car")
    RenderCommand(folder, category="car", instances=8, workers=1).run()
    told = told_poses(load_image_folder(folder, WIDTH, HEIGHT), folder, teacher, "found", QUIET)
    with (folder / "metadata.csv").open() as lines:
        truth = {row["file_name"]: math.radians(float(row["azimuth_degrees"])) for row in csv.DictReader(lines)}
    assert told.azimuths is not None
    errors = np.angle(np.exp(1j * (told.azimuths - [truth[name] for name in told.names])))
    # Their mirror lies along them: at most half a turn is left.
    assert np.median(np.abs(np.angle(np.exp(2j * errors)))) < math.radians(20)
