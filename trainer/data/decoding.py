"""One picture file of a folder, as the model sees it, or why it cannot be used."""

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from jaxtyping import UInt8
from numpy import ndarray
from threadpoolctl import threadpool_limits

from imaging.errors import BackgroundError, PictureError
from imaging.framing import Frame
from imaging.preparation import Method, fit, prepare
from imaging.srgb import encode

MOST_PIXELS = 50_000_000
"""Pictures with more pixels are not decoded."""
THREADS = min(8, 2 * (os.cpu_count() or 1))
"""Beyond a few, the reading of many small files gains nothing."""


class Decoded(NamedTuple):
    """A picture in the frame."""

    codes: UInt8[ndarray, "3 H W"]
    """sRGB, over black."""
    method: Method


class Unusable(NamedTuple):
    """A file without a picture for the model."""

    sentence: str
    """Which file, what was expected, and what was found."""
    refused: bool
    """Whether it is a picture, but one whose object cannot be told from its background."""


@contextmanager
def decoders() -> Iterator[Executor]:
    """Threads that decode pictures side by side. Those of BLAS rest meanwhile: for products as small as a picture's
    they would only keep each other waiting."""
    with threadpool_limits(1, "blas"), ThreadPoolExecutor(THREADS) as pool:
        yield pool


def decode_picture(path: Path, frame: Frame, framed: bool) -> Decoded | Unusable:
    """The picture of a file in the frame: fitted where it is `framed` already, else its object is cut out and brought
    there."""
    try:
        content = path.read_bytes()
    except OSError as error:
        return Unusable(f"{path} cannot be read as a picture ({error})", refused=False)
    return decode_content(content, str(path), frame, framed)


def decode_content(content: bytes, name: str, frame: Frame, framed: bool) -> Decoded | Unusable:
    """The same for what such a file holds."""
    try:
        prepared = fit(content, frame, MOST_PIXELS) if framed else prepare(content, frame, MOST_PIXELS, False)
    except BackgroundError as error:
        return Unusable(f"{name}: {error}", refused=True)
    except (OSError, PictureError) as error:
        return Unusable(f"{name} cannot be read as a picture ({error})", refused=False)
    return Decoded(encode(prepared.picture), prepared.method)
