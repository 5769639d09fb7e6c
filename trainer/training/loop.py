"""Training: batch → loss → Adam → checkpoint, until the steps are done or somebody stops it."""

import math
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor
from torch.nn.parallel import DistributedDataParallel

from trainer import processes
from trainer.config import LossConfig, SceneConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.data.source import FolderPictures, PictureSource
from trainer.errors import DataError
from trainer.geometry.solid import cube_solid
from trainer.geometry.topology import underside, vertex_neighbours
from trainer.model.batch_norm import synchronise
from trainer.model.block_decoder import BlockDecoder
from trainer.model.front_back import sides_of
from trainer.model.vae import Model, model_of
from trainer.rendering.cpu import topology_of
from trainer.training.checkpoint import (
    FILE_NAME,
    Checkpoint,
    optimiser_tensors,
    restore_optimiser,
    save_checkpoint,
)
from trainer.training.checks import check_intervals, check_pictures, check_processes, check_settings
from trainer.training.clock import Clock
from trainer.training.descent import Given, descend
from trainer.training.device import CPU, enough_memory, sent_to
from trainer.training.figures import figures_of
from trainer.training.health import health_of
from trainer.training.interruption import interruptible
from trainer.training.intervals import Intervals
from trainer.training.journal import Journal
from trainer.training.neighbours import Memory
from trainer.training.optimiser import adam, at_step
from trainer.training.recorded import differentiation_on
from trainer.training.resuming import checkpoint_before
from trainer.training.schedule import weights_at
from trainer.training.step import FixedGeometry, Step, StepResult, forward, number_format
from trainer.training.threads import agree_on_threads

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
    device: torch.device = CPU,
    record: bool = True,
) -> Checkpoint:
    """Trains in `run_directory` and returns the last checkpoint, which is also written there.

    `images` are a folder's, of which `config.validation_share` is held out here, or a source that has seen to that.
    `report` is called after every logged step with the step and its figures; `provenance` (where the pictures came
    from) is kept in the checkpoint. `until` is a step to halt at, from where a later call resumes. Everything but the
    pictures is computed on `device`; the model that is returned is on the CPU. On a GPU steps are
    recorded and replayed (`training.recorded`) if `record`. Ctrl-C finishes the step, saves and
    returns. A step without a finite gradient changes nothing, and is noted. The same seed, pictures,
    threads and machine give the same result, also through `resume`. Processes that train together
    (`trainer.processes`) all call this; the first of them writes and reports. The phase of `training.reframing` comes
    after this.

    Raises:
        ConfigError: settings that do not go together, or a run directory that holds another training.
        DataError: too few pictures, supervision asked for without azimuths, or no finite gradient any more.
        CheckpointError: nothing to resume.
        StorageError: the disk, or the memory, is full.
    """
    check_settings(config)
    check_intervals(intervals)
    check_processes(config.optimiser, processes.count())
    agree_on_threads()
    source = of_folder(config, images) if isinstance(images, ImageSet) else images
    scene = replace(source.scene, width=config.width, height=config.height)
    end = min(until or config.optimiser.steps, config.optimiser.steps)
    before = checkpoint_before(run_directory, resume, config, scene, category, source, provenance)
    if before and before.step >= end:
        return replace(before, config=config)
    model, optimiser, memory = _at(before, config, device)
    start, clock = before.step if before else 0, Clock(before.run if before else {})
    shown, first = source.shown().to(device), processes.number() == 0
    taking = stepping(model, scene, config, device, memory)
    differentiation = differentiation_on(device, model, config.optimiser.gradient_clip, taking, record)
    views = config.optimiser.views_per_instance
    step, skipped = start, 0

    def checkpoint() -> Checkpoint:
        pictures = {"pictures": source.training, "validation_pictures": source.validation}
        run: dict[str, Any] = provenance | clock.told() | pictures | {"device": device.type}
        return Checkpoint(config, scene, category, step, model, optimiser_tensors(optimiser, model), run, memory)

    with (
        Journal(run_directory, config, start, clock.seconds_before) if first else nullcontext() as journal,
        interruptible() as interrupted,
        closing(source.minibatches(config.optimiser.batch_size, config.seed, start, views)) as drawn,
        closing(sent_to(device, drawn)) as minibatches,
        enough_memory(device, config.optimiser.batch_size),
    ):
        while step < end and not processes.anywhere(interrupted()):
            batch, azimuths, generator = next(minibatches)
            truth = true_azimuths(config.loss, azimuths)
            given = Given(batch, truth, weights_at(config.loss, step, config.width, config.height), generator)
            model.train()
            taken = descend(at_step(optimiser, config.optimiser, step), differentiation, given)
            step += 1
            if taken is None:
                skipped += 1
                note_skipped(journal, step, skipped)
            else:
                skipped = 0
                _remember(memory, taken.result)
                last_step = step == end
                closer = step % intervals.preview == 0
                if step % intervals.log == 0 or closer or last_step:
                    close = health_of(model, scene, shown, partial(taking, given)) if closer else {}
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
    model.eval().cpu()
    return last


