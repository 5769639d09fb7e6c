"""The parts of a bathtub: its wall as one closed surface outside and in, taps, feet and steps.

A bathtub is long along z. One lies with one's back at -z, where a slope or a raised end supports it, and the taps stand
at +z.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, loft, moved, tube

_POINTS = 32


class Level(NamedTuple):
    """One horizontal outline of the wall, metres."""

    half_x: float
    half_z: float
    y: float
    shift: float = 0.0
    """Of its middle towards +z."""
    roundness: float = 2.0
    """Of the superellipse: 2 is an oval, 60 a rectangle."""


def shell(levels: Sequence[Level], rise: float = 0.0, both_ends: bool = False) -> Mesh:
    """The solid through outlines that go up outside, over the rim, and down inside to the floor of the basin.

    The rim is `rise` higher at -z, or at both ends; lower outlines follow it less and less.
    """
    high = max(level.y for level in levels)
    rings = []
    for level in levels:
        along = _unit(level.roundness)
        share = along[:, 1] ** 2 if both_ends else ((1 - along[:, 1]) / 2) ** 2
        y = level.y + rise * share * (level.y / high) ** 2
        rings.append(np.stack((level.half_x * along[:, 0], y, level.half_z * along[:, 1] + level.shift), -1))
    return loft(np.stack(rings))


def _unit(roundness: float) -> Float64[ndarray, "N 2"]:
    """The superellipse of half axes 1; a point lies in each corner, so that a rectangle keeps them."""
    angle = np.arange(_POINTS) * 2 * np.pi / _POINTS
    direction = np.stack((np.cos(angle), np.sin(angle)), -1)
    outline: Float64[ndarray, "N 2"] = direction * (np.abs(direction) ** roundness).sum(1, keepdims=True) ** (
        -1 / roundness
    )
    return outline


def basin(
    half_x: float, half_z: float, rim: float, floor: float, slope: float, foot: float, roundness: float
) -> list[Level]:
    """The inside from the rim's inner edge down: steep at the taps, sloped by `slope` metres at the back."""
    depth = rim - floor
    flat_x, flat_z = half_x - foot, half_z - (slope + foot) / 2
    return [
        Level(half_x, half_z, rim, 0.0, roundness),
        Level(half_x - 0.02, half_z - 0.02, rim - 0.02, 0.0, roundness),
        Level((half_x + flat_x) / 2, half_z - (slope + foot) / 5, rim - 0.5 * depth, (slope - foot) / 5, roundness),
        Level(flat_x, flat_z, floor + 0.12 * depth, (slope - foot) / 2, roundness),
        Level(0.85 * flat_x, 0.92 * flat_z, floor, (slope - foot) / 2, roundness),
    ]


def cast_bowl(rng: Generator, low: float, rim: float, half_x: float, half_z: float, rise: float, both: bool) -> Mesh:
    """A wall of cast iron with a rounded bottom at height `low` and a rolled rim, raised at one end or at both."""
    roll, wall, shift = rng.uniform(0.03, 0.045), 0.05, -0.03
    depth, roundness = rim - low, rng.uniform(2.0, 2.8)
    outline = ((0.45, 0.0), (0.7, 0.07), (0.86, 0.25), (0.94, 0.55), (0.97, 0.85))
    outside = [
        Level(x * half_x, (0.3 + 0.7 * x) * half_z, low + y * depth, shift * (1 - y), roundness) for x, y in outline
    ]
    rolled = [(0.0, rim - 1.6 * roll), (1.0, rim - 1.2 * roll), (1.3, rim - 0.5 * roll), (1.0, rim), (0.3, rim)]
    edge = [Level(half_x + out * roll, half_z + out * roll, y, 0.0, roundness) for out, y in rolled]
    inside = basin(half_x - wall, half_z - wall, rim - 0.01, low + 0.06, rng.uniform(0.25, 0.45), 0.12, roundness)
    return shell([*outside, *edge, *inside], rise, both)


def corner_outline(size: float, front: float, inset: float, y: float, bowed: bool) -> Float64[ndarray, "N 3"]:
    """Outline of a corner tub with walls `size` long, drawn in by `inset`; `front` is its reach from the corner."""
    angle = (np.arange(_POINTS) + 0.5) * 2 * np.pi / _POINTS
    direction = np.stack((np.cos(angle), np.sin(angle)), -1)
    corner, diagonal = np.array([0.0, -0.62 * size]), np.sqrt(0.5)
    normals = np.array([(1, -1), (-1, -1), (1, 1), (-1, 1)]) * diagonal
    reaches = np.array([0.0, 0.0, size, size]) + normals @ corner
    facing = direction @ normals.T
    walls = np.where(facing > 1e-9, (reaches - inset) / np.maximum(facing, 1e-9), np.inf).min(1)
    along = direction @ corner
    if bowed:
        ahead = along + np.sqrt(along**2 - corner @ corner + (front - inset) ** 2)
    else:
        ahead = np.where(
            direction[:, 1] > 1e-9, (front + corner[1] - inset) / np.maximum(direction[:, 1], 1e-9), np.inf
        )
    outline = direction * np.minimum(walls, ahead)[:, None]
    return np.insert(outline, 1, y, axis=1)


def tap(y: float, z: float, size: float, knobs: bool = True) -> Mesh:
    """A spout that bends towards -z over the basin, and two knobs beside it, on a rim at height `y`."""
    bar = 0.16 * size
    bend = [(0.0, y - 0.02, z), (0.0, y + 0.7 * size, z), (0.0, y + size, z - 0.35 * size)]
    parts = [tube([*bend, (0.0, y + 0.95 * size, z - 0.9 * size), (0.0, y + 0.7 * size, z - 1.1 * size)], bar, 8)]
    if knobs:
        x = 0.75 * size
        stem = cylinder((x, y - 0.02, z), (x, y + 0.3 * size, z), 0.8 * bar, 8)
        cross = cylinder((x - 0.28 * size, y + 0.36 * size, z), (x + 0.28 * size, y + 0.36 * size, z), 0.8 * bar, 8)
        parts.append(both_sides(joined(stem, cross)))
    return joined(*parts)


def claws(x: float, z: float, height: float, thickness: float) -> Mesh:
    """Four feet that curve outwards from under the body and end in a ball."""
    feet = []
    for end in (-z, z):
        out = 0.3 * height * np.sign(end)
        path = [(0.72 * x, 1.5 * height, 0.8 * end), (x, height, end), (x + 0.02, 0.5 * height, end + 0.6 * out)]
        foot = (x + 0.04, 0.8 * thickness, end + out)
        feet.append(tube([*path, foot], (1.3 * thickness, thickness, 0.8 * thickness, 0.9 * thickness), 8))
        ball = lathe(
            [(0.6 * thickness, 0.0), (1.2 * thickness, 0.5 * thickness), (0.7 * thickness, 1.5 * thickness)], 10
        )
        feet.append(moved(ball, (foot[0], 0.0, foot[2])))
    return both_sides(joined(*feet))


def steps(width: float, front: float, height: float, count: int) -> Mesh:
    """Stairs towards +z, as high as a tub, against its wall at z = `front`."""
    tread, rise = 0.26, height / (count + 1)
    return joined(
        *(
            box((width, (step + 1) * rise, reach + 0.02), (0.0, (step + 1) * rise / 2, front + reach / 2 - 0.01))
            for step, reach in enumerate(tread * np.arange(count, 0, -1))
        )
    )
