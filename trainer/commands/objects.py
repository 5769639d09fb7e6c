"""Which objects the options of a command name, of a procedural class, a folder of meshes or ShapeNetCore; and how
far they are stretched."""

from pathlib import Path
from typing import Final, NamedTuple

from trainer.data.shapenet import Split, synset_of
from trainer.data.shapes.catalogue import check_category
from trainer.errors import ConfigError

MOST_STRETCH: Final = 0.5
"""Ratios of sides then change by a factor of two, by one standard deviation."""


class Source(NamedTuple):
    """The fields of these names in `RenderSettings`."""

    source: str
    synset: str
    split: Split


def object_source(category: str, meshes: Path | None, shapenet: Path | None, split: Split) -> Source:
    """Raises ConfigError where the options name no source or several, or a class that does not exist."""
    if shapenet is not None:
        if meshes is not None or not category:
            raise ConfigError(
                "Expected --class CLASS and no --meshes beside --shapenet DIRECTORY, found "
                f"{'no class' if not category else 'both directories'}."
            )
        return Source(str(shapenet.resolve()), synset_of(category), split)
    if split != "all":
        raise ConfigError(
            f"Expected --shapenet DIRECTORY beside --split {split}, found none: only ShapeNet has a split."
        )
    if meshes is not None:
        # An absolute path is never taken for a class, whatever the folder is called.
        return Source(str(meshes.resolve()), "", split)
    check_category(category)
    return Source(category, "", split)


def check_stretch(stretch: float) -> None:
    """Raises ConfigError for a `RenderSettings.stretch` that leaves nothing of a shape."""
    if not 0 <= stretch <= MOST_STRETCH:
        raise ConfigError(f"Expected --stretch from 0 to {MOST_STRETCH:g}, found {stretch:g}.")
