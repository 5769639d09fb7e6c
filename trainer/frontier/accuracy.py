"""How well a point does on pictures of objects that no training saw."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from trainer.data.images import load_image_folder
from trainer.data.scene import read_scene
from trainer.data.writing import write_bytes
from trainer.evaluation.gallery import render
from trainer.evaluation.pictures import from_folder, linear_batches, validation_from
from trainer.evaluation.record import judge_and_record
from trainer.evaluation.subject import Subject, predict
from trainer.tables.cells import Cell
from trainer.tables.study import Study

_PICTURE_FILE = "picture-error.json"


@dataclass(frozen=True)
class Run:
    """One training of a point, judged."""

    seed: int
    steps: int
    minutes: float
    """Of training, on one core: the time that it computed, not that in which others did."""
    iou: float
    iou_interval: tuple[float, float]
    """95 %, over objects."""
    azimuth_error_degrees: float
    azimuth_accuracy: float
    flipped: float
    picture_error: float
    """Mean absolute difference of picture and reconstruction, linear RGB 0 to 1, at the size of the test pictures
    whatever the model's own is."""
    mean_shape_iou: float
    nearest_neighbour_iou: float


def judged(study: Study, cell: Cell, subject: Subject, kind: str) -> Run:
    """What `trainer evaluate` finds of a subject that was made from a cell; `kind` says how, and is empty for the
    training itself. Nothing is judged twice."""
    steps, output = study.trained(cell)["steps"], evaluation_of(study, cell, kind)
    metrics = _read(output / "metrics.json", steps)
    if metrics is None:
        pictures = from_folder(study.test_pictures(cell).path, subject.scene)
        validation = validation_from(study.validation_pictures(cell).path, subject.scene)
        _, metrics = judge_and_record(subject, pictures, validation, output)
    common = _read(output / _PICTURE_FILE, steps)
    if common is None:
        common = {"step": steps, "picture_error": picture_error(subject, study.test_pictures(cell).path)}
        write_bytes(output / _PICTURE_FILE, (json.dumps(common) + "\n").encode())
    low, high = metrics["iou_interval"]
    return Run(
        seed=cell.seed,
        steps=steps,
        minutes=round(study.trained(cell)["core_seconds"] / 60, 3),
        iou=metrics["iou"],
        iou_interval=(low, high),
        azimuth_error_degrees=metrics["azimuth_error_degrees"],
        azimuth_accuracy=metrics["azimuth_accuracy"],
        flipped=metrics["flipped"],
        picture_error=common["picture_error"],
        mean_shape_iou=metrics["mean_shape_iou"],
        nearest_neighbour_iou=metrics["nearest_neighbour_iou"],
    )


def evaluation_of(study: Study, cell: Cell, kind: str) -> Path:
    """Where the files of a judgement are."""
    plain = study.evaluation(cell, 1)
    return plain.with_name(f"{plain.name}-{kind}") if kind else plain


def picture_error(subject: Subject, folder: Path) -> float:
    """Mean absolute difference of test pictures and reconstructions, drawn at the pictures' own size."""
    own = subject.scene
    scene = read_scene(folder) or own
    prediction = predict(subject, load_image_folder(folder, own.width, own.height, own).pictures)
    start, errors = 0, []
    for images in linear_batches(load_image_folder(folder, scene.width, scene.height).pictures):
        shown = prediction.of(torch.arange(start, start + len(images)))
        drawn = render(subject.faces, scene, shown.vertices, shown.azimuths, shown.light_azimuths)
        errors.append((drawn - images).abs().mean((1, 2, 3)))
        start += len(images)
    return round(float(torch.cat(errors).mean()), 5)


def _read(path: Path, steps: int) -> dict[str, Any] | None:
    """What was found of a training of so many steps, if anything was."""
    if not path.exists():
        return None
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found if found["step"] == steps else None
