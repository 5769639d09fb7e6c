"""The upright plane in which shapes are most nearly their own mirror images."""

import math

import numpy as np
import trimesh
from jaxtyping import Float, Integer
from numpy import ndarray
from scipy.optimize import minimize_scalar
from scipy.spatial import cKDTree

MOST_SHAPES = 64
"""So many are reflected, evenly chosen."""

_POINTS = 1024
_STEP = math.radians(5)


def mirror_plane(shapes: Float[ndarray, "N V 3"], faces: Integer[ndarray, "F 3"]) -> float:
    """How far the plane through the origin is turned about +Y, radians from -π/2 to π/2: 0 is the plane x = 0.

    It is the plane in which reflected points of a shape's surface lie nearest to that surface, in the mean over points
    and shapes; found to a degree or two. Shapes that are like none of their mirror images have such a plane, too, and
    nothing is told of how near it is.
    """
    chosen = np.linspace(0, len(shapes) - 1, min(MOST_SHAPES, len(shapes))).round().astype(np.int64)
    points = [_points(shapes[number], faces) for number in chosen]
    trees = [cKDTree(cloud) for cloud in points]

    def beside(turn: float) -> float:
        """The mean distance of reflected points from the surface."""
        normal = np.array([math.cos(turn), 0.0, -math.sin(turn)])
        images = (cloud - 2 * np.outer(cloud @ normal, normal) for cloud in points)
        return float(np.mean([tree.query(image)[0] for tree, image in zip(trees, images, strict=True)]))

    turns = np.arange(-math.pi / 2, math.pi / 2, _STEP)
    nearest = turns[int(np.argmin([beside(turn) for turn in turns]))]
    around = nearest - _STEP, nearest + _STEP
    found = float(minimize_scalar(beside, bounds=around, method="bounded", options={"xatol": 1e-3}).x)
    return (found + math.pi / 2) % math.pi - math.pi / 2


def _points(vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"]) -> Float[ndarray, "P 3"]:
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    return np.asarray(trimesh.sample.sample_surface(mesh, _POINTS, seed=0)[0])
