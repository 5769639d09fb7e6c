"""Poses that a former training found, for another one that is told them."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console

from trainer.data.images import ImageSet
from trainer.errors import DataError
from trainer.evaluation.bundle import MANIFEST_FILE, from_bundle
from trainer.evaluation.mirror_plane import mirror_plane
from trainer.evaluation.pictures import load_as_seen
from trainer.evaluation.subject import Subject, from_checkpoint, predict
from trainer.geometry.conventions import wrap_angle
from trainer.training.checkpoint import load_checkpoint


def teacher_at(path: Path) -> Subject:
    """The model of a run directory, a checkpoint or a bundle. Raises CheckpointError where none is there."""
    if (path / MANIFEST_FILE).exists():
        return from_bundle(path)
    return from_checkpoint(load_checkpoint(path))


def told_poses(images: ImageSet, folder: Path, teacher: Subject, mirrored: bool, console: Console) -> ImageSet:
    """The pictures of a folder with the azimuths that `teacher` sees in them, in place of any that are known.

    Where shapes are to be `mirrored` in x = 0, the azimuths are those of objects that are turned until the plane in
    which the teacher's shapes are most nearly their own mirror images lies there.

    Raises DataError where the teacher cannot use one of the pictures.
    """
    seen = load_as_seen(folder, teacher.scene)
    prediction = predict(teacher, seen.pictures)
    turn = mirror_plane(prediction.vertices.numpy(), teacher.faces.numpy()) if mirrored else 0.0
    azimuths = dict(zip(seen.names, wrap_angle(prediction.azimuths.double() + turn).tolist(), strict=True))
    if lacking := [name for name in images.names if name not in azimuths]:
        raise DataError(
            f"Expected to be told the pose in each picture of {folder}, found {len(lacking)} that the training of "
            f"--poses-of cannot use, the first {lacking[0]}. Leave them away."
        )
    mirror = f", mirrored in the plane that was {math.degrees(turn):.1f}° beside x = 0" if mirrored else ""
    console.print(f"told the poses that a former training finds{mirror}")
    return replace(images, azimuths=np.array([azimuths[name] for name in images.names]))
