"""Where a training goes on from, and whether it may."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from trainer.config import SceneConfig, TrainConfig
from trainer.data.source import PictureSource
from trainer.errors import ConfigError
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint


def checkpoint_before(
    run_directory: Path,
    resume: bool,
    config: TrainConfig,
    scene: SceneConfig,
    category: str,
    source: PictureSource,
    provenance: dict[str, Any],
) -> Checkpoint | None:
    """Where a training goes on from; None where it begins.

    Raises:
        ConfigError: it is to go on with other settings or pictures than it has had, or to begin where one is already.
        CheckpointError: nothing to resume.
    """
    if not resume:
        if (run_directory / FILE_NAME).exists():
            raise ConfigError(
                f"{run_directory} already holds a training. Continue it with --resume, or name another directory."
            )
        return None
    before = load_checkpoint(run_directory)
    if replace(before.config, optimiser=config.optimiser) != config:
        raise ConfigError(
            f"{run_directory} was trained with other settings than these; only those of the optimiser may change on "
            "--resume. Leave the other options away, or train in another directory."
        )
    if before.scene != scene:
        raise ConfigError(
            f"{run_directory} was trained on pictures of another camera or other lights than these. Name the same "
            "pictures with --images, or train in another directory."
        )
    counts = source.training, source.validation
    known = before.run.get("pictures", counts[0]), before.run.get("validation_pictures", counts[1])
    if before.category != category or known != counts or _drawn(before.run) != _drawn(provenance):
        raise ConfigError(
            f"{run_directory} was trained on other pictures than these: expected {known[0]} to train on and {known[1]} "
            f"held out, of class {before.category}, from the same source, found {counts[0]} and {counts[1]} of "
            f"{category}. Name the same ones, or train in another directory."
        )
    return before


def _drawn(provenance: dict[str, Any]) -> dict[str, Any]:
    """What is drawn; how much memory that takes may change."""
    return {name: value for name, value in provenance.get("fresh", {}).items() if name != "mesh_memory_mib"}
