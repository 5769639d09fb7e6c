"""What former trainings found, for another one: poses that it is told, or pictures that they do not understand."""

import csv
import io
import math
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from rich.console import Console

from trainer.data.images import ImageSet
from trainer.data.picture import rotation_about_y
from trainer.data.writing import write_bytes
from trainer.errors import DataError
from trainer.evaluation.bundle import MANIFEST_FILE, from_bundle
from trainer.evaluation.fronts import back_to_front
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.pictures import load_as_seen
from trainer.evaluation.quarters import quarter_turns
from trainer.evaluation.self_consistency import doubts, unknown
from trainer.evaluation.subject import Subject, from_checkpoint, predict
from trainer.training.checkpoint import load_checkpoint

Fronts = Literal["found", "alike", "quarters"]

POSES_FILE = "poses.csv"
"""In a run directory: what its training was told, radians. A training that is resumed needs its teacher no more."""
UNKNOWN_FILE = "unknown.csv"
"""The same of pictures that a former training does not understand: their names."""

# Two trainings that see a picture from the same side agree to so much.
_SAME_SIDE = math.radians(30)


def teacher_at(path: Path) -> Subject:
    """The model of a run directory, a checkpoint or a bundle. Raises CheckpointError where none is there."""
    if (path / MANIFEST_FILE).exists():
        return from_bundle(path)
    return from_checkpoint(load_checkpoint(path))


def unknown_pictures(images: ImageSet, folder: Path, teacher: Subject, console: Console) -> ImageSet:
    """The pictures of a folder whose shapes `teacher` knows least again from other sides: what it does not understand.

    Raises DataError where the teacher cannot use one of the pictures.
    """
    seen = load_as_seen(folder, teacher.scene)
    _check_all_told(images, seen.names, folder)
    distances = doubts(teacher, seen.pictures)
    chosen = unknown(distances)
    times = np.median(distances[chosen]) / np.median(distances)
    console.print(
        f"{chosen.sum()} of them are trained on, of which a former training knows again what it makes "
        f"{times:.1f} times worse than of the usual picture"
    )
    names = {name for name, one in zip(seen.names, chosen, strict=True) if one}
    return images.of(np.array([number for number, name in enumerate(images.names) if name in names], np.int64))


def told_poses(
    images: ImageSet, folder: Path, teacher: Subject, fronts: Fronts, console: Console, second: Subject | None = None
) -> ImageSet:
    """The pictures of a folder with the azimuths that `teacher` sees in them, in place of any that are known.

    They are those of objects that are turned until the plane in which the teacher's shapes are most nearly their own
    mirror images is x = 0; and, unless as they are `found`, by half a turn where they stand back to front, to be
    `alike`, or by `quarters`. Of pictures that the teacher does not understand (`unknown`), a `second` one tells them,
    its own shapes' mirror being x = 0 then, and its front the side that more of all pictures show both.

    Raises DataError where a teacher cannot use one of the pictures.
    """
    seen = load_as_seen(folder, teacher.scene)
    _check_all_told(images, seen.names, folder)
    prediction, faces = predict(teacher, seen.pictures), teacher.faces.numpy()
    turn = mirror_plane(prediction.vertices.numpy(), faces)
    console.print(
        f"told the poses that a former training finds, its mirror being {math.degrees(turn):.1f}° beside x = 0"
    )
    azimuths = prediction.azimuths.double().numpy() + turn
    not_understood = np.zeros(len(azimuths), np.bool_)
    if second is not None:
        not_understood = unknown(doubts(teacher, seen.pictures))
        azimuths[not_understood] = _poses_in(seen, folder, second, azimuths, not_understood)[not_understood]
        console.print(f"{not_understood.sum()} of them a second one tells")
    if fronts != "found":
        # About +Y by -turn: then the mirror lies in x = 0.
        shapes = prediction.vertices.numpy() @ rotation_about_y(turn)
        quarters = 2 * back_to_front(shapes, faces) if fronts == "alike" else quarter_turns(shapes, faces)
        how = "round" if fronts == "alike" else "by a quarter or more"
        console.print(f"{(quarters > 0).sum()} of {len(quarters)} objects are turned {how}, to be like the others")
        azimuths += math.pi / 2 * quarters * ~not_understood
    told = dict(zip(seen.names, (azimuths + math.pi) % (2 * math.pi) - math.pi, strict=True))
    return replace(images, azimuths=np.array([told[name] for name in images.names]))


