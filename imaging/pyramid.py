"""The Gaussian pyramid of Eqs. 1, 2 and 4 of the paper as one linear map: pictures → numbers whose squares add up.

With noise ε/2^l at level l and ε = 1, −log p = ½ Σ_l 4^l ‖K_l (I − x)‖². The map gives 2^l K_l x of all levels in a
row, so −log p is half the squared distance of what it makes of the two pictures. Borders and levels are those of the
rasteriser's pyramid: reflected, and down to one pixel in the smaller dimension.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

_KERNEL = (1 / 16, 4 / 16, 6 / 16, 4 / 16, 1 / 16)


def pyramid(pictures: Array) -> Array:
    """[N, D] of pictures [N, C, H, W]."""
    level, weight, parts = np.ascontiguousarray(pictures, np.float32), 1.0, []
    while True:
        parts.append(np.float32(weight) * level.reshape(len(level), -1))
        height, width = level.shape[-2:]
        if min(height, width) == 1:
            return np.concatenate(parts, 1)
        level = np.matmul(_halving(height) @ level, _halving(width).T, dtype=np.float32)
        weight *= 2


@lru_cache
def _halving(size: int) -> Array:
    """[ceil(size / 2), size]: smoothing along one axis at every second pixel, index −1 being index 1."""
    matrix = np.zeros(((size + 1) // 2, size), np.float32)
    period = 2 * (size - 1)
    for row in range(len(matrix)):
        for tap, share in enumerate(_KERNEL):
            index = (2 * row + tap - 2) % period
            matrix[row, min(index, period - index)] += share
    return matrix
