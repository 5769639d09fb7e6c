"""What lies within a few pixels of each pixel, in squares; beyond the border there is nothing."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Kind = TypeVar("Kind", np.bool_, np.float32)


def highest(plane: NDArray[Kind], radius: int) -> NDArray[Kind]:
    """[h, w] the highest value, or whether any is set, within `radius`."""
    return _highest_above(_highest_above(plane, radius).T, radius).T


def lowest(plane: NDArray[np.bool_], radius: int) -> NDArray[np.bool_]:
    """[h, w] whether all are set within `radius`."""
    return ~highest(~plane, radius)


def _highest_above(plane: NDArray[Kind], radius: int) -> NDArray[Kind]:
    result = plane.copy()
    for offset in range(1, radius + 1):
        np.maximum(result[offset:], plane[:-offset], out=result[offset:])
        np.maximum(result[:-offset], plane[offset:], out=result[:-offset])
    return result


def total(planes: NDArray[np.float32], radius: int) -> NDArray[np.float32]:
    """[..., h, w] the sum of the values within `radius`."""
    rows = planes.copy()
    for offset in range(1, radius + 1):
        rows[..., offset:, :] += planes[..., :-offset, :]
        rows[..., :-offset, :] += planes[..., offset:, :]
    result = rows.copy()
    for offset in range(1, radius + 1):
        result[..., offset:] += rows[..., :-offset]
        result[..., :-offset] += rows[..., offset:]
    return result
