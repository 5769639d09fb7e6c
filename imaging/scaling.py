"""Area means: each pixel of a reduced picture is the mean of what it covers of the larger one."""

import math

import numpy as np
from numpy.typing import NDArray


def area_weights(
    edges: NDArray[np.float64], origin: float, scale: float, size: int
) -> tuple[NDArray[np.float32], slice]:
    """The share that each of N old pixels has in each of `size` new ones, along one axis: [n, N] for those n of the
    new pixels that have any, and which those are.

    `edges` [N + 1] are the lines between the old pixels, and `origin` is where the new ones begin, both in one unit;
    `scale` is how many new pixels a unit becomes. Reduced, a pixel is the exact mean over what it covers, with 0
    outside of the old picture. Enlarged, it is the mean over an old pixel's length: linear interpolation.
    """
    reach = max(1 / scale, float(edges[1] - edges[0])) / 2
    first = max(0, math.floor((edges[0] - reach - origin) * scale - 0.5))
    last = min(size, math.ceil((edges[-1] + reach - origin) * scale + 0.5))
    centres = origin + (np.arange(first, last)[:, None] + 0.5) / scale
    overlap = np.minimum(centres + reach, edges[1:]) - np.maximum(centres - reach, edges[:-1])
    return (overlap.clip(0) / (2 * reach)).astype(np.float32), slice(first, max(first, last))


def block_means(planes: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """[..., ceil(H / factor), ceil(W / factor)] means over squares; the last ones are over what there is of them."""
    if factor == 1:
        return planes
    return _row_means(_row_means(planes, factor).swapaxes(-1, -2), factor).swapaxes(-1, -2)


def _row_means(planes: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    means = planes[..., ::factor, :].copy()
    for start in range(1, factor):
        part = planes[..., start::factor, :]
        means[..., : part.shape[-2], :] += part
    means /= np.float32(factor)
    if left := planes.shape[-2] % factor:
        means[..., -1, :] *= factor / left
    return means
