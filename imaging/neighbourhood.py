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
    """The highest value of each column's stretches of 2 radius + 1, each from the highest of two that are shorter."""
    length, whole = 1, 2 * radius + 1
    if not len(plane):
        return plane
    # The outermost rows lie in every stretch that their copies lie in.
    found: NDArray[Kind] = np.empty((len(plane) + 2 * radius, *plane.shape[1:]), plane.dtype)
    found[:radius], found[radius : radius + len(plane)], found[radius + len(plane) :] = plane[0], plane, plane[-1]
    while length < whole:
        step = min(length, whole - length)
        found = np.maximum(found[:-step], found[step:])
        length += step
    return found


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
