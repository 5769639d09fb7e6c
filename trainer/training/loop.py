"""Training: batch → loss → Adam → checkpoint, until the steps are done or somebody stops it."""

import math
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor
from torch.nn.parallel import DistributedDataParallel

from trainer import processes
from trainer.config import LossConfig, SceneConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.data.source import FolderPictures, PictureSource
from trainer.errors import ConfigError, DataError
from trainer.geometry.topology import underside, vertex_neighbours
from trainer.model.batch_norm import synchronise
from trainer.model.block_decoder import BlockDecoder
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
from trainer.training.checks import check_intervals, check_pictures, check_processes, check_settings
from trainer.training.clock import Clock
from trainer.training.descent import descend
from trainer.training.figures import figures_of
from trainer.training.health import health_of
from trainer.training.interruption import interruptible
from trainer.training.intervals import Intervals
from trainer.training.journal import Journal
from trainer.training.optimiser import adam, at_step
from trainer.training.schedule import weights_at
from trainer.training.step import FixedGeometry, Step, StepResult, forward

# So many steps in a row without a finite gradient end a training: it will not recover by itself.
MOST_SKIPPED_STEPS = 20


def train(
    config: TrainConfig,
    images: ImageSet | PictureSource,
    category: str,
    run_directory: Path,
    intervals: Intervals,
    resume: bool,
    report: Callable[[int, dict[str, float]], None],
    provenance: dict[str, Any],
    until: int | None = None,
) -> Checkpoint:
    """Trains in `run_directory` and returns the last checkpoint, which is also written there.

    `images` are a folder's, of which `config.validation_share` is held out here, or a source that has seen to that.
    `report` is called after every logged step with the step and its figures; `provenance` (where the pictures came
    from) is kept in the checkpoint. `until` is a step to halt at, from where a later call resumes. Ctrl-C finishes the
    step, saves and returns. A step without a finite gradient changes nothing, and is noted. The same seed, pictures,
    threads and machine give the same result, also through `resume`. Processes that train together
    (`trainer.processes`) all call this; the first of them writes and reports.

    Raises:
        ConfigError: settings that do not go together, or a run directory that holds another training.
        DataError: too few pictures, supervision asked for without azimuths, or no finite gradient any more.
        CheckpointError: nothing to resume.
        StorageError: the disk is full.
    """
    check_settings(config)
    check_intervals(intervals)
    check_processes(config.optimiser, processes.count())
    source = _of_folder(config, images) if isinstance(images, ImageSet) else images
    scene = replace(source.scene, width=config.width, height=config.height)
    before = load_checkpoint(run_directory) if resume else None
    if before:
        _check_same(run_directory, before, config, scene, category, source, provenance)
    elif (run_directory / FILE_NAME).exists():
        raise ConfigError(
            f"{run_directory} already holds a training. Continue it with --resume, or name another directory."
        )
    model, optimiser = _at(before, config)
    start, clock = before.step if before else 0, Clock(before.run if before else {})
    geometry, shown = fixed_geometry(model, scene, config.loss), source.shown()
    convolutions, views = number_format(config.precision), config.optimiser.views_per_instance
    taking, first = stepping(model), processes.number() == 0
    step, skipped, end = start, 0, min(until or config.optimiser.steps, config.optimiser.steps)

    def checkpoint() -> Checkpoint:
        pictures = {"pictures": source.training, "validation_pictures": source.validation}
        run: dict[str, Any] = provenance | clock.told() | pictures
        return Checkpoint(config, scene, category, step, model, optimiser_tensors(optimiser, model), run)

    with (
        Journal(run_directory, config, start, clock.seconds_before) if first else nullcontext() as journal,
        interruptible() as interrupted,
        closing(source.minibatches(config.optimiser.batch_size, config.seed, start, views)) as minibatches,
    ):
        while step < end and not processes.anywhere(interrupted()):
            batch, azimuths, generator = next(minibatches)
            truth = true_azimuths(config.loss, azimuths)
            weights = weights_at(config.loss, step, config.width, config.height)
            seen = geometry, scene, config.loss, weights, batch, truth, generator, convolutions, views
            model.train()
            taken = descend(
                model,
                at_step(optimiser, config.optimiser, step),
                config.optimiser.gradient_clip,
                partial(taking, *seen),
            )
            step += 1
            if taken is None:
                skipped += 1
                _note_skipped(journal, step, skipped)
            else:
                skipped = 0
                last_step = step == end
                closer = step % intervals.preview == 0
                if step % intervals.log == 0 or closer or last_step:
                    close = health_of(model, scene, shown, partial(forward, model, *seen)) if closer else {}
                    figures = figures_of(*taken) | close
                    if journal:
                        journal.log(step, figures)
                        report(step, figures)
                if journal and (closer or last_step):
                    journal.preview(step, model, scene, shown)
            if first and step % intervals.checkpoint == 0:
                save_checkpoint(run_directory / FILE_NAME, checkpoint())
        last = checkpoint()
        if first:
            save_checkpoint(run_directory / FILE_NAME, last)
    model.eval()
    return last


