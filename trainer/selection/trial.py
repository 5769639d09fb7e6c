"""One candidate up to one rung: trained to its step, or on from where it was, and judged on held-out pictures."""

import time
from dataclasses import replace

import torch

from trainer.data.images import ImageSet
from trainer.errors import ConfigError, DataError
from trainer.selection.bound import Bound, held_out_bound
from trainer.selection.held_out import by_object, held_out
from trainer.selection.record import Record, load_record, save_record
from trainer.selection.selection import Selection, Task
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint
from trainer.training.intervals import Intervals
from trainer.training.loop import train

# Pictures that are judged at once.
_BATCH = 64


def run_task(selection: Selection, images: ImageSet, task: Task) -> None:
    """Trains and judges what of a task is not done, and writes its record; one of failure where the training cannot go
    on. `images` are those of `Selection.pictures`.

    Raises:
        KeyboardInterrupt: after Ctrl-C or SIGTERM; the training is saved, and goes on from there next time.
        ConfigError: the candidate's directory holds another training, or one that has gone further.
        StorageError: the disk is full.
    """
    path = selection.record(task)
    if load_record(path) is not None:
        return
    try:
        trained = _trained(selection, task, images)
        began = time.process_time()
        bound = _judged(selection, trained, images)
        seconds = time.process_time() - began
    except (DataError, FloatingPointError) as error:
        save_record(path, Record(task.step, 0.0, 0.0, problem=str(error)))
        return
    likelihood, shape, angle = (tuple(by_object(part, images, selection.recipe).round(4).tolist()) for part in bound)
    save_record(path, Record(task.step, trained.run["core_seconds"], round(seconds, 2), likelihood, shape, angle))


def _trained(selection: Selection, task: Task, images: ImageSet) -> Checkpoint:
    directory, config = selection.run_directory(task.candidate), selection.config(task.candidate)
    begun = (directory / FILE_NAME).exists()
    if begun and (step := load_checkpoint(directory).step) > task.step:
        raise ConfigError(
            f"Expected a training of {task.step} steps at most in {directory}, found {step}: something else has gone "
            "on with it. Delete that folder, and call again."
        )
    # Learning rates do not fall while candidates are compared: which step is a candidate's last is not known yet.
    part = replace(config, optimiser=replace(config.optimiser, steps=task.step, falling_share=0.0))
    provenance = {"images": str(selection.images.resolve())}
    last = train(part, images, selection.category, directory, Intervals(), begun, _to_nobody, provenance)
    if last.step < task.step:
        raise KeyboardInterrupt
    return last


def _judged(selection: Selection, trained: Checkpoint, images: ImageSet) -> Bound:
    """Of all held-out pictures: those that the training itself has held out."""
    generator = torch.Generator().manual_seed(selection.recipe.seed)
    parts = [
        held_out_bound(
            trained.model, trained.scene, trained.config.loss, images.batch(chosen), selection.samples, generator
        )
        for chosen in held_out(images, selection.recipe).split(_BATCH)
    ]
    return Bound(*(torch.cat(values) for values in zip(*parts, strict=True)))


def _to_nobody(step: int, figures: dict[str, float]) -> None:
    """The run directory's metrics.jsonl has the figures."""
