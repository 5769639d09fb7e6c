"""From a picture file to the picture that a model sees: its object alone on black, where and as large as expected."""

import logging
import math
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.cutout import cut_out
from imaging.decoding import Picture, decode, part_of
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


def fit(content: bytes, frame: Frame, max_pixels: int) -> Prepared:
    """The whole picture in a file, which is framed already: fitted into the frame, black where it is transparent.

    Raises PictureError where the file cannot be decoded.
    """
    picture = _decoded(content, frame, max_pixels)
    return Prepared(fitted(picture, frame), "framed")


def prepare(content: bytes, frame: Frame, max_pixels: int, keep_framed: bool) -> Prepared:
    """The object of a picture file, cut out and brought into the frame.

    Where the picture has transparency, that is what tells the object; else a plain background is found and removed. If
    `keep_framed`, a picture that looks like a rendering in this frame, its border black, is fitted as it is.

    Raises PictureError where the file cannot be decoded; BackgroundError where the object cannot be told from what is
    around it, or is tiny.
    """
    picture = _decoded(content, frame, max_pixels)
    if keep_framed and picture.opacity is None and looks_framed(picture, frame):
        return Prepared(fitted(picture, frame), "framed")
    cutout, method = _alone(picture)
    box = _box(cutout)
    # An object that is small in its picture has more detail in the file.
    factor = max(1, int(box.diagonal / (_LEAST_DETAIL * frame.diagonal)))
    if factor < picture.factor:
        width, height = int(picture.columns[-1]) // factor, int(picture.rows[-1]) // factor
        closer = _around(decode(content, width, height, max_pixels), box)
        try:
            cutout, _ = _alone(closer)
            box = _box(cutout)
        except BackgroundError as error:
            # Close by there may be too little background to judge by; from afar there was enough.
            logger.debug("an object of %.0f pixels is taken as seen from afar: %s", box.diagonal, error)
    return Prepared(framed(cutout, box, frame), method)


def _decoded(content: bytes, frame: Frame, max_pixels: int) -> Picture:
    """A picture file with as much detail as the frame shows. Raises PictureError where it cannot be decoded."""
    width, height = (math.ceil(_DETAIL * frame.zoom * side) for side in (frame.width, frame.height))
    return decode(content, width, height, max_pixels)


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
