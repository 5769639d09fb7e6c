"""Contact sheets of a judgement: figures hide what a glance shows."""

from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float, Int, Integer
from numpy import ndarray

from trainer.evaluation.gallery import comparison_rows, render
from trainer.evaluation.pictures import Pictures, linear_batches
from trainer.evaluation.protocol import Judgement
from trainer.evaluation.sheet import write_sheet
from trainer.evaluation.subject import Subject

ROWS = 8
"""Pictures on each sheet."""


def write_sheets(output: Path, subject: Subject, pictures: Pictures, judgement: Judgement) -> None:
    """Writes best.png, median.png and worst.png, objects in the order of their IoU, and sheet.png, pictures from all of
    the test set: input, reconstruction, three other sides.

    Raises StorageError where a file cannot be written.
    """
    rising = ranked(judgement.overlaps, pictures.objects)
    middle = max(0, (len(rising) - ROWS) // 2)
    even = np.linspace(0, len(pictures.codes) - 1, min(ROWS, len(pictures.codes))).astype(int)
    chosen = {
        "best": rising[::-1][:ROWS],
        "median": rising[middle : middle + ROWS],
        "worst": rising[:ROWS],
        "sheet": even,
    }
    for name, numbers in chosen.items():
        (images,) = linear_batches(pictures.codes[numbers])
        shown = judgement.prediction.of(torch.tensor(numbers.tolist()))
        reconstructions = render(subject.faces, subject.scene, shown.vertices, shown.azimuths, shown.light_azimuths)
        titles, rows = comparison_rows(
            subject.faces, subject.scene, images, reconstructions, shown.vertices, judgement.offset
        )
        labels = [f"IoU {judgement.overlaps[number]:.2f}" for number in numbers]
        write_sheet(output / f"{name}.png", rows, titles, labels)


def ranked(overlaps: Float[ndarray, "N"], objects: Int[ndarray, "N"]) -> Integer[ndarray, "K"]:
    """A picture of each object, by rising IoU: the one in the middle of the object's own."""
    middles = []
    for index in np.unique(objects):
        own = np.flatnonzero(objects == index)
        middles.append(own[np.argsort(overlaps[own], kind="stable")[(len(own) - 1) // 2]])
    found = np.array(middles)
    return found[np.argsort(overlaps[found], kind="stable")]
