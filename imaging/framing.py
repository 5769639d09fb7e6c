"""Where an object stands in a model's pictures, and how a picture is brought there.

A model has seen objects of unit bounding-box diagonal, centred, from one distance. How large a silhouette appears then
depends on the object and its azimuth; over procedural classes its bounding box's diagonal varies least.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.decoding import Picture
from imaging.scaling import area_weights

# Fitted to renderings at 30° elevation, uniform azimuths: see docs/decisions.md for the classes and the deviations.
_DIAGONAL: Final = 0.93
"""Diagonal of a silhouette's bounding box, in units of how long the object's diagonal is when it faces the camera."""
_DROP: Final = 0.023
"""How far the bounding box's centre lies below the picture's, in that unit: what is nearer is lower, and larger."""
# What all but a few of those renderings keep to.
_OFF_CENTRE: Final = 0.13
"""Distance of the box's centre from there, in units of the diagonal."""
_LEAST_SIZE: Final = 0.55
"""Diagonal of the smallest box, in units of the usual one."""
_MOST_SIZE: Final = 1.4
"""Diagonal of the largest box."""
_BLACK: Final = 0.0024
"""Linear intensity of sRGB code 8, which compression may make of black."""


class Frame(NamedTuple):
    """The pictures that a model sees, pixels."""

    width: int
    height: int
    diagonal: float
    """Diagonal of a silhouette's bounding box."""
    drop: float
    """How far that box's centre lies below the picture's."""
    zoom: float = 1.0
    """How many times pictures that are framed already are enlarged about their middle."""


class Box(NamedTuple):
    """A rectangle of a picture file, pixels."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def centre(self) -> tuple[float, float]:
        """Its middle (x, y)."""
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2

    @property
    def diagonal(self) -> float:
        """Its diagonal, pixels."""
        return math.hypot(self.right - self.left, self.bottom - self.top)


def box_around(picture: Picture, opacity: NDArray[np.float32]) -> Box:
    """The box around what is at least half opaque; pixels at its edge count by their opacity [h, w].

    Raises IndexError where nothing is.
    """
    columns, rows = opacity.max(0), opacity.max(1)
    left, top = _first(columns, picture.columns), _first(rows, picture.rows)
    right, bottom = _first(columns[::-1], picture.columns[::-1]), _first(rows[::-1], picture.rows[::-1])
    return Box(left, top, right, bottom)


def _first(profile: NDArray[np.float32], edges: NDArray[np.float64]) -> float:
    """Where the first half opaque pixel of a line begins, with what the one before it covers."""
    first = int(np.flatnonzero(profile > 0.5)[0])
    before = float(profile[first - 1]) if first else 0.0
    return float(edges[first] + (edges[first + 1] - edges[first]) * (1 - float(profile[first]) - before))


def frame_of(width: int, height: int, distance: float, field_of_view_degrees: float, zoom: float = 1.0) -> Frame:
    """The frame of a camera at `distance` (in diagonals of the object) with that vertical field of view, which is that
    of the middle 1 / `zoom` of pictures that are framed already."""
    unit = height / 2 / math.tan(math.radians(field_of_view_degrees) / 2) / distance
    return Frame(width, height, _DIAGONAL * unit, _DROP * unit, zoom)


def fitted(picture: Picture, frame: Frame) -> NDArray[np.float32]:
    """[3, height, width] the whole picture, as large as fits, or its middle where the frame zooms in, centred on black;
    outermost pixels may be mixed with it.

    This is for pictures that are framed already.
    """
    if picture.colour.shape == (3, frame.height, frame.width) and picture.factor == frame.zoom == 1:
        return picture.colour
    width, height = picture.columns[-1], picture.rows[-1]
    scale = frame.zoom * min(frame.width / width, frame.height / height)
    return _placed(picture, frame, scale, (width / 2, height / 2), frame.height / 2)


def framed(picture: Picture, box: Box, frame: Frame) -> NDArray[np.float32]:
    """[3, height, width] the object in `box` of a picture, on black, where and as large as the model expects it."""
    return _placed(picture, frame, frame.diagonal / box.diagonal, box.centre, frame.height / 2 + frame.drop)


def looks_framed(picture: Picture, frame: Frame) -> bool:
    """Whether an opaque picture may be a rendering in this very frame, before it zooms in: as wide for its height, its
    border black, and what is not black about where and about as large as objects are there."""
    scale, colour = frame.width / picture.columns[-1], picture.colour
    border = (colour[:, 0], colour[:, -1], colour[:, :, 0], colour[:, :, -1])
    if abs(picture.rows[-1] * scale - frame.height) > 0.5 or any(line.max() > _BLACK for line in border):
        return False
    visible = colour.max(0) > _BLACK
    if not visible.any():
        return False
    box = box_around(picture, visible.astype(np.float32))
    x, y = box.centre
    drop, diagonal = frame.drop / frame.zoom, frame.diagonal / frame.zoom
    off_centre = math.hypot(x * scale - frame.width / 2, y * scale - frame.height / 2 - drop)
    size = box.diagonal * scale / diagonal
    return off_centre < _OFF_CENTRE * diagonal and _LEAST_SIZE < size < _MOST_SIZE


def _placed(
    picture: Picture, frame: Frame, scale: float, centre: tuple[float, float], height: float
) -> NDArray[np.float32]:
    """The picture scaled about `centre` (pixels of the file), which comes to the frame's middle at `height`."""
    columns, x = area_weights(picture.columns, centre[0] - frame.width / 2 / scale, scale, frame.width)
    rows, y = area_weights(picture.rows, centre[1] - height / scale, scale, frame.height)
    placed = np.zeros((3, frame.height, frame.width), np.float32)
    np.clip(rows @ picture.colour @ columns.T, 0, 1, out=placed[:, y, x])
    return placed
