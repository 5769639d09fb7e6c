"""A picture of a mesh on black, from its screen coordinates and the colours of its vertices."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from service.rendering.coverage import cover

Floats = NDArray[np.float64]

_MOST_SAMPLES: Final = 1 << 16
"""Drawn at once: larger pictures take shape in bands. All 786,000 samples of one for people took 50 MiB more."""


class Drawing(NamedTuple):
    """A picture [3, H, W], linear RGB over black, and the share of each pixel that shows the object [H, W]; of several
    with an axis for them in front."""

    colour: Floats
    coverage: Floats


def draw(screen: Floats, colours: Floats, faces: NDArray[np.int64], width: int, height: int, samples: int) -> Drawing:
    """The mesh with vertices at `screen` [V, 3] (x, y in pixels, inverse depth) and linear `colours` [V, 3].

    Each pixel is the mean of `samples`² points on a regular grid. Colours are interpolated on the surface.
    """
    rows = max(1, _MOST_SAMPLES // (width * samples**2))
    bands = [
        draw_all(screen[None] - (0, top, 0), colours[None], faces, width, min(rows, height - top), samples)
        for top in range(0, height, rows)
    ]
    return Drawing(*(np.concatenate([band[plane][0] for band in bands], -2) for plane in range(2)))


def draw_all(
    screens: Floats, colours: Floats, faces: NDArray[np.int64], width: int, height: int, samples: int
) -> Drawing:
    """`draw` for N meshes that share their faces, each in a picture of its own: [N, V, 3] → [N, 3, H, W], [N, H, W]."""
    count, vertices = screens.shape[:2]
    every = (faces + vertices * np.arange(count)[:, None, None]).reshape(-1, 3)
    across, down = width * samples, height * samples
    seen = cover((screens * (samples, samples, 1)).reshape(-1, 3), every, across, down, count)
    values = np.einsum("nk,nkc->nc", seen.weights, colours.reshape(-1, 3)[every[seen.faces]])
    row, column = np.divmod(seen.samples, across)
    pixel = row // samples * width + column // samples
    planes = [np.bincount(pixel, plane, count * height * width) for plane in (*values.T, np.ones(len(pixel)))]
    means = np.stack(planes).reshape(4, count, height, width) / samples**2
    return Drawing(means[:3].swapaxes(0, 1), means[3])
