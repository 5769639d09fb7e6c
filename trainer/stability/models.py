"""The models that are examined: bundles as they are served, and checkpoints."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from trainer.data.shapes.catalogue import check_category
from trainer.errors import CheckpointError, ConfigError
from trainer.evaluation.bundle import MANIFEST_FILE, from_bundle
from trainer.evaluation.subject import Subject, from_checkpoint
from trainer.stability.explanation import Errors, Yardstick
from trainer.training.checkpoint import FILE_NAME, load_checkpoint


class Contestant(NamedTuple):
    """A model and where it comes from."""

    name: str
    subject: Subject
    held_out: Yardstick | None
    """What its bundle says of held-out pictures; None where nothing is said."""
    digest: str
    """sha256 of what tells this model from any other."""


def contestants(bundles: Sequence[Path], checkpoints: Sequence[Path]) -> list[Contestant]:
    """All models, in order, each by the name of its directory.

    Raises CheckpointError for one that cannot be read, ConfigError where two have one name, or a category is none of
    the procedural classes, of which there would be no test objects.
    """
    found = [_bundle(path) for path in bundles] + [_checkpoint(path) for path in checkpoints]
    names = [one.name for one in found]
    if repeated := {name for name in names if names.count(name) > 1}:
        raise ConfigError(
            f"Expected models in directories of different names, found {repeated.pop()} more than once. Rename one of "
            "them, or examine it by itself."
        )
    for one in found:
        check_category(one.subject.category)
    return found


def _bundle(directory: Path) -> Contestant:
    subject = from_bundle(directory)
    # It names the sha256 of all other files.
    manifest = (directory / MANIFEST_FILE).read_bytes()
    try:
        held_out = _yardstick(json.loads(manifest).get("held_out"))
    except (KeyError, TypeError, ValueError) as error:
        raise CheckpointError(
            f"{directory / MANIFEST_FILE}: expected held_out to give a median and a high error, found "
            f"{type(error).__name__}: {error}. Export the bundle again."
        ) from error
    return Contestant(directory.resolve().name, subject, held_out, hashlib.sha256(manifest).hexdigest())


def _yardstick(told: dict[str, Any] | None) -> Yardstick | None:
    if not (told and told["framed"] and told["fitted"]):
        return None
    framed, fitted = (Errors(float(told[way]["median"]), float(told[way]["high"])) for way in ("framed", "fitted"))
    return Yardstick(framed, fitted)


def _checkpoint(path: Path) -> Contestant:
    checkpoint, file = load_checkpoint(path), path / FILE_NAME if path.is_dir() else path
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    return Contestant(file.resolve().parent.name, from_checkpoint(checkpoint), None, digest)