def _at(before: Checkpoint | None, config: TrainConfig) -> tuple[Model, torch.optim.Adam]:
    """Model and optimiser as a checkpoint has them, or new ones."""
    torch.manual_seed(config.seed)
    model = Model(config.model, config.width, config.height)
    if processes.count() > 1:
        synchronise(model.encoder)
    optimiser = adam(model, config.optimiser)
    if before:
        model.load_state_dict(before.model.state_dict())
        restore_optimiser(optimiser, model, before.optimiser_state)
    return model, optimiser


def stepping(model: Model) -> Callable[..., StepResult]:
    """`forward` of this model, such that a gradient of its loss is the mean over all processes."""
    if processes.count() == 1:
        return partial(forward, model)
    # Running means are those of the whole batch already, and nothing needs to be sent.
    return DistributedDataParallel(Step(model), forward_sync_buffers=False)


def true_azimuths(config: LossConfig, known: Float[Tensor, "B"] | None) -> Float[Tensor, "B"] | None:
    """What the step is told. Raises DataError where it asks for azimuths that these pictures do not have."""
    if config.pose_supervision == "none":
        return None
    if known is None:
        raise DataError(
            "Pose supervision needs azimuth_degrees of every picture, and some have none. Add it, or train with "
            "--loss.pose-supervision none."
        )
    return known


def _note_skipped(journal: Journal | None, step: int, in_a_row: int) -> None:
    """Raises DataError where too many steps in a row were skipped."""
    if journal:
        journal.note(f"step {step}: the gradient is not finite; the step was skipped")
    if in_a_row >= MOST_SKIPPED_STEPS:
        raise DataError(
            f"Expected finite gradients, found none in {in_a_row} steps in a row, the last at step {step}. "
            "Lower --optimiser.learning-rate, and look at the pictures; the run's checkpoint, if there is one, is from "
            "before."
        )


def _check_same(
    run_directory: Path,
    before: Checkpoint,
    config: TrainConfig,
    scene: SceneConfig,
    category: str,
    source: PictureSource,
    provenance: dict[str, Any],
) -> None:
    """Raises ConfigError where a training is to go on with other settings or pictures than it has had."""
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


def _drawn(provenance: dict[str, Any]) -> dict[str, Any]:
    """What is drawn; how much memory that takes may change."""
    return {name: value for name, value in provenance.get("fresh", {}).items() if name != "mesh_memory_mib"}


def _of_folder(config: TrainConfig, images: ImageSet) -> FolderPictures:
    training, validation = split_instances(images, config.validation_share, config.seed)
    check_pictures(config, images, training)
    return FolderPictures(images, training, validation)


def split_instances(images: ImageSet, share: float, seed: int) -> tuple[Int64[Tensor, "T"], Int64[Tensor, "N"]]:
    """Indices of the pictures to train on and of those held out; all pictures of an instance fall on the same side."""
    instances = np.unique(images.instances)
    shuffled = np.random.default_rng(seed).permutation(instances)
    held_out = np.isin(images.instances, shuffled[: round(share * len(instances))])
    return torch.as_tensor(np.flatnonzero(~held_out)), torch.as_tensor(np.flatnonzero(held_out))


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


def fixed_geometry(model: Model, scene: SceneConfig, config: LossConfig) -> FixedGeometry:
    if isinstance(model.decoder, BlockDecoder):
        return FixedGeometry(topology_of(model.faces), None)
    vertices, faces = model.decoder.base_vertices.numpy(), model.faces.numpy()
    laplacian = np.eye(len(vertices)) - vertex_neighbours(faces, len(vertices))
    if scene.camera.elevation_degrees > 0:
        # The term is squared.
        laplacian[underside(vertices, faces)] *= math.sqrt(config.laplacian_underside)
    return FixedGeometry(topology_of(model.faces), torch.as_tensor(laplacian, dtype=torch.float32))
