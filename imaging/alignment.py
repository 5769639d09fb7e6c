"""A picture brought to where, and as large as, a drawing of it shows what is in it."""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.scaling import area_weights

_MOST: Final = 2.0
"""Times that a picture is enlarged or reduced: a rule that is off by more has not found the object."""


class _Light(NamedTuple):
    """Where the light of a picture is, in picture heights."""

    x: float
    y: float
    spread: float
    """Root mean square distance from there."""


def aligned(picture: NDArray[np.float32], drawing: NDArray[np.floating]) -> NDArray[np.float32]:
    """[3, H, W] the linear picture on black, moved and scaled until the light in it has the centre and the spread of
    the drawing's [3, h, w], which shows the same frame in larger or smaller pixels. As it is where either is black.

    Centre and spread are of all that is seen, so that what sticks out of a shape counts for as little as it covers.
    """
    seen, wanted = _light(picture), _light(drawing)
    if seen is None or wanted is None:
        return picture
    _, height, width = picture.shape
    scale = min(_MOST, max(1 / _MOST, wanted.spread / seen.spread))
    left, top = (height * (own - to / scale) for own, to in ((seen.x, wanted.x), (seen.y, wanted.y)))
    columns, x = area_weights(np.arange(width + 1.0), left, scale, width)
    rows, y = area_weights(np.arange(height + 1.0), top, scale, height)
    moved = np.zeros_like(picture)
    moved[:, y, x] = rows @ picture @ columns.T
    return moved


def _light(picture: NDArray[np.floating]) -> _Light | None:
    """None of a black picture."""
    light = picture.sum(0)
    total, height = float(light.sum()), len(light)
    if total <= 0:
        return None
    # Gathered in pixels' middles, light has a variance that is a twelfth of a pixel's area too large along each axis.
    centres, variance = [], -2 / 12
    for line in (light.sum(0), light.sum(1)):
        places = np.arange(len(line)) + 0.5
        centre = float(line @ places) / total
        centres.append(centre / height)
        variance += float(line @ (places - centre) ** 2) / total
    return _Light(centres[0], centres[1], math.sqrt(max(variance, 1 / 12)) / height)
