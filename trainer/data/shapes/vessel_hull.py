"""Hulls of boats and ships: one closed surface, decked or hollow, from a dozen measures.

The bow points to +Z and the keel's lowest line is near y = 0. `station` runs from 0 at the stern to 1 at the bow,
`level` from 0 at the keel to 1 at the edge of the deck.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64
from numpy import ndarray

from trainer.data.shapes.solid import Mesh, signed_volume

LEVELS = (0.0, 0.07, 0.2, 0.42, 0.7, 1.0)
_SHARES = (1 + np.cos(np.linspace(0.0, np.pi, 15))) / 2


class Hull(NamedTuple):
    """The measures of a hull, metres where nothing else is said."""

    length: float
    beam: float
    depth: float
    """From the keel to the deck's edge, amidships."""
    bow: float
    """Exponent of the deck's outline forward of the widest station: 1.5 is a wedge, 4 is bluff."""
    entry: float
    """The same at the keel."""
    transom: float
    """Breadth of the stern at the deck as a share of the beam; 0 is pointed."""
    counter: float
    """The same at the keel."""
    widest: float
    """Station of the greatest breadth."""
    rake: float
    """How far the stem leans forward."""
    overhang: float
    """How far the stern leans backward."""
    sheer: tuple[float, float]
    """How much higher the deck's edge is at stern and bow."""
    rocker: tuple[float, float]
    """How much higher the keel is at stern and bow."""
    bilge: float
    """Exponent of the midship section: 1 is a V, 2 round, 6 nearly a box."""

    def deck(self, station: float) -> float:
        """Height of the deck's edge."""
        return float(_rising(np.array([station]), self.depth, self.sheer)[0])

    def z(self, station: float) -> float:
        """Place along the deck."""
        return (station - 0.5) * self.length

    def half(self, station: float, level: float = 1.0) -> float:
        """Half the breadth."""
        return float(_half_breadth(self, np.array([station]), level)[0])


def _rising(stations: Float64[ndarray, "N"], amidships: float, ends: tuple[float, float]) -> Float64[ndarray, "N"]:
    stern, bow = np.maximum(0.5 - stations, 0.0) * 2, np.maximum(stations - 0.5, 0.0) * 2
    return amidships + ends[0] * stern**2.2 + ends[1] * bow**2.2


def _half_breadth(hull: Hull, stations: Float64[ndarray, "N"], level: float) -> Float64[ndarray, "N"]:
    level = min(level, 1.0)
    forward = np.clip((stations - hull.widest) / (1 - hull.widest), 0.0, 1.0)
    aft = np.clip((hull.widest - stations) / hull.widest, 0.0, 1.0)
    exponent = hull.entry + (hull.bow - hull.entry) * level
    stern = hull.counter + (hull.transom - hull.counter) * level
    plan = (1 - forward**exponent) * (1 - (1 - stern) * aft**2.4)
    section = (1 - (1 - level) ** hull.bilge) ** (1 / hull.bilge)
    half: Float64[ndarray, N] = np.maximum(plan * section, 0.012) * hull.beam / 2
    return half


def contour(
    hull: Hull, level: float, inset: float = 0.0, span: tuple[float, float] = (0.0, 1.0), lift: float = 0.0
) -> Float64[ndarray, "N 3"]:
    """The hull's outline at a level, `inset` metres inside of it and `lift` metres above it: from the bow along the
    left side to the stern, and back."""
    stations, keel, rise = _lengthwise(hull, inset, span)
    breadth = _half_breadth(hull, stations, level)
    half = np.maximum(breadth - inset, 0.2 * breadth)
    height = keel + level * rise + lift
    below = max(1 - level, 0.0)
    stern, bow = hull.overhang * below - hull.length / 2, hull.length / 2 - hull.rake * below**1.4
    outline = np.empty((2 * len(half), 3))
    left, right = outline[: len(half)], outline[: len(half) - 1 : -1]
    left[:, 0], left[:, 1], left[:, 2] = half, height, stern + stations * (bow - stern)
    right[:] = left
    right[:, 0] = -half
    return outline


@lru_cache(maxsize=16)
def _lengthwise(hull: Hull, inset: float, span: tuple[float, float]) -> tuple[Float64[ndarray, "N"], ...]:
    """(stations, height of the keel, height of the deck above it), which all contours with this inset share."""
    low, high = span[0] + inset / hull.length, span[1] - (2.2 * inset / hull.length if span[1] == 1.0 else 0.0)
    stations = low + (high - low) * _SHARES
    keel = _rising(stations, 0.0, hull.rocker)
    return stations, keel, _rising(stations, hull.depth, hull.sheer) - keel


def shell(contours: Sequence[Float64[ndarray, "N 3"]]) -> Mesh:
    """The solid through contours; its first and last are closed by strips from side to side, so that a deck follows
    its edges."""
    sections, points = len(contours), len(contours[0])
    mesh = Mesh(np.concatenate(contours), _shell_faces(sections, points))
    return mesh if signed_volume(mesh) >= 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1])


@lru_cache(maxsize=64)
def _shell_faces(sections: int, points: int) -> Int64[ndarray, "F 3"]:
    here = np.arange(points)
    following = (here + 1) % points
    lower = (np.arange(sections - 1) * points)[:, None]
    a, b, c, d = lower + here, lower + following, lower + points + following, lower + points + here
    left = np.arange(points // 2 - 1)
    right = points - 1 - left
    strip = np.concatenate((np.stack((left + 1, left, right), -1), np.stack((left + 1, right, right - 1), -1)))
    faces = np.concatenate(
        (
            np.stack((a, b, c), -1).reshape(-1, 3),
            np.stack((a, c, d), -1).reshape(-1, 3),
            strip,
            strip[:, ::-1] + (sections - 1) * points,
        )
    )
    faces = faces.astype(np.int64)
    # All shells of this size have them in common.
    faces.setflags(write=False)
    return faces


def decked(hull: Hull, bulwark: float = 0.0, wall: float = 0.0) -> Mesh:
    """The hull under a deck; a `bulwark` of this height runs around it, its `wall` so thick."""
    outside = [contour(hull, level) for level in LEVELS]
    if not bulwark:
        return shell(outside)
    return shell(
        [
            *outside,
            contour(hull, 1.0, 0.0, lift=bulwark),
            contour(hull, 1.0, wall, lift=bulwark),
            contour(hull, 1.0, wall),
        ]
    )


def hollow(hull: Hull, wall: float, floor: float) -> Mesh:
    """An open boat: outside up to the gunwale, inside down to the level `floor`."""
    inside = [level for level in LEVELS[::-1] if level > floor + 0.05]
    return shell(
        [*(contour(hull, level) for level in LEVELS), *(contour(hull, level, wall) for level in [*inside, floor])]
    )


def plate(hull: Hull, level: float, thickness: float, span: tuple[float, float], inset: float = 0.0) -> Mesh:
    """A deck, thwart or platform between two stations that fills the hull from side to side."""
    lower = max(level - thickness / hull.depth, 0.05)
    return shell([contour(hull, at, inset, span) for at in (lower, level)])
