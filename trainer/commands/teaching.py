"""Poses that a former training found, for another one that is told them."""

import csv
import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console

from trainer.data.images import ImageSet
from trainer.data.picture import rotation_about_y
from trainer.data.writing import write_bytes
from trainer.errors import DataError
from trainer.evaluation.bundle import MANIFEST_FILE, from_bundle
from trainer.evaluation.fronts import back_to_front
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.pictures import load_as_seen
from trainer.evaluation.subject import Subject, from_checkpoint, predict
from trainer.training.checkpoint import load_checkpoint

POSES_FILE = "poses.csv"
"""In a run directory: what its training was told, radians. A training that is resumed needs its teacher no more."""


def teacher_at(path: Path) -> Subject:
    """The model of a run directory, a checkpoint or a bundle. Raises CheckpointError where none is there."""
    if (path / MANIFEST_FILE).exists():
        return from_bundle(path)
    return from_checkpoint(load_checkpoint(path))


def told_poses(images: ImageSet, folder: Path, teacher: Subject, alike: bool, console: Console) -> ImageSet:
    """The pictures of a folder with the azimuths that `teacher` sees in them, in place of any that are known.

    They are those of objects that are turned until the plane in which the teacher's shapes are most nearly their own
    mirror images is x = 0; and, to make shapes `alike`, by half a turn where they stand back to front.

    Raises DataError where the teacher cannot use one of the pictures.
    """
    seen = load_as_seen(folder, teacher.scene)
    prediction, faces = predict(teacher, seen.pictures), teacher.faces.numpy()
    turn = mirror_plane(prediction.vertices.numpy(), faces)
    console.print(
        f"told the poses that a former training finds, its mirror being {math.degrees(turn):.1f}° beside x = 0"
    )
    azimuths = prediction.azimuths.double().numpy() + turn
    if alike:
        # About +Y by -turn: then the mirror lies in x = 0.
        turned = back_to_front(prediction.vertices.numpy() @ rotation_about_y(turn), faces)
        console.print(f"{turned.sum()} of {len(turned)} objects are turned round, to be like the others")
        azimuths += math.pi * turned
    told = dict(zip(seen.names, (azimuths + math.pi) % (2 * math.pi) - math.pi, strict=True))
    if lacking := [name for name in images.names if name not in told]:
        raise DataError(
            f"Expected to be told the pose in each picture of {folder}, found {len(lacking)} that the training of "
            f"--poses-of cannot use, the first {lacking[0]}. Leave them away."
        )
    return replace(images, azimuths=np.array([told[name] for name in images.names]))


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
