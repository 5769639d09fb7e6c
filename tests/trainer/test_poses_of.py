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
from trainer.commands import teaching
from trainer.commands import train as train_command
from trainer.commands.render import RenderCommand
from trainer.commands.teaching import (
    POSES_FILE,
    UNKNOWN_FILE,
    kept_pictures,
    kept_poses,
    teacher_at,
    told_poses,
    unknown_pictures,
)
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.picture import rotation_about_y
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


def test_the_poses_are_those_that_the_teacher_sees_from_its_mirror(folder: Path, teacher: Path) -> None:
    """Objects whose frame is turned back by as much look the same."""
    images, subject = pictures(folder), teacher_at(teacher)
    prediction = predict(subject, images.pictures)
    turn = mirror_plane(prediction.vertices.numpy(), subject.faces.numpy())
    assert abs(turn) > 0.05
    told = told_poses(images, folder, subject, False, QUIET)
    assert told.azimuths is not None
    assert images.azimuths is not None
    np.testing.assert_allclose(np.exp(1j * told.azimuths), np.exp(1j * (prediction.azimuths.numpy() + turn)), atol=1e-6)
    assert np.abs(told.azimuths).max() <= math.pi
    assert np.abs(np.exp(1j * told.azimuths) - np.exp(1j * images.azimuths)).max() > 0.1


