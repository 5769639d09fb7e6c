"""What was done to a user's own pictures before the training, said and shown."""

from pathlib import Path

import numpy as np
from jaxtyping import Float32
from numpy import ndarray
from rich.console import Console

from imaging.framing import frame_of
from imaging.preparation import fit
from trainer.data.decoding import MOST_PIXELS
from trainer.data.images import ImageSet
from trainer.data.writing import write_bytes
from trainer.errors import DataError
from trainer.evaluation.sheet import write_sheet

SHEET_FILE = "prepared.png"
REFUSED_FILE = "refused.txt"

_MOST_SHOWN = 32
_PAIRS_IN_A_ROW = 4


def check_preparation(folder: Path, images: ImageSet) -> None:
    """Raises DataError where most pictures of a folder were refused: what is left is hardly what was meant."""
    refused = images.preparation.refused
    total = len(images) + len(refused)
    if 2 * len(refused) > total:
        raise DataError(
            f"{len(refused)} of the {total} pictures in {folder} show an object that cannot be told from its "
            f"background; first: {refused[0]}. Expected most of them before a plain background, or cut out with a "
            "transparent one: cut the objects out with a picture editor, or leave the other pictures away"
        )


def report_preparation(console: Console, folder: Path, images: ImageSet, run_directory: Path) -> None:
    """Says how a user's own pictures were prepared, and shows up to 32 of them beside their originals in
    `prepared.png`; refused ones are listed in `refused.txt`. Nothing is said of rendered pictures, which are as they
    were."""
    done = images.preparation
    if done.alpha:
        console.print(f"{done.alpha} pictures cut out by their transparency, and framed")
    if done.background:
        console.print(f"{done.background} pictures with a plain background, which was found and removed, and framed")
    if done.refused:
        path = run_directory / REFUSED_FILE
        write_bytes(path, ("\n".join(done.refused) + "\n").encode())
        console.print(f"{len(done.refused)} pictures refused: {path}")
    if done.alpha or done.background:
        path = run_directory / SHEET_FILE
        shown = np.linspace(0, len(images) - 1, min(_MOST_SHOWN, len(images))).round().astype(np.int64)
        tiles = [tile for index in shown for tile in _pair(folder, images, int(index))]
        row = 2 * _PAIRS_IN_A_ROW
        rows = [tiles[start : start + row] for start in range(0, len(tiles), row)]
        write_sheet(path, rows, ("original", "prepared") * (len(rows[0]) // 2))
        console.print(f"look at {path}: this is what is trained on")


def _pair(folder: Path, images: ImageSet, index: int) -> list[Float32[ndarray, "H W 3"]]:
    """A picture before and after."""
    height, width = images.pictures.shape[2:]
    camera = images.scene.camera
    frame = frame_of(width, height, camera.distance, camera.field_of_view_degrees)
    original = fit((folder / images.names[index]).read_bytes(), frame, MOST_PIXELS).picture
    return [original.transpose(1, 2, 0), images.batch(np.array([index]))[0].permute(1, 2, 0).numpy()]
