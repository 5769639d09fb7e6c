"""Poses that a former training found, for another one that is told them."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console

from trainer.data.images import ImageSet
from trainer.data.picture import rotation_about_y
from trainer.errors import DataError
from trainer.evaluation.bundle import MANIFEST_FILE, from_bundle
from trainer.evaluation.fronts import back_to_front
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.pictures import load_as_seen
from trainer.evaluation.subject import Subject, from_checkpoint, predict
from trainer.training.checkpoint import load_checkpoint


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
