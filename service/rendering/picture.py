"""A picture of a mesh on black, from its screen coordinates and the colours of its vertices."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from service.rendering.coverage import cover

Floats = NDArray[np.float64]


class Drawing(NamedTuple):
    """A picture [3, H, W], linear RGB over black, and the share of each pixel that shows the object [H, W]."""

    colour: Floats
    coverage: Floats


def draw(screen: Floats, colours: Floats, faces: NDArray[np.int64], width: int, height: int, samples: int) -> Drawing:
    """The mesh with vertices at `screen` [V, 3] (x, y in pixels, inverse depth) and linear `colours` [V, 3].

    Each pixel is the mean of `samples`² points on a regular grid. Colours are interpolated on the surface.
    """
    seen = cover(screen * (samples, samples, 1), faces, width * samples, height * samples)
    values = np.einsum("nk,nkc->nc", seen.weights, colours[faces[seen.faces]])
    row, column = np.divmod(seen.samples, width * samples)
    pixel = row // samples * width + column // samples
    planes = [np.bincount(pixel, plane, height * width) for plane in (*values.T, np.ones(len(pixel)))]
    means = np.stack(planes).reshape(4, height, width) / samples**2
    return Drawing(means[:3], means[3])
