"""Connected regions of a mask, by runs: stretches of a row that are set."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Regions(NamedTuple):
    """The regions of a mask [H, W], numbered 0 … N - 1."""

    mask: NDArray[np.bool_]
    run_regions: NDArray[np.intp]
    """[runs] the region of each run, in the order of rows and columns."""
    run_lengths: NDArray[np.intp]
    """[runs] pixels."""
    areas: NDArray[np.intp]
    """[N] pixels."""
    at_border: NDArray[np.bool_]
    """[N] whether the region touches the mask's border."""


def regions_of(mask: NDArray[np.bool_]) -> Regions:
    """The regions of pixels that share a side."""
    height, width = mask.shape
    # A column on either side parts the runs of a row from those of the next in one flat order.
    padded = np.zeros((height, width + 2), np.int8)
    padded[:, 1:-1] = mask
    steps = np.diff(padded.ravel())
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    roots = _joined(*_neighbours(starts, ends, width + 2), len(starts))
    numbers = np.cumsum(roots == np.arange(len(roots))) - 1
    run_regions, count = numbers[roots], int(numbers[-1]) + 1 if len(numbers) else 0
    rows, first, last = starts // (width + 2), starts % (width + 2), ends % (width + 2)
    outermost = (rows == 0) | (rows == height - 1) | (first == 0) | (last == width)
    return Regions(
        mask,
        run_regions,
        ends - starts,
        np.bincount(run_regions, ends - starts, count).astype(np.intp),
        np.bincount(run_regions, outermost, count) > 0,
    )


def selected(regions: Regions, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """[H, W] the mask of the `chosen` [N] regions."""
    mask = np.zeros_like(regions.mask)
    mask[regions.mask] = np.repeat(chosen[regions.run_regions], regions.run_lengths)
    return mask


def flooded(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """[H, W] what of a mask is connected with the border."""
    regions = regions_of(mask)
    return selected(regions, regions.at_border)


def sums_over(regions: Regions, values: NDArray[np.float32]) -> NDArray[np.float64]:
    """[N] the sum of `values` [H, W] over each region."""
    labels = np.repeat(regions.run_regions, regions.run_lengths)
    return np.bincount(labels, values[regions.mask], len(regions.areas)).astype(np.float64)


def _neighbours(
    starts: NDArray[np.intp], ends: NDArray[np.intp], stride: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs (upper, lower) of runs that share a side."""
    first = np.searchsorted(ends, starts + stride, "right")
    counts = np.maximum(np.searchsorted(starts, ends + stride, "left") - first, 0)
    upper = np.repeat(np.arange(len(starts)), counts)
    offsets = np.arange(len(upper)) - np.repeat(np.cumsum(counts) - counts, counts)
    return upper, np.repeat(first, counts) + offsets


def _joined(upper: NDArray[np.intp], lower: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """The least run that each run is connected with."""
    root = np.arange(count)
    while True:
        above, below = root[upper], root[lower]
        apart = above != below
        if not apart.any():
            return root
        upper, lower, above, below = upper[apart], lower[apart], above[apart], below[apart]
        least = np.minimum(above, below)
        np.minimum.at(root, above, least)
        np.minimum.at(root, below, least)
        while (root[root] != root).any():
            root = root[root]
