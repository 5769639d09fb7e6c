"""What each sample of a picture sees of a mesh: a z-buffer without a loop over faces.

Faces become rows of samples, and rows samples, by repetition, so that every step is one array operation; for the few
hundred faces of a model this takes less than a millisecond, and needs no compiler.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

_DEGENERATE: Final = 1e-6
"""Faces of less area than this (in samples squared) have no reliable plane, and are too thin to hold a sample."""

_MOST_SAMPLES: Final = 1 << 18
"""Held in memory at once; about 100 bytes each."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Coverage(NamedTuple):
    """The N samples that see a face; all others see the background."""

    samples: Integers
    """[N] (picture · height + row) · width + column."""
    faces: Integers
    """[N] the nearest face there."""
    weights: Floats
    """[N, 3] of the face's corners, which sum to 1: linear on the surface, not on the screen."""


class _Rows(NamedTuple):
    """The samples of one row that lie inside one face, for R such pairs."""

    faces: Integers
    rows: Integers
    first: Integers
    counts: Integers


def cover(screen: Floats, faces: Integers, width: int, height: int, pictures: int = 1) -> Coverage:
    """The nearest face at each of height · width samples; both sides of a face are visible.

    `screen` [V, 3] holds x and y in samples from the top left corner, and the inverse depth; sample (row, column) is at
    (column + 0.5, row + 0.5). One on an edge that two faces share belongs to exactly one of them: left and upper edges
    are inside, right and lower ones outside. Several `pictures` have as many of the faces each, one after another.
    """
    faces_each = max(1, len(faces) // pictures)
    corners = screen[faces]
    planes, sound = _planes(corners)
    depth_planes = planes.sum(1)
    rows = _rows(corners, sound, width, height)
    nearest = np.zeros(pictures * height * width)
    owner = np.full(pictures * height * width, -1)
    for portion in _portions(rows.counts):
        counts = rows.counts[portion]
        column = np.repeat(rows.first[portion], counts) + _places(counts)
        row, face = np.repeat(rows.rows[portion], counts), np.repeat(rows.faces[portion], counts)
        sample, plane = (face // faces_each * height + row) * width + column, depth_planes[face]
        nearness = plane[:, 0] * (column + 0.5) + plane[:, 1] * (row + 0.5) + plane[:, 2]
        np.maximum.at(nearest, sample, nearness)
        # Where two faces are equally near, the last one stays.
        ahead = nearness == nearest[sample]
        owner[sample[ahead]] = face[ahead]
    seen = np.flatnonzero(owner >= 0)
    row, column = np.divmod(seen % (height * width), width)
    shares = np.einsum("nkc,nc->nk", planes[owner[seen]], np.stack((column + 0.5, row + 0.5, np.ones(len(seen))), -1))
    return Coverage(seen, owner[seen], shares / shares.sum(1, keepdims=True))


def _portions(counts: Integers) -> Iterator[slice]:
    """Rows, a portion at a time: a mesh much larger than its picture fills all of it many times over."""
    ends = np.cumsum(counts)
    start = 0
    while start < len(counts):
        done = ends[start - 1] if start else 0
        end = max(start + 1, int(np.searchsorted(ends, done + _MOST_SAMPLES, "right")))
        yield slice(start, end)
        start = end


def _planes(corners: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """[F, 3, 3] each corner's part of the inverse depth as an affine function (∂x, ∂y, constant) of the place on the
    screen, and which faces have such planes [F]."""
    x, y = corners[..., 0], corners[..., 1]
    following, last = [1, 2, 0], [2, 0, 1]
    slope_x, slope_y = y[:, following] - y[:, last], x[:, last] - x[:, following]
    constant = x[:, following] * y[:, last] - x[:, last] * y[:, following]
    area = constant.sum(1)
    sound = np.abs(area) > _DEGENERATE
    scale = corners[..., 2] / np.where(sound, area, 1.0)[:, None]
    return np.stack((slope_x, slope_y, constant), -1) * scale[..., None], sound


def _rows(corners: Floats, sound: NDArray[np.bool_], width: int, height: int) -> _Rows:
    """The rows that faces cross, and from where to where."""
    # Corners first [3, F]: numpy is slow along a last axis of three.
    x, y = np.ascontiguousarray(corners[..., 0].T), np.ascontiguousarray(corners[..., 1].T)
    following = [1, 2, 0]
    # Each edge from its upper to its lower corner, whatever the face's winding: two faces that share an edge then
    # compute the same crossings.
    downward = y <= y[following]
    upper_x, lower_x = np.where(downward, x, x[following]), np.where(downward, x[following], x)
    upper_y, lower_y = np.minimum(y, y[following]), np.maximum(y, y[following])
    drop = lower_y - upper_y
    slope = (lower_x - upper_x) / np.where(drop > 0, drop, 1.0)
    top, bottom = _first_sample(y.min(0), height), _first_sample(y.max(0), height)
    heights = np.where(sound, bottom - top, 0)
    face = np.repeat(np.arange(len(corners)), heights)
    row = top[face] + _places(heights)
    place = row + 0.5
    above = upper_y[:, face]
    crossed = (above <= place) & (place < lower_y[:, face])
    crossing = upper_x[:, face] + (place - above) * slope[:, face]
    first = _first_sample(np.where(crossed, crossing, np.inf).min(0), width)
    after = _first_sample(np.where(crossed, crossing, -np.inf).max(0), width)
    return _Rows(face, row, first, np.maximum(after - first, 0))


def _first_sample(place: Floats, limit: int) -> Integers:
    """Index of the first sample whose centre is at or beyond a place, within 0 to `limit`."""
    return np.clip(np.ceil(place - 0.5), 0, limit).astype(np.int64)


def _places(counts: Integers) -> Integers:
    """0, 1, …, count − 1 for each count, in a row."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
