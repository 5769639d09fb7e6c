"""Options of a training that former ones on the same pictures help."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from rich.console import Console

from trainer import processes
from trainer.commands.teaching import (
    Fronts,
    keep_names,
    keep_poses,
    kept_pictures,
    kept_poses,
    teacher_at,
    told_poses,
    unknown_pictures,
)
from trainer.data.images import ImageSet
from trainer.errors import ConfigError
from trainer.training.checkpoint import FILE_NAME

_TEACHERS = ("poses_of", "unknown_to", "unknown_poses_of")


@dataclass(frozen=True)
class FormerOptions:
    """What former trainings found in the pictures of --images."""

    poses_of: Path | None = None
    """Run directory or bundle of a former training on the same --images: this one is told the poses that it finds in
    them, such that the mirror of --model.symmetry lies where its shapes are most nearly their own mirror images. Sets
    --loss.pose-supervision azimuth. --resume remembers it."""
    fronts: Fronts = "found"
    """What --poses-of tells: poses as they are `found`; turned by half a turn where an object is then more `alike` the
    others (where some kinds of a class are learnt backwards, as airplanes); or by `quarters` of a turn where it is then
    more like the others or their mirror images (where one hand is taken for the other, as of corner sofas). Either
    takes some three minutes of a core for 4000 pictures. --resume remembers it."""
    unknown_to: Path | None = None
    """Run directory or bundle of a former training on the same --images: this one is trained on the 15 % of them alone
    of which that one knows least again what it makes of them, seen from other sides. Such kinds of objects, as boats
    with sails among ships, find their poses among themselves. --resume remembers it."""
    unknown_poses_of: Path | None = None
    """Run directory or bundle of such a training on what the one of --poses-of knows least again: it tells the poses in
    those pictures. --resume remembers it."""

    @classmethod
    def of(cls, run: Mapping[str, Any]) -> Self:
        """Those that a checkpoint remembers."""
        paths = {option: Path(run[option]) for option in _TEACHERS if option in run}
        return cls(fronts=run.get("fronts", cls.fronts), **paths)

    def remembered(self) -> dict[str, str]:
        """For a checkpoint, from wherever the training is resumed."""
        named = {option: getattr(self, option) for option in _TEACHERS}
        paths = {option: str(path.resolve()) for option, path in named.items() if path is not None}
        return paths | ({"fronts": self.fronts} if self.poses_of is not None else {})

    def check(self, in_a_folder: bool) -> None:
        """Raises ConfigError for options that do not go together, or with pictures that are not `in_a_folder`."""
        if self.poses_of is not None and not in_a_folder:
            raise ConfigError("Expected --poses-of only beside --images DIR, found other pictures. Leave it away.")
        if self.unknown_to is not None and (self.poses_of is not None or not in_a_folder):
            raise ConfigError(
                "Expected --unknown-to RUN beside --images DIR, of a training that finds poses itself, found "
                f"{'--poses-of' if in_a_folder else 'other pictures'}. Leave one of them away."
            )
        if self.fronts != FormerOptions.fronts and self.poses_of is None:
            raise ConfigError(f"Expected --fronts {self.fronts} only beside --poses-of RUN, found none. Leave it away.")
        if self.unknown_poses_of is not None and self.poses_of is None:
            raise ConfigError("Expected --unknown-poses-of only beside --poses-of RUN, found none. Leave it away.")

    def check_resumed(self, before: Mapping[str, Any]) -> None:
        """Raises ConfigError where a training that is resumed is to have other teachers than a checkpoint tells."""
        asked = self.remembered()
        if other := [option for option, value in asked.items() if before.get(option) != value]:
            options = ", ".join(
                f"--{option.replace('_', '-')} {asked[option]} instead of {before.get(option, 'none')}"
                for option in other
            )
            raise ConfigError(
                f"Expected a training that is resumed to be told what it was told before, found {options}. Leave such "
                "options away."
            )

    def found(self, images: ImageSet, folder: Path, run_directory: Path, console: Console) -> ImageSet:
        """Those of the pictures that are trained on, with the poses that are told; the run directory keeps both.

        Raises DataError where a former training cannot use one of the pictures.
        """
        keeps = processes.number() == 0 and not (run_directory / FILE_NAME).exists()
        if self.unknown_to is not None:
            images = unknown_pictures(images, folder, teacher_at(self.unknown_to), console)
            if keeps:
                keep_names(images, run_directory)
        if self.poses_of is not None:
            second = None if self.unknown_poses_of is None else teacher_at(self.unknown_poses_of)
            images = told_poses(images, folder, teacher_at(self.poses_of), self.fronts, console, second)
            if keeps:
                keep_poses(images, run_directory)
        return images

    def kept(self, images: ImageSet, run_directory: Path) -> ImageSet:
        """The same of a training that is resumed, without its teachers.

        Raises DataError where the run directory has not kept them, or they are not those of these pictures.
        """
        if self.unknown_to is not None:
            images = kept_pictures(images, run_directory)
        if self.poses_of is not None:
            images = kept_poses(images, run_directory)
        return images
