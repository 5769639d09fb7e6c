"""Distances between surfaces: points spread evenly over what can be seen of each, and how near the other's are."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Integer
from numpy import ndarray
from scipy.spatial import cKDTree

POINTS = 2048
"""Points on each surface."""

# Steps of the R₂ sequence: powers of 1 / 1.3247…, the root of x³ = x + 1. Each next point falls into a gap.
_STEPS = 1.324717957244746 ** -np.arange(1.0, 3.0)
# How far from a point its two sides are probed, in fine voxels: beyond those that the surface itself passes.
_PROBE = 1.5
_MOST_CANDIDATES = 64


class Surface(NamedTuple):
    """Points on a surface, and the unit normals of the faces that they lie on."""

    points: Float[ndarray, "P 3"]
    normals: Float[ndarray, "P 3"]


class Agreement(NamedTuple):
    """How well two surfaces agree."""

    chamfer_distance: float
    """Mean distance from a point to the nearest one on the other surface, mean of both directions; in the vertices'
    unit."""
    normal_consistency: float
    """Mean |cos| of the angle between a point's normal and that of the nearest one, mean of both directions."""


def visible_surface(
    vertices: Float[ndarray, "V 3"],
    faces: Integer[ndarray, "F 3"],
    air: Bool[ndarray, "M M M"],
    count: int = POINTS,
    start: float = 0.5,
) -> Surface:
    """`count` points, spread evenly over those parts of a mesh in the cube [-0.5, 0.5]³ that have air on either side.

    What lies inside the object is left out: parts that other parts cover, linings, rubbish. `start` in [0, 1) names one
    of many such samples. Fewer points come back where hardly anything can be seen, and none of a mesh without area.
    """
    corners = np.asarray(vertices, np.float64)[np.asarray(faces)]
    candidates = count
    while True:
        surface = _spread(corners, candidates, start)
        seen = np.flatnonzero(_touches_air(surface, air))
        if len(seen) >= count or len(seen) == 0 or candidates >= _MOST_CANDIDATES * count:
            break
        candidates = min(math.ceil(1.1 * candidates * count / len(seen)), _MOST_CANDIDATES * count)
    chosen = seen[np.linspace(0, len(seen) - 1, min(count, len(seen))).astype(int)]
    return Surface(surface.points[chosen], surface.normals[chosen])


def _spread(corners: Float[ndarray, "F 3 3"], count: int, start: float) -> Surface:
    """Points at equal steps along the faces' areas laid end to end, and in each face at those of a sequence that fills
    the gaps."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(first, second)
    doubled_area = np.linalg.norm(normals, axis=1)
    ends = np.cumsum(doubled_area)
    if len(ends) == 0 or not ends[-1] > 0:
        return Surface(np.empty((0, 3)), np.empty((0, 3)))
    number = np.arange(count) + start
    face = np.minimum(np.searchsorted(ends, number / count * ends[-1], side="right"), len(ends) - 1)
    along, across = np.remainder(number[:, None] * _STEPS, 1.0).T
    beyond = along + across > 1
    along, across = np.where(beyond, 1 - along, along), np.where(beyond, 1 - across, across)
    points = corners[face, 0] + along[:, None] * first[face] + across[:, None] * second[face]
    return Surface(points, normals[face] / np.maximum(doubled_area[face], 1e-300)[:, None])


def _touches_air(surface: Surface, air: Bool[ndarray, "M M M"]) -> Bool[ndarray, "P"]:
    size = len(air)
    seen = np.zeros(len(surface.points), np.bool_)
    for side in (-_PROBE, _PROBE):
        voxel = np.floor((surface.points + 0.5) * size + side * surface.normals).astype(np.int64)
        outside = ((voxel < 0) | (voxel >= size)).any(1)
        seen |= outside | air[tuple(voxel.clip(0, size - 1).T)]
    return seen


def agreement(first: Surface, second: Surface) -> Agreement:
    """Chamfer distance and normal consistency of two sampled surfaces; 1 (the object's diagonal) and 0 where one has no
    points.

    Two samples of one surface do not have distance 0, but about half of the points' spacing.
    """
    if len(first.points) == 0 or len(second.points) == 0:
        return Agreement(1.0, 0.0)
    there, nearest_there = cKDTree(second.points).query(first.points)
    back, nearest_back = cKDTree(first.points).query(second.points)
    cosines = (
        np.abs((first.normals * second.normals[nearest_there]).sum(1)).mean(),
        np.abs((second.normals * first.normals[nearest_back]).sum(1)).mean(),
    )
    return Agreement(float(there.mean() + back.mean()) / 2, float(sum(cosines)) / 2)