def test_what_stands_back_to_front_is_turned_round(
    folder: Path, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    images, subject = pictures(folder), teacher_at(teacher)
    turned = np.arange(len(images)) % 3 == 1
    monkeypatch.setattr(teaching, "back_to_front", lambda shapes, faces: turned)
    found, alike = (told_poses(images, folder, subject, alike, QUIET).azimuths for alike in (False, True))
    assert found is not None
    assert alike is not None
    np.testing.assert_allclose(np.exp(1j * alike), np.where(turned, -1, 1) * np.exp(1j * found), atol=1e-6)


def test_fronts_are_settled_of_shapes_in_their_mirror(
    folder: Path, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    images, subject, seen = pictures(folder), teacher_at(teacher), []

    def look(shapes: np.ndarray, faces: np.ndarray) -> np.ndarray:
        seen.append(mirror_plane(shapes, faces))
        return np.zeros(len(shapes), np.bool_)

    monkeypatch.setattr(teaching, "back_to_front", look)
    told_poses(images, folder, subject, True, QUIET)
    assert abs(seen[0]) < math.radians(2)


@pytest.mark.parametrize("turn", [0.3, 0.3 + math.pi])
def test_a_second_teacher_tells_what_the_first_does_not_understand(
    folder: Path, teacher: Path, monkeypatch: pytest.MonkeyPatch, turn: float
) -> None:
    """It sees what the first does, in another frame, of six of eight; two it tells otherwise."""
    images, subject = pictures(folder), teacher_at(teacher)
    chosen = np.isin(np.arange(len(images)), (1, 4))
    monkeypatch.setattr(teaching, "unknown", lambda *given: chosen)
    first = predict(subject, images.pictures)
    shapes = torch.from_numpy(first.vertices.numpy() @ rotation_about_y(turn)).float()
    second = first._replace(azimuths=first.azimuths + turn + 2 * torch.from_numpy(chosen), vertices=shapes)
    answers = iter([first, second])
    alone = told_poses(images, folder, subject, False, QUIET).azimuths
    monkeypatch.setattr(teaching, "predict", lambda *given: next(answers))
    told = told_poses(images, folder, subject, False, QUIET, teacher_at(teacher)).azimuths
    assert alone is not None
    assert told is not None
    # To what a plane of symmetry is found to, of two shapes and of eight.
    mirrors = (mirror_plane(made.numpy(), subject.faces.numpy()) for made in (first.vertices, shapes[chosen]))
    found, theirs = mirrors
    beside = (theirs + turn - found + math.pi / 2) % math.pi - math.pi / 2
    np.testing.assert_allclose(np.exp(1j * told), np.exp(1j * (alone + (2 + beside) * chosen)), atol=1e-6)
    np.testing.assert_array_equal(told[~chosen], alone[~chosen])


def test_what_a_second_teacher_tells_is_not_turned_round(
    folder: Path, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    images, subject = pictures(folder), teacher_at(teacher)
    chosen, turned = np.arange(len(images)) < 2, np.arange(len(images)) % 2 == 1
    monkeypatch.setattr(teaching, "unknown", lambda *given: chosen)
    monkeypatch.setattr(teaching, "back_to_front", lambda shapes, faces: turned)
    found, alike = (told_poses(images, folder, subject, alike, QUIET, subject).azimuths for alike in (False, True))
    assert found is not None
    assert alike is not None
    signs = np.where(turned & ~chosen, -1, 1)
    np.testing.assert_allclose(np.exp(1j * alike), signs * np.exp(1j * found), atol=1e-6)


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
        capsys, "train", "--images", own, "--run", tmp_path / "run", "--poses-of", teacher.name, "--fronts", "alike",
        "--class", "car", "--model.symmetry", "mirror", "--optimiser.steps", "2", "--reframing-share", "0",
        *SMALL, *OPTIONS,
    )  # fmt: skip
    assert (status, "told the poses that a former training finds" in errors) == (0, True), errors
    assert "of 8 objects are turned round" in errors
    monkeypatch.chdir("/")
    told: list[ImageSet] = []
    monkeypatch.setattr(train_command, "kept_poses", lambda *given: told.append(kept_poses(*given)) or told[0])
    # Its teacher is needed no more: another one may stand in its place by then.
    monkeypatch.setattr(train_command, "teacher_at", lambda path: pytest.fail("asked again"))
    again = ["--run", tmp_path / "run", "--resume", "--optimiser.steps", "3", "--reframing-share", "0"]
    status, _, errors = answer(capsys, "train", *again)
    assert status == 0, errors
    expected = told_poses(pictures(folder), folder, teacher_at(teacher), True, QUIET).azimuths
    np.testing.assert_array_equal(told[0].azimuths, expected)
    for option in (["--fronts", "found"], ["--poses-of", tmp_path / "another"]):
        status, _, errors = answer(capsys, "train", *again, *option)
        assert (status, "Leave such options away" in errors) == (2, True), errors
    run = load_checkpoint(tmp_path / "run")
    assert (run.step, run.config.loss.pose_supervision) == (3, "azimuth")
    assert (run.run["poses_of"], run.run["fronts"]) == (str(teacher), "alike")


def test_a_training_on_what_another_does_not_understand_goes_on_so(
    folder: Path, teacher: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And tells a third one the poses in those pictures."""
    chosen = np.arange(8) % 4 != 0
    monkeypatch.setattr(teaching, "unknown", lambda *given: chosen)
    few = ["--images", folder, "--class", "car", "--optimiser.steps", "2", "--reframing-share", "0", *SMALL, *OPTIONS]
    second = tmp_path / "second"
    status, _, errors = answer(capsys, "train", "--run", second, "--unknown-to", teacher, *few)
    assert (status, "6 of them are trained on, of which a former training" in errors) == (0, True), errors
    names = [name for name, one in zip(pictures(folder).names, chosen, strict=True) if one]
    assert (second / UNKNOWN_FILE).read_text().split() == names
    kept: list[ImageSet] = []
    monkeypatch.setattr(train_command, "kept_pictures", lambda *given: kept.append(kept_pictures(*given)) or kept[0])
    monkeypatch.setattr(train_command, "unknown_pictures", lambda *given: pytest.fail("asked again"))
    again = ["--run", second, "--resume", "--optimiser.steps", "3", "--reframing-share", "0"]
    status, _, errors = answer(capsys, "train", *again)
    assert status == 0, errors
    assert list(kept[0].names) == names
    assert load_checkpoint(second).run["unknown_to"] == str(teacher)
    status, _, errors = answer(capsys, "train", *again, "--unknown-to", tmp_path)
    assert (status, "Leave such options away" in errors) == (2, True), errors

    third = ["--run", tmp_path / "third", "--poses-of", teacher, "--unknown-poses-of", second]
    status, _, errors = answer(capsys, "train", *third, *few)
    assert (status, "6 of them a second one tells" in errors) == (0, True), errors
    assert load_checkpoint(tmp_path / "third").run["unknown_poses_of"] == str(second)


def test_some_pictures_keep_what_is_known_of_them(folder: Path, teacher: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(teaching, "unknown", lambda *given: np.isin(np.arange(8), (2, 5)))
    images = pictures(folder)
    some = unknown_pictures(images, folder, teacher_at(teacher), QUIET)
    assert images.azimuths is not None
    assert some.azimuths is not None
    assert some.light_azimuths is not None
    assert some.names == (images.names[2], images.names[5])
    assert some.instance_names == (images.instance_names[2], images.instance_names[5])
    assert some.instances.tolist() == [0, 1]
    np.testing.assert_array_equal(some.azimuths, images.azimuths[[2, 5]])
    np.testing.assert_array_equal(some.pictures, images.pictures[[2, 5]])


@pytest.mark.parametrize(
    ("text", "found"), [(None, "No such file"), ("a,b\n", "values to unpack"), ("car/a.png\n", "found 1 that are not")]
)
def test_names_that_are_not_those_of_the_pictures_are_refused(
    folder: Path, tmp_path: Path, text: str | None, found: str
) -> None:
    if text is not None:
        (tmp_path / UNKNOWN_FILE).write_text(text)
    with pytest.raises(DataError, match=found):
        kept_pictures(pictures(folder), tmp_path)


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
    folder: Path, tmp_path: Path, text: str | None, found: str
) -> None:
    if text is not None:
        (tmp_path / POSES_FILE).write_text(text)
    with pytest.raises(DataError, match=found):
        kept_poses(pictures(folder), tmp_path)


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


def test_fronts_are_turned_only_of_poses_that_are_told(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, errors = answer(capsys, "train", "--images", folder, "--run", tmp_path / "run", "--fronts", "alike")
    assert (status, "only beside --poses-of RUN" in errors) == (2, True), errors


@pytest.mark.parametrize(
    ("options", "found"),
    [
        (["--class", "car", "--unknown-to", "RUN"], "found other pictures"),
        (["--images", "FOLDER", "--unknown-to", "RUN", "--poses-of", "RUN"], "found --poses-of"),
        (["--images", "FOLDER", "--unknown-poses-of", "RUN"], "only beside --poses-of RUN"),
    ],
)
def test_what_another_does_not_understand_stands_where_it_belongs(
    options: list[str], found: str, folder: Path, teacher: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    named = [{"RUN": str(teacher), "FOLDER": str(folder)}.get(option, option) for option in options]
    status, _, errors = answer(capsys, "train", *named, "--run", tmp_path / "run")
    assert (status, found in errors) == (2, True), errors
    assert not (tmp_path / "run").exists()


def test_no_teacher_is_an_error_that_says_so(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="nowhere"):
        teacher_at(tmp_path / "nowhere")


def test_a_bundle_can_teach(tmp_path: Path) -> None:
    folder, teacher = tmp_path / "pictures", teacher_at(Path(__file__).parents[2] / "models" / "car")
    RenderCommand(folder, category="car", instances=8, workers=1).run()
    told = told_poses(load_image_folder(folder, WIDTH, HEIGHT), folder, teacher, False, QUIET)
    with (folder / "metadata.csv").open() as lines:
        truth = {row["file_name"]: math.radians(float(row["azimuth_degrees"])) for row in csv.DictReader(lines)}
    assert told.azimuths is not None
    errors = np.angle(np.exp(1j * (told.azimuths - [truth[name] for name in told.names])))
    # Their mirror lies along them: at most half a turn is left.
    assert np.median(np.abs(np.angle(np.exp(2j * errors)))) < math.radians(20)
