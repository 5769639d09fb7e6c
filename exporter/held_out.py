"""What pictures that a model was not trained on cost it: the yardstick of the service's out-of-class score."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float32
from numpy import ndarray

from exporter.errors import ExportError
from imaging.preparation import Prepared
from service.errors import ImageError
from service.explanation import unexplained
from service.image import read_picture
from service.inference import Engine, decode, encode
from service.manifest import Errors, HeldOut
from trainer.data.decoding import MOST_PIXELS
from trainer.data.images import load_image_folder

LEAST_PICTURES: Final = 20
"""Of fewer, nobody knows which error one in twenty exceeds."""


def files_in(folder: Path, width: int, height: int) -> list[bytes]:
    """The files of a folder's pictures that can be used. Raises DataError where there are none."""
    return [(folder / name).read_bytes() for name in load_image_folder(folder, width, height).names]


def read_pictures(
    files: Sequence[bytes], width: int, height: int, distance: float, field_of_view_degrees: float, zoom: float
) -> Float32[ndarray, "N 3 {height} {width}"]:
    """Picture files as the service gives them to the encoder; those that cannot be used are left out."""
    prepared = [_prepared(content, width, height, distance, field_of_view_degrees, zoom, True) for content in files]
    pictures = [one.picture for one in prepared if one is not None]
    return np.stack(pictures) if pictures else np.zeros((0, 3, height, width), np.float32)


def measure_held_out(engine: Engine, files: Sequence[bytes]) -> HeldOut:
    """The re-render errors of picture files, measured as the service measures those of uploads.

    A picture in the model's own frame is looked at twice: as it is, and cut out and framed as anybody's own is.

    Raises:
        ExportError: fewer than LEAST_PICTURES can be used.
    """
    framed = [error for content in files if (error := _error(engine, content, keep_framed=True)) is not None]
    fitted = [error for content in files if (error := _error(engine, content, keep_framed=False)) is not None]
    if max(len(framed), len(fitted)) < LEAST_PICTURES:
        raise ExportError(
            f"expected {LEAST_PICTURES} held-out pictures of one object each at least, found "
            f"{max(len(framed), len(fitted))}; name a folder of more with --images, or leave the option away"
        )
    return HeldOut(pictures=len(files), framed=_errors(framed), fitted=_errors(fitted))


def error_of(engine: Engine, prepared: Prepared) -> float:
    """The re-render error of a picture that was prepared for the engine."""
    posterior = encode(engine, prepared.picture)
    return unexplained(engine, prepared, posterior, decode(engine, posterior.shape_mean))


def _error(engine: Engine, content: bytes, keep_framed: bool) -> float | None:
    """The error of one picture; None where it cannot be read, or is not framed although it should be."""
    size, camera = engine.manifest.picture, engine.manifest.camera
    prepared = _prepared(
        content, size.width, size.height, camera.distance, camera.field_of_view_degrees, size.zoom, keep_framed
    )
    if prepared is None or (keep_framed and prepared.method != "framed"):
        return None
    return error_of(engine, prepared)


def _prepared(
    content: bytes,
    width: int,
    height: int,
    distance: float,
    field_of_view_degrees: float,
    zoom: float,
    keep_framed: bool,
) -> Prepared | None:
    """A picture as the service prepares it; None where it cannot be used."""
    try:
        return read_picture(content, width, height, MOST_PIXELS, distance, field_of_view_degrees, keep_framed, zoom)
    except ImageError:
        return None


def _errors(found: Sequence[float]) -> Errors | None:
    if len(found) < LEAST_PICTURES:
        return None
    median, high = (round(float(value), 6) for value in np.quantile(found, (0.5, 0.95)))
    if not median < high:
        raise ExportError(
            f"expected held-out pictures that differ, found a median error of {median:g} and the same for the worst; "
            "name a folder of other pictures with --images"
        )
    return Errors(median=median, high=high)
