"""Training: batch → loss → Adam → checkpoint, until the steps are done or somebody stops it."""

import math
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor

from trainer.config import SceneConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.errors import ConfigError, DataError
from trainer.geometry.topology import vertex_neighbours
from trainer.model.posterior import shape_divergence
from trainer.model.vae import Model
from trainer.rendering.cpu import topology_of
from trainer.training.checkpoint import (
    FILE_NAME,
    Checkpoint,
    load_checkpoint,
    optimiser_tensors,
    restore_optimiser,
    save_checkpoint,
)
from trainer.training.journal import Journal
from trainer.training.schedule import weights_at
from trainer.training.step import FixedGeometry, StepResult, forward

# So many steps in a row without a finite gradient end a training: it will not recover by itself.
MOST_SKIPPED_STEPS = 20


@dataclass(frozen=True)
class Intervals:
    """How often what is written, in steps."""

    log: int = 20
    preview: int = 500
    checkpoint: int = 500


def train(
    config: TrainConfig,
    images: ImageSet,
    category: str,
    run_directory: Path,
    intervals: Intervals,
    resume: bool,
    report: Callable[[int, dict[str, float]], None],
    provenance: dict[str, str],
) -> Checkpoint:
    """Trains in `run_directory` and returns the last checkpoint, which is also written there.

    `report` is called after every logged step with the step and its figures; `provenance` (where the pictures came
    from) is kept in the checkpoint. Ctrl-C finishes the step, saves and
    returns. The same seed, pictures and machine give the same result, also through `resume`.

    Raises:
        ConfigError: settings that do not go together, or a run directory that holds another training.
        DataError: too few pictures, or supervision asked for without azimuths.
        StorageError: the disk is full.
    """
    training, validation = split_instances(images, config.validation_share, config.seed)
    _check(config, images, len(training))
    scene = replace(images.scene, width=config.width, height=config.height)
    torch.manual_seed(config.seed)
    model = Model(config.model, config.width, config.height)
    optimiser = torch.optim.Adam(model.parameters(), lr=config.optimiser.learning_rate)
    start, seconds_before = 0, 0.0
    if resume:
        before = load_checkpoint(run_directory)
        if replace(before.config, optimiser=config.optimiser) != config:
            raise ConfigError(
                f"{run_directory} was trained with other settings than these; only those of the optimiser may change on "
                "--resume. Leave the other options away, or train in another directory."
            )
        model.load_state_dict(before.model.state_dict())
        restore_optimiser(optimiser, model, before.optimiser_state)
        start, seconds_before = before.step, float(before.run["seconds"])
    elif (run_directory / FILE_NAME).exists():
        raise ConfigError(
            f"{run_directory} already holds a training. Continue it with --resume, or name another directory."
        )
    geometry = fixed_geometry(model)
    azimuths = None if images.azimuths is None else torch.as_tensor(images.azimuths, dtype=torch.float32)
    supervised = config.loss.pose_supervision == "azimuth"
    convolutions = number_format(config.precision)
    began, skipped = time.monotonic(), 0

    def checkpoint(step: int) -> Checkpoint:
        run: dict[str, Any] = provenance | {
            "seconds": round(seconds_before + time.monotonic() - began, 2),
            "pictures": len(training),
            "validation_pictures": len(validation),
        }
        return Checkpoint(config, scene, category, step, model, optimiser_tensors(optimiser, model), run)

    with Journal(run_directory, config, start) as journal, _interruptible() as interrupted:
        step = start
        while step < config.optimiser.steps and not interrupted():
            generator = torch.Generator().manual_seed(config.seed * 1_000_003 + step)
            chosen = batch_indices(training, config.optimiser.batch_size, generator)
            weights = weights_at(config.loss, step, config.width, config.height)
            truth = azimuths[chosen] if supervised and azimuths is not None else None
            model.train()
            batch = images.batch(chosen)
            result = forward(model, geometry, scene, config.loss, weights, batch, truth, generator, convolutions)
            loss = result.terms.total()
            optimiser.zero_grad()
            loss.backward()
            norm = torch.nn.utils.clip_grad_norm_(model.parameters(), config.optimiser.gradient_clip)
            if torch.isfinite(norm):
                optimiser.step()
                skipped = 0
            else:
                skipped += 1
                journal.note(f"step {step}: the gradient is not finite; the step was skipped")
                if skipped >= MOST_SKIPPED_STEPS:
                    raise DataError(
                        f"{skipped} steps in a row had no finite gradient, the last at step {step}. Lower the learning "
                        f"rate, and look at the pictures; the checkpoint in {run_directory} is from before."
                    )
            step += 1
            if step % intervals.log == 0 or step == config.optimiser.steps:
                figures = figures_of(result, float(norm))
                journal.log(step, figures)
                report(step, figures)
            if step % intervals.preview == 0 or step == config.optimiser.steps:
                journal.preview(step, model, scene, images.batch(validation[:6] if len(validation) else training[:6]))
            if step % intervals.checkpoint == 0:
                save_checkpoint(run_directory / FILE_NAME, checkpoint(step))
        last = checkpoint(step)
        save_checkpoint(run_directory / FILE_NAME, last)
    model.eval()
    return last


