"""Several trainings are begun from different seeds, and the one that explains pictures best goes on.

RUN/starts/seed-<n>/  the trainings up to the choice; the chosen one moves up to RUN
RUN/starts.json       the bound of each (`bound.py`), and how much computing the choice took
"""

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from trainer import processes
from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.data.source import PictureSource
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError, DataError
from trainer.selection.bound import held_out_bound
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint
from trainer.training.device import CPU
from trainer.training.intervals import Intervals
from trainer.training.loop import train

STARTS_DIRECTORY, STARTS_FILE = "starts", "starts.json"
CHOICE_STEPS, CHOICE_SHARE = 300, 0.2
"""One is chosen after so many steps, by when those that will fail explain pictures worse; of a shorter training, after
that share of its steps."""
USUAL_STARTS = 3
MOST_STARTS = 100
_JUDGED, _BATCH, _SAMPLES = 256, 64, 2


@dataclass(frozen=True)
class Start:
    """A training up to the choice."""

    seed: int
    bound: float | None
    """Lower bound of log p(x), mean over pictures that are the same for all, nats; None where the training failed."""
    seconds: float
    core_seconds: float
    problem: str | None = None
    """Why it has no bound."""


def usual_starts(config: TrainConfig) -> int:
    """Several where a training finds the poses by itself and is so long that the choice tells something; it tells
    nothing of shapes that do not lie where their pictures are yet."""
    loss = config.loss
    finding = loss.objective == "exact" and loss.pose_supervision == "none" and not loss.moved_steps
    return USUAL_STARTS if finding and first_steps(config) == CHOICE_STEPS and processes.count() == 1 else 1


def best_start(
    config: TrainConfig,
    starts: int,
    images: ImageSet | PictureSource,
    category: str,
    run_directory: Path,
    intervals: Intervals,
    report: Callable[[Start], None],
    report_step: Callable[[int, dict[str, float]], None],
    provenance: dict[str, Any],
    device: torch.device = CPU,
    record: bool = True,
) -> TrainConfig:
    """Trains `starts` seeds, from the setting's own on, for `first_steps`, and leaves the one of the highest bound in
    `run_directory`; returns its settings, with which `train` resumes there.

    `report` is told of each, and `report_step` of their logged steps, which are counted on from one start to the next.
    `device` and `record` are as they are in `train`. What an interrupted call has done is not done again, and
    `begun` has what it was called with.

    Raises:
        ConfigError: a number of starts that makes no sense, several processes, or a run directory that holds a
            training.
        DataError: no start came to the choice.
        KeyboardInterrupt: after Ctrl-C; everything is saved, and the same call goes on.
        StorageError: the disk is full.
    """
    check_starts(starts)
    if processes.count() > 1:
        raise ConfigError(
            f"Expected one process for --starts {starts}, found {processes.count()}. Begin with one, and go on with "
            "all of them and --resume."
        )
    if (run_directory / FILE_NAME).exists():
        raise ConfigError(
            f"{run_directory} already holds a training. Continue it with --resume, or name another directory."
        )
    judged = _judged_pictures(images, config)
    seeds = [replace(config, seed=config.seed + number) for number in range(starts)]
    found = []
    remembered = provenance | {STARTS_DIRECTORY: [config.seed, starts]}
    for number, own in enumerate(seeds):

        def report_own(step: int, figures: dict[str, float], before: int = number * first_steps(config)) -> None:
            report_step(before + step, figures)

        training = partial(train, own, images, category, _directory(run_directory, own), intervals)
        training = partial(training, report=report_own, provenance=remembered, device=device, record=record)
        found.append(_first_part(own, training, run_directory, judged, device))
        report(found[-1])
    bounds = [-math.inf if start.bound is None else start.bound for start in found]
    if max(bounds) == -math.inf:
        raise DataError(f"None of {starts} starts came to step {first_steps(config)}; the first: {found[0].problem}")
    best = int(np.argmax(bounds))
    content = {"step": first_steps(config), "chosen": seeds[best].seed, "starts": [asdict(start) for start in found]}
    write_bytes(run_directory / STARTS_FILE, (json.dumps(content, indent=2) + "\n").encode())
    _move_up(_directory(run_directory, seeds[best]), run_directory)
    return seeds[best]


def check_starts(starts: int) -> None:
    """Raises ConfigError."""
    if not 1 <= starts <= MOST_STARTS:
        raise ConfigError(f"Expected --starts from 1 to {MOST_STARTS}, found {starts}.")


def _first_part(
    config: TrainConfig,
    training: Callable[..., Checkpoint],
    run_directory: Path,
    judged: Float[Tensor, "N 3 H W"],
    device: torch.device,
) -> Start:
    directory, first = _directory(run_directory, config), first_steps(config)
    try:
        last = training(resume=(directory / FILE_NAME).exists(), until=first)
        if last.step < first:
            raise KeyboardInterrupt
        bound = _bound(last, judged, device)
    except (DataError, FloatingPointError) as error:
        run = load_checkpoint(directory).run if (directory / FILE_NAME).exists() else {}
        return Start(config.seed, None, run.get("seconds", 0.0), run.get("core_seconds", 0.0), str(error))
    return Start(config.seed, round(bound, 3), last.run["seconds"], last.run["core_seconds"])


def _bound(trained: Checkpoint, judged: Float[Tensor, "N 3 H W"], device: torch.device) -> float:
    generator = torch.Generator().manual_seed(0)
    model, scene, loss = trained.model.to(device), trained.scene, trained.config.loss
    values = [
        held_out_bound(model, scene, loss, part.to(device), _SAMPLES, generator).value for part in judged.split(_BATCH)
    ]
    return float(torch.cat(values).mean())


def _judged_pictures(images: ImageSet | PictureSource, config: TrainConfig) -> Float[Tensor, "N 3 H W"]:
    """Pictures that are the same for all starts; most of them are trained on, as little as that tells so early."""
    if isinstance(images, ImageSet):
        return images.batch(np.random.default_rng(config.seed).permutation(len(images))[:_JUDGED])
    minibatches = images.minibatches(_JUDGED, config.seed, 0)
    try:
        return next(minibatches).pictures
    finally:
        minibatches.close()


def first_steps(config: TrainConfig) -> int:
    """After how many steps one start is chosen."""
    return min(CHOICE_STEPS, max(1, round(CHOICE_SHARE * config.optimiser.steps)))


def begun(run_directory: Path) -> tuple[Checkpoint, int]:
    """What a run directory's training goes on from, and how many starts that is to have: 1 where there was no choice
    to make, or it has been made. Otherwise the first start that an interrupted `best_start` has saved, with the
    settings that it was called with.

    Raises CheckpointError where there is nothing to go on from.
    """
    saved = sorted((run_directory / STARTS_DIRECTORY).glob(f"*/{FILE_NAME}"))
    if saved and not (run_directory / FILE_NAME).exists():
        before = load_checkpoint(saved[0])
        if STARTS_DIRECTORY in before.run:
            seed, starts = before.run[STARTS_DIRECTORY]
            return replace(before, config=replace(before.config, seed=seed)), starts
    return load_checkpoint(run_directory), 1


def _directory(run_directory: Path, config: TrainConfig) -> Path:
    return run_directory / STARTS_DIRECTORY / f"seed-{config.seed}"


def _move_up(source: Path, target: Path) -> None:
    """The checkpoint last: a directory with a checkpoint is whole."""
    for path in sorted(source.iterdir(), key=lambda path: path.name == FILE_NAME):
        path.replace(target / path.name)
    source.rmdir()
