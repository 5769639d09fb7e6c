"""What refinement at test time adds to the latency of an answer."""

import json
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import torch

from trainer.data.images import load_image_folder
from trainer.data.writing import write_bytes
from trainer.evaluation.pictures import linear_batches
from trainer.evaluation.subject import Subject, answer

_PICTURES = 24


def refinement_ms(subject: Subject, folder: Path, file: Path) -> float:
    """How much longer a refined answer takes than one without, milliseconds: the median over pictures of a folder, each
    answered with and without in turn, by graphs and renderer in one thread. `file` keeps it."""
    if file.exists():
        return float(json.loads(file.read_text(encoding="utf-8"))["refinement_ms"])
    scene = subject.scene
    (images,) = linear_batches(load_image_folder(folder, scene.width, scene.height, scene).pictures[:_PICTURES])
    plain = replace(subject, refinement=0)
    # The first answers compile and load.
    _milliseconds(subject, images[:1])
    added = median(_milliseconds(subject, image[None]) - _milliseconds(plain, image[None]) for image in images)
    write_bytes(file, (json.dumps({"refinement_ms": round(added, 3)}) + "\n").encode())
    return round(added, 3)


def _milliseconds(subject: Subject, image: torch.Tensor) -> float:
    start = time.perf_counter()
    answer(subject, image, 1)
    return 1e3 * (time.perf_counter() - start)