def split_instances(images: ImageSet, share: float, seed: int) -> tuple[Int64[Tensor, "T"], Int64[Tensor, "N"]]:
    """Indices of the pictures to train on and of those held out; all pictures of an instance fall on the same side."""
    instances = np.unique(images.instances)
    shuffled = np.random.default_rng(seed).permutation(instances)
    held_out = np.isin(images.instances, shuffled[: round(share * len(instances))])
    return torch.as_tensor(np.flatnonzero(~held_out)), torch.as_tensor(np.flatnonzero(held_out))


def batch_indices(pictures: Int64[Tensor, "T"], size: int, generator: torch.Generator) -> Int64[Tensor, "B"]:
    """A batch drawn uniformly with replacement (section 5, "Training minibatches")."""
    return pictures[torch.randint(len(pictures), (size,), generator=generator)]


def number_format(precision: Literal["auto", "float32", "bfloat16"]) -> torch.dtype:
    """The format of the convolutions; `auto` asks the processor whether it multiplies bfloat16 matrices."""
    match precision:
        case "float32":
            return torch.float32
        case "bfloat16":
            return torch.bfloat16
        case "auto":
            able = torch.cpu.get_capabilities()
            return torch.bfloat16 if able.get("avx512_bf16") or able.get("amx_bf16") else torch.float32


def fixed_geometry(model: Model) -> FixedGeometry:
    count = len(model.decoder.base_vertices)
    neighbours = vertex_neighbours(model.faces.numpy(), count)
    return FixedGeometry(topology_of(model.faces), torch.as_tensor(np.eye(count) - neighbours, dtype=torch.float32))


def figures_of(result: StepResult, gradient_norm: float) -> dict[str, float]:
    """What the journal keeps of a step. Entropies are in nats; `active_dimensions` counts those above 0.1 nats."""
    with torch.no_grad():
        rho = result.posterior.azimuth_logits.softmax(1)
        by_dimension = shape_divergence(result.posterior).mean(0)
        figures = {name: float(value) for name, value in result.terms._asdict().items()}
        return figures | {
            "loss": float(result.terms.total()),
            "gradient_norm": gradient_norm,
            "best_bin_log_likelihood": float(result.log_likelihood.max(1).values.mean()),
            "shape_nats": float(by_dimension.sum()),
            "active_dimensions": float((by_dimension > 0.1).sum()),
            "azimuth_entropy": float(_entropy(rho).mean()),
            "aggregate_azimuth_entropy": float(_entropy(rho.mean(0))),
        }


def _entropy(probabilities: Float[Tensor, "*B R"]) -> Tensor:
    return torch.special.entr(probabilities).sum(-1)


def _check(config: TrainConfig, images: ImageSet, pictures: int) -> None:
    if min(config.width, config.height) < 16:
        raise ConfigError(f"Expected pictures of at least 16 × 16 pixels, found {config.width} × {config.height}.")
    if not 0 <= config.validation_share <= 0.5:
        raise ConfigError(f"Expected validation_share from 0 to 0.5, found {config.validation_share}.")
    for name, value in (
        ("optimiser.steps", config.optimiser.steps),
        ("optimiser.learning_rate", config.optimiser.learning_rate),
        ("optimiser.gradient_clip", config.optimiser.gradient_clip),
        ("model.latent", config.model.latent),
        ("model.hidden", config.model.hidden),
        ("model.segments", config.model.segments),
        ("model.azimuth_bins", config.model.azimuth_bins),
        ("loss.temperature", config.loss.temperature),
        ("loss.temperature_start", config.loss.temperature_start),
        ("loss.temperature_cooling_steps", config.loss.temperature_cooling_steps),
        ("loss.kl_cooling_steps", config.loss.kl_cooling_steps),
    ):
        if not (value > 0 and math.isfinite(value)):
            raise ConfigError(f"Expected {name} above 0, found {value}.")
    if config.optimiser.batch_size < 2:
        raise ConfigError(f"Expected a batch of at least 2 pictures, found {config.optimiser.batch_size}.")
    if pictures < 2:
        raise DataError(f"Expected at least 2 pictures to train on, found {pictures}. Add pictures to the folder.")
    if config.loss.pose_supervision == "azimuth" and images.azimuths is None:
        raise DataError(
            "Pose supervision needs the column azimuth_degrees in metadata.csv, and the folder has none. Add it, or train "
            "with --config.loss.pose-supervision none."
        )


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Turns the first Ctrl-C (or SIGTERM) into a question that the loop asks; a second one stops at once."""
    asked = False

    def ask(signum: int, frame: Any) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
