"""Short trainings, as several test files want them."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from torch import Tensor

from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.training.checkpoint import Checkpoint
from trainer.training.intervals import Intervals
from trainer.training.loop import train
from trainer.training.step import forward

EVERY_STEP = Intervals(log=1, preview=1000, checkpoint=3)
Report = Callable[[int, dict[str, float]], None]


def silent(step: int, figures: dict[str, float]) -> None:
    """A report to nobody."""


def run(
    config: TrainConfig,
    images: ImageSet,
    directory: Path,
    resume: bool = False,
    report: Report = silent,
    intervals: Intervals = EVERY_STEP,
) -> Checkpoint:
    return train(config, images, "chair", directory, intervals, resume, report, {"images": "here"})


def with_steps(config: TrainConfig, steps: int) -> TrainConfig:
    return replace(config, optimiser=replace(config.optimiser, steps=steps))


def spoiling(kind: str, bad_steps: set[int]) -> Callable[..., Any]:
    """`forward`, but gradient or vertices are not finite in the steps of these numbers (from 0)."""
    step = -1

    def spoilt(model: Any, *arguments: Any) -> Any:
        nonlocal step
        step += 1
        result = forward(model, *arguments)
        if step not in bad_steps:
            return result
        if kind == "vertices":
            raise FloatingPointError("expected finite vertices and colours, found NaN or infinity")
        # sqrt has an infinite slope at 0, and 0 times it is NaN.
        poison: Tensor = (model.heads.shape_mean.weight * 0).sum().sqrt()
        return result._replace(terms=result.terms._replace(kl=result.terms.kl + poison))

    return spoilt
