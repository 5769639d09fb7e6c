"""`trainer train --unknown-to` and `--unknown-poses-of`: what a former training does not understand."""

import math
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.command_line import SMALL, answer
from tests.trainer.teaching.short import QUIET, SHORT
from trainer.commands import former, teaching
from trainer.commands.teaching import UNKNOWN_FILE, kept_pictures, teacher_at, told_poses, unknown_pictures
from trainer.data.images import ImageSet
from trainer.data.picture import rotation_about_y
from trainer.errors import DataError
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.subject import predict
from trainer.training.checkpoint import load_checkpoint


@pytest.mark.parametrize("turn", [0.3, 0.3 + math.pi])
def test_a_second_teacher_tells_what_the_first_does_not_understand(
    folder: Path, images: ImageSet, teacher: Path, monkeypatch: pytest.MonkeyPatch, turn: float
) -> None:
    """It sees what the first does, in another frame, of six of eight; two it tells otherwise."""
    subject = teacher_at(teacher)
    chosen = np.isin(np.arange(len(images)), (1, 4))
    monkeypatch.setattr(teaching, "unknown", lambda *given: chosen)
    first = predict(subject, images.pictures)
    shapes = torch.from_numpy(first.vertices.numpy() @ rotation_about_y(turn)).float()
    second = first._replace(azimuths=first.azimuths + turn + 2 * torch.from_numpy(chosen), vertices=shapes)
    answers = iter([first, second])
    alone = told_poses(images, folder, subject, "found", QUIET).azimuths
    monkeypatch.setattr(teaching, "predict", lambda *given: next(answers))
    told = told_poses(images, folder, subject, "found", QUIET, teacher_at(teacher)).azimuths
    assert alone is not None
    assert told is not None
    # To what a plane of symmetry is found to, of two shapes and of eight.
    mirrors = (mirror_plane(made.numpy(), subject.faces.numpy()) for made in (first.vertices, shapes[chosen]))
    found, theirs = mirrors
    beside = (theirs + turn - found + math.pi / 2) % math.pi - math.pi / 2
    np.testing.assert_allclose(np.exp(1j * told), np.exp(1j * (alone + (2 + beside) * chosen)), atol=1e-6)
    np.testing.assert_array_equal(told[~chosen], alone[~chosen])


def test_what_a_second_teacher_tells_is_not_turned_round(
    folder: Path, images: ImageSet, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    subject = teacher_at(teacher)
    chosen, turned = np.arange(len(images)) < 2, np.arange(len(images)) % 2 == 1
    monkeypatch.setattr(teaching, "unknown", lambda *given: chosen)
    monkeypatch.setattr(teaching, "back_to_front", lambda shapes, faces: turned)
    found, alike = (
        told_poses(images, folder, subject, fronts, QUIET, subject).azimuths for fronts in ("found", "alike")
    )
    assert found is not None
    assert alike is not None
    signs = np.where(turned & ~chosen, -1, 1)
    np.testing.assert_allclose(np.exp(1j * alike), signs * np.exp(1j * found), atol=1e-6)


def test_a_training_on_what_another_does_not_understand_goes_on_so(
    folder: Path,
    images: ImageSet,
    teacher: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And tells a third one the poses in those pictures."""
    chosen = np.arange(8) % 4 != 0
    monkeypatch.setattr(teaching, "unknown", lambda *given: chosen)
    few = ["--images", folder, "--class", "car", "--optimiser.steps", "2", "--reframing-share", "0", *SMALL, *SHORT]
    second = tmp_path / "second"
    status, _, errors = answer(capsys, "train", "--run", second, "--unknown-to", teacher, *few)
    assert (status, "6 of them are trained on, of which a former training" in errors) == (0, True), errors
    names = [name for name, one in zip(images.names, chosen, strict=True) if one]
    assert (second / UNKNOWN_FILE).read_text().split() == names
    kept: list[ImageSet] = []
    monkeypatch.setattr(former, "kept_pictures", lambda *given: kept.append(kept_pictures(*given)) or kept[0])
    monkeypatch.setattr(former, "unknown_pictures", lambda *given: pytest.fail("asked again"))
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


def test_some_pictures_keep_what_is_known_of_them(
    folder: Path, images: ImageSet, teacher: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(teaching, "unknown", lambda *given: np.isin(np.arange(8), (2, 5)))
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
    images: ImageSet, tmp_path: Path, text: str | None, found: str
) -> None:
    if text is not None:
        (tmp_path / UNKNOWN_FILE).write_text(text)
    with pytest.raises(DataError, match=found):
        kept_pictures(images, tmp_path)


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
