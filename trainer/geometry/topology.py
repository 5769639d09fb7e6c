"""The subdivided cube, the base mesh of the *subdivision* parameterisation (section 3 of the paper)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int64


class BaseMesh(NamedTuple):
    """A closed mesh: vertices in the object frame, faces counter-clockwise from outside."""

    vertices: Float[np.ndarray, "V 3"]
    faces: Int64[np.ndarray, "F 3"]


def subdivided_cube(segments: int, side: float = 1.0, proportions: tuple[int, int, int] = (1, 1, 1)) -> BaseMesh:
    """A cube around the origin, each edge cut into `segments`: 6·segments² + 2 vertices, 12·segments² faces; edges
    along x, y and z into so many times as many as the `proportions` say.

    The diagonals are laid so that the mesh is its own mirror image in x, y and z (exactly so where edges are cut into
    even numbers).
    """
    counts = segments * np.array(proportions)
    lattice: dict[tuple[int, int, int], int] = {}
    faces: list[tuple[int, int, int]] = []

    def corner(point: np.ndarray) -> int:
        return lattice.setdefault((int(point[0]), int(point[1]), int(point[2])), len(lattice))

    for axis in range(3):
        for outward in (-1, 1):
            # (u, v, normal) is right-handed, so that u then v turns counter-clockwise as seen from outside.
            u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]][::outward]
            origin = np.eye(3, dtype=int)[axis] * (counts if outward > 0 else 0)
            along, across = counts @ u, counts @ v
            for i in range(along):
                for j in range(across):
                    a = corner(origin + i * u + j * v)
                    b = corner(origin + (i + 1) * u + j * v)
                    c = corner(origin + (i + 1) * u + (j + 1) * v)
                    d = corner(origin + i * u + (j + 1) * v)
                    if (2 * i + 1 > along) == (2 * j + 1 > across):
                        faces += [(a, b, c), (a, c, d)]
                    else:
                        faces += [(a, b, d), (b, c, d)]
    vertices = (np.array(list(lattice), dtype=np.float64) / counts - 0.5) * side
    return BaseMesh(vertices, np.array(faces, dtype=np.int64))


def vertex_neighbours(faces: Int64[np.ndarray, "F 3"], vertex_count: int) -> Float[np.ndarray, "V V"]:
    """Row-normalised adjacency: row i averages over the neighbours of vertex i (zero for a vertex without any)."""
    adjacency = np.zeros((vertex_count, vertex_count))
    for a, b in ((0, 1), (1, 2), (2, 0)):
        adjacency[faces[:, a], faces[:, b]] = 1.0
        adjacency[faces[:, b], faces[:, a]] = 1.0
    degree = adjacency.sum(1, keepdims=True)
    weights: Float[np.ndarray, "V V"] = np.divide(adjacency, degree, out=np.zeros_like(adjacency), where=degree > 0)
    return weights


def underside(vertices: Float[np.ndarray, "V 3"], faces: Int64[np.ndarray, "F 3"]) -> Bool[np.ndarray, "V"]:
    """Which vertices all of whose faces look straight down: no camera above the horizon sees them."""
    corner, along, beside = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(along - corner, beside - corner)
    down = normals[:, 1] < -(1 - 1e-6) * np.linalg.norm(normals, axis=1)
    seen = np.zeros(len(vertices), bool)
    seen[faces[~down]] = True
    return ~seen