def _at(
    before: Checkpoint | None, config: TrainConfig, device: torch.device
) -> tuple[Model, torch.optim.Adam, Memory | None]:
    """Model, optimiser and where neighbours are looked for, as a checkpoint has them, or new ones. The last only where
    neighbours are asked."""
    torch.manual_seed(config.seed)
    # New weights are drawn on the CPU: they are the same on all devices.
    model = model_of(config).to(device)
    if processes.count() > 1:
        synchronise(model.encoder)
    optimiser = adam(model, config.optimiser)
    if before:
        model.load_state_dict(before.model.state_dict())
        restore_optimiser(optimiser, model, before.optimiser_state)
    memory = Memory(config.model.latent).to(device) if config.loss.neighbour_weight else None
    if memory and before and before.memory:
        memory.load_state_dict(before.memory.state_dict())
    return model, optimiser, memory


def _remember(memory: Memory | None, result: StepResult) -> None:
    if memory:
        memory.remember(result.posterior.shape_mean, result.azimuth)


def stepping(
    model: Model, scene: SceneConfig, config: TrainConfig, device: torch.device, memory: Memory | None = None
) -> Callable[[Given], StepResult]:
    """`forward` of this model, such that a gradient of its loss is the mean over all processes. A loss that asks
    neighbours looks for them in `memory`."""
    taking: Callable[..., StepResult] = partial(forward, model)
    if processes.count() > 1:
        # Running means are those of the whole batch already, and nothing needs to be sent.
        taking = DistributedDataParallel(Step(model), forward_sync_buffers=False)
    fixed = fixed_geometry(model, scene, config.loss), scene, config.loss
    convolutions, views = number_format(config.precision, device), config.optimiser.views_per_instance
    return lambda given: taking(
        *fixed, given.weights, given.pictures, given.azimuths, given.generator, convolutions, views, memory
    )


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


def note_skipped(journal: Journal | None, step: int, in_a_row: int) -> None:
    """Raises DataError where too many steps in a row were skipped."""
    if journal:
        journal.note(f"step {step}: the gradient is not finite; the step was skipped")
    if in_a_row >= MOST_SKIPPED_STEPS:
        raise DataError(
            f"Expected finite gradients, found none in {in_a_row} steps in a row, the last at step {step}. "
            "Lower --optimiser.learning-rate, and look at the pictures; the run's checkpoint, if there is one, is from "
            "before."
        )


def of_folder(config: TrainConfig, images: ImageSet) -> FolderPictures:
    training, validation = split_instances(images, config.validation_share, config.seed)
    check_pictures(config, images, training)
    return FolderPictures(images, training, validation)


def split_instances(images: ImageSet, share: float, seed: int) -> tuple[Int64[Tensor, "T"], Int64[Tensor, "N"]]:
    """Indices of the pictures to train on and of those held out; all pictures of an instance fall on the same side."""
    instances = np.unique(images.instances)
    shuffled = np.random.default_rng(seed).permutation(instances)
    held_out = np.isin(images.instances, shuffled[: round(share * len(instances))])
    return torch.as_tensor(np.flatnonzero(~held_out)), torch.as_tensor(np.flatnonzero(held_out))


def fixed_geometry(model: Model, scene: SceneConfig, config: LossConfig) -> FixedGeometry:
    if isinstance(model.decoder, BlockDecoder):
        return FixedGeometry(topology_of(model.faces), None, None)
    base = model.decoder.base_vertices
    vertices, faces = base.cpu().numpy(), model.faces.cpu().numpy()
    laplacian = np.eye(len(vertices)) - vertex_neighbours(faces, len(vertices))
    if scene.camera.elevation_degrees > 0:
        # The term is squared.
        laplacian[underside(vertices, faces)] *= math.sqrt(config.laplacian_underside)
    solid = None
    if config.inversion_weight:
        inner, tetrahedra = cube_solid(model.config.segments, model.config.proportions)
        solid = base.new_tensor(inner), model.faces.new_tensor(tetrahedra)
    sides = sides_of(base) if config.front_back_weight else None
    return FixedGeometry(topology_of(model.faces), base.new_tensor(laplacian), solid, sides)
