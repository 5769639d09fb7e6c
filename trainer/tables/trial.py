"""One cell from pictures to figures: trained to its goal, or on from where it was interrupted, and judged."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from trainer.data.images import load_image_folder
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.evaluation.pictures import from_folder, grouped, validation_from
from trainer.evaluation.record import judge_and_record
from trainer.evaluation.subject import from_checkpoint
from trainer.selection.starts import STARTS_FILE, Start, best_start
from trainer.tables.cells import Cell, Task
from trainer.tables.study import CELL_FILE, TRAINED_FILE, Study
from trainer.training.checkpoint import FILE_NAME, load_checkpoint
from trainer.training.intervals import Intervals
from trainer.training.loop import train


def run_task(study: Study, task: Task) -> None:
    """Trains and judges what of a task is not done.

    Raises:
        KeyboardInterrupt: after Ctrl-C or SIGTERM; the training is saved, and goes on from there next time.
        ConfigError: the directory holds a training of other settings or pictures.
        DataError: no finite gradients any more.
        StorageError: the disk is full.
    """
    check_identity(study, task.cell)
    if not study.is_trained(task.cell):
        _train(study, task.cell)
    for views in task.test_views:
        if study.metrics(task.cell, views) is None:
            _judge(study, task.cell, views)


def check_identity(study: Study, cell: Cell) -> None:
    """Raises ConfigError where a cell's directory was made for another recipe or other pictures."""
    path = study.run_directory(cell) / CELL_FILE
    if path.exists() and json.loads(path.read_text()) != study.identity(cell):
        raise ConfigError(
            f"{path.parent} holds a training of another recipe or on other pictures than these. Call with the same "
            "--preset, --instances and --shapenet as before, or name another --output."
        )


def _train(study: Study, cell: Cell) -> None:
    directory, config = study.run_directory(cell), study.config(cell)
    folder = study.training_pictures(cell).path
    images = load_image_folder(folder, config.width, config.height, zoom=config.zoom)
    write_bytes(directory / CELL_FILE, _json(study.identity(cell)))
    steps, seconds, core_seconds = 0, 0.0, 0.0
    provenance = {"images": str(folder.resolve())}
    if study.starts > 1 and not (directory / FILE_NAME).exists():
        best_start(
            config, study.starts, images, cell.category, directory, Intervals(), _start_to_nobody, _to_nobody,
            provenance,
        )  # fmt: skip
    if begun := (directory / FILE_NAME).exists():
        before = load_checkpoint(directory)
        steps, seconds, core_seconds = before.step, before.run["seconds"], before.run.get("core_seconds", 0.0)
        config = replace(config, seed=before.config.seed)
    while (goal := study.next_goal(cell, steps, seconds)) > steps:
        part = replace(config, optimiser=replace(config.optimiser, steps=goal))
        last = train(part, images, cell.category, directory, Intervals(), begun, _to_nobody, provenance)
        if last.step < goal:
            raise KeyboardInterrupt
        steps, seconds, begun = last.step, last.run["seconds"], True
        core_seconds = last.run["core_seconds"]
    given_up = _starts_given_up(directory) if study.starts > 1 else []
    seconds += sum(start["seconds"] for start in given_up)
    core_seconds += sum(start["core_seconds"] for start in given_up)
    write_bytes(directory / TRAINED_FILE, _json({"steps": steps, "seconds": seconds, "core_seconds": core_seconds}))


def _starts_given_up(directory: Path) -> list[dict[str, Any]]:
    choice = json.loads((directory / STARTS_FILE).read_text())
    return [start for start in choice["starts"] if start["seed"] != choice["chosen"]]


def _judge(study: Study, cell: Cell, test_views: int) -> None:
    """Writes the evaluation into the cell's directory; `test_views` pictures of an object are taken together."""
    subject = from_checkpoint(load_checkpoint(study.run_directory(cell)))
    pictures = grouped(from_folder(study.test_pictures(cell).path, subject.scene), test_views)
    validation = validation_from(study.validation_pictures(cell).path, subject.scene)
    judge_and_record(subject, pictures, validation, study.evaluation(cell, test_views))


def _to_nobody(step: int, figures: dict[str, float]) -> None:
    """The run directory's metrics.jsonl has the figures."""


def _start_to_nobody(start: Start) -> None:
    """Its starts.json has them."""


def _json(content: object) -> bytes:
    return (json.dumps(content, indent=2) + "\n").encode()
