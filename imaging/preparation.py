"""From a picture file to the picture that a model sees: its object alone on black, where and as large as expected."""

import logging
import math
from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.cutout import cut_out
from imaging.decoding import Picture, PictureFile, part_of
from imaging.errors import BackgroundError
from imaging.foreground import LEAST_SHARE, MOST_SHARE
from imaging.framing import Box, Frame, box_around, fitted, framed, looks_framed

Method = Literal["framed", "alpha", "background"]

_DETAIL: Final = 2
"""Pictures are worked on at this many times the frame's size."""
_LEAST_DETAIL: Final = 1.25
"""At least so many pixels are worked on for one of the frame, where the file has them."""
_MARGIN: Final = 0.15
"""Width of the background that is looked at around an object, in its diagonals."""
_LEAST_ACROSS: Final = 16
"""Pixels of the file: an object that is smaller shows nothing but noise."""
_LEAST_OPAQUE: Final = 0.5
"""Opacity above which a pixel is the object's."""

logger = logging.getLogger(__name__)


class Prepared(NamedTuple):
    """A picture as a model sees it."""

    picture: NDArray[np.float32]
    """[3, height, width] linear RGB 0..1 over black, row 0 on top."""
    method: Method
    """It was framed already; or its object was told from the background by transparency, or by colour."""


class _Cutout(NamedTuple):
    picture: Picture
    box: Box
    method: Method


def fit(content: bytes, frame: Frame, max_pixels: int) -> Prepared:
    """The whole picture in a file, which is framed already: fitted into the frame, black where it is transparent.

    Raises PictureError where the file cannot be decoded.
    """
    return Prepared(fitted(_seen(PictureFile(content, max_pixels), frame), frame), "framed")


def prepare(content: bytes, frame: Frame, max_pixels: int, keep_framed: bool) -> Prepared:
    """The object of a picture file, cut out and brought into the frame.

    Where the picture has transparency, that is what tells the object; else a plain background is found and removed. If
    `keep_framed`, a picture that looks like a rendering in this frame, its border black, is fitted as it is.

    Raises PictureError where the file cannot be decoded; BackgroundError where the object cannot be told from what is
    around it, or is tiny.
    """
    (prepared,) = prepare_all(content, (frame,), max_pixels, keep_framed)
    return prepared


def prepare_all(content: bytes, frames: Sequence[Frame], max_pixels: int, keep_framed: bool) -> list[Prepared]:
    """`prepare` for several frames, which share what they have in common. Raises as it does."""
    file, known = PictureFile(content, max_pixels), dict[tuple[int, int], _Cutout]()
    return [_prepared(file, frame, keep_framed, known) for frame in frames]


def _prepared(file: PictureFile, frame: Frame, keep_framed: bool, known: dict[tuple[int, int], _Cutout]) -> Prepared:
    """As `prepare`. What is cut out of the file is `known` by how far the file is reduced: to tell the object, and to
    cut it out."""
    picture = _seen(file, frame)
    if keep_framed and picture.opacity is None and looks_framed(picture, frame):
        return Prepared(fitted(picture, frame), "framed")
    from_afar = picture.factor, picture.factor
    if from_afar not in known:
        known[from_afar] = _cut_out(picture)
    cutout = known[from_afar]
    # An object that is small in its picture has more detail in the file.
    factor = max(1, int(cutout.box.diagonal / (_LEAST_DETAIL * frame.diagonal)))
    if factor < picture.factor:
        if (picture.factor, factor) not in known:
            known[picture.factor, factor] = _closer(file, picture, factor, cutout)
        cutout = known[picture.factor, factor]
    return Prepared(framed(cutout.picture, cutout.box, frame), cutout.method)


def _seen(file: PictureFile, frame: Frame) -> Picture:
    """A picture file with as much detail as the frame shows. Raises PictureError where it cannot be decoded."""
    return file.reduced(*(math.ceil(_DETAIL * frame.zoom * side) for side in (frame.width, frame.height)))


def _cut_out(picture: Picture) -> _Cutout:
    """Raises BackgroundError where the object cannot be told, or is tiny."""
    alone, method = _alone(picture)
    return _Cutout(alone, _box(alone), method)


def _closer(file: PictureFile, picture: Picture, factor: int, cutout: _Cutout) -> _Cutout:
    """What was cut out of a picture, cut out once more of the file, reduced by no more than `factor`."""
    width, height = int(picture.columns[-1]) // factor, int(picture.rows[-1]) // factor
    part = _around(file.reduced(width, height), cutout.box)
    try:
        return _cut_out(part)._replace(method=cutout.method)
    except BackgroundError as error:
        # Close by there may be too little background to judge by; from afar there was enough.
        logger.debug("an object of %.0f pixels is taken as seen from afar: %s", cutout.box.diagonal, error)
        return cutout


def _alone(picture: Picture) -> tuple[Picture, Method]:
    """The object of a picture, on black, and how it was told. Raises BackgroundError where it cannot be told."""
    if picture.opacity is None:
        return cut_out(picture), "background"
    if picture.opacity.min() > _LEAST_OPAQUE:
        return cut_out(picture._replace(colour=picture.colour / picture.opacity, opacity=None)), "background"
    share = float((picture.opacity > _LEAST_OPAQUE).mean())
    if not LEAST_SHARE <= share <= MOST_SHARE:
        raise BackgroundError(
            f"expected an object on {LEAST_SHARE:.0%} to {MOST_SHARE:.0%} of the picture and transparency around it, "
            f"found {share:.1%} that is not transparent"
        )
    return picture, "alpha"


def _box(cutout: Picture) -> Box:
    """Around all that the object covers at least half. Raises BackgroundError where that is tiny."""
    opacity = np.ones_like(cutout.colour[0]) if cutout.opacity is None else cutout.opacity
    if opacity.max() <= _LEAST_OPAQUE:
        raise BackgroundError("expected an object that stands out from its background, found one that hardly does")
    box = box_around(cutout, opacity)
    across = max(box.right - box.left, box.bottom - box.top)
    if across < _LEAST_ACROSS:
        raise BackgroundError(
            f"expected an object of at least {_LEAST_ACROSS} pixels across, found one of {across:.0f}"
        )
    return box


def _around(picture: Picture, box: Box) -> Picture:
    """The part of a picture about a box."""
    margin = _MARGIN * box.diagonal
    first_column, last_column = np.searchsorted(picture.columns, (box.left - margin, box.right + margin))
    first_row, last_row = np.searchsorted(picture.rows, (box.top - margin, box.bottom + margin))
    rows, columns = slice(max(0, first_row - 1), last_row), slice(max(0, first_column - 1), last_column)
    return part_of(picture, rows, columns)