def _poses_in(
    seen: ImageSet, folder: Path, second: Subject, azimuths: Float[ndarray, "N"], whose: Bool[ndarray, "N"]
) -> Float[ndarray, "N"]:
    """The azimuths of all pictures that are `seen`, from the mirror of those shapes that `second` makes of some, and by
    that front of the two which has more of the `azimuths` that another training found."""
    others = load_as_seen(folder, second.scene)
    _check_all_told(seen, others.names, folder)
    numbers = {name: number for number, name in enumerate(others.names)}
    prediction = predict(second, others.of(np.array([numbers[name] for name in seen.names])).pictures)
    turn = mirror_plane(prediction.vertices.numpy()[whose], second.faces.numpy())
    found = prediction.azimuths.double().numpy() + turn
    likeness, same = np.cos(found - azimuths), math.cos(_SAME_SIDE)
    back_to_back = bool((likeness < -same).sum() > (likeness > same).sum())
    return np.asarray(found + math.pi * back_to_back)


def _check_all_told(images: ImageSet, usable: Collection[str], folder: Path) -> None:
    """Raises DataError where a former training can use but some of the pictures."""
    if lacking := sorted(set(images.names) - set(usable)):
        raise DataError(
            f"Expected a former training that can use each picture of {folder}, found {len(lacking)} that it cannot, "
            f"the first {lacking[0]}. Leave them away."
        )


def keep_names(images: ImageSet, run_directory: Path) -> None:
    """Stores which pictures a training has, for those that go on with it."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([name] for name in images.names)
    write_bytes(run_directory / UNKNOWN_FILE, text.getvalue().encode())


def kept_pictures(images: ImageSet, run_directory: Path) -> ImageSet:
    """The pictures of a folder that a training has had from its beginning.

    Raises DataError where nothing says which, or they are not there.
    """
    path = run_directory / UNKNOWN_FILE
    try:
        names = [name for (name,) in csv.reader(io.StringIO(path.read_text(encoding="utf-8")))]
    except (OSError, ValueError) as error:
        raise DataError(
            f"{path}: expected the names of the pictures that are trained on, found {error}. Begin the training anew, "
            "with --unknown-to."
        ) from error
    numbers = {name: number for number, name in enumerate(images.names)}
    if lacking := [name for name in names if name not in numbers]:
        raise DataError(
            f"{path}: expected pictures of the folder that is trained on, found {len(lacking)} that are not in it, the "
            f"first {lacking[0]}. Name the same pictures with --images, or begin anew."
        )
    return images.of(np.array([numbers[name] for name in names], np.int64))


def keep_poses(images: ImageSet, run_directory: Path) -> None:
    """Stores what a training is told, for those that go on with it."""
    assert images.azimuths is not None
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(zip(images.names, images.azimuths.tolist(), strict=True))
    write_bytes(run_directory / POSES_FILE, text.getvalue().encode())


def kept_poses(images: ImageSet, run_directory: Path) -> ImageSet:
    """The pictures with the azimuths that their training has been told from its beginning.

    Raises DataError where they are not there, or are not those of these pictures.
    """
    path = run_directory / POSES_FILE
    try:
        rows = list(csv.reader(io.StringIO(path.read_text(encoding="utf-8"))))
        names, azimuths = zip(*((name, float(azimuth)) for name, azimuth in rows), strict=True)
    except (OSError, ValueError) as error:
        raise DataError(
            f"{path}: expected the poses that this training is told, found {error}. Begin it anew, with --poses-of."
        ) from error
    if names != images.names:
        raise DataError(
            f"{path}: expected the poses of the {len(images)} pictures that are trained on, found those of others, "
            f"{len(names)}. Name the same pictures with --images, or begin anew."
        )
    return replace(images, azimuths=np.array(azimuths))
