"""Cuboidal blocks, from which the *ortho-block* and *full-block* parameterisations assemble a mesh (section 3)."""

import itertools

import numpy as np
from jaxtyping import Float

from trainer.geometry.topology import BaseMesh

# The share of a side that its chamfer takes at either end.
CHAMFER = 0.05
# Real root of x⁴ = x + 1: its inverse powers make the evenest sequence of points in a cube (Roberts' R₃).
_PLASTIC = 1.2207440846057596


def chamfered_cube(chamfer: float = CHAMFER) -> BaseMesh:
    """A cube of side 1 around the origin whose edges and corners are cut: 24 vertices, 44 faces, closed.

    Normals at vertices are then (almost) those of the sides. With only eight vertices they would point to the corners,
    and the block would be shaded like a ball; with sides that share no vertex, every edge would be a contour twice.
    """
    corners = list(itertools.product((-1, 1), repeat=3))
    # Vertex (corner, axis): the one at a corner that lies on the side across that axis.
    vertices = np.array(
        [
            [0.5 * sign if k == axis else (0.5 - chamfer) * sign for k, sign in enumerate(corner)]
            for corner in corners
            for axis in range(3)
        ]
    )
    number = {(corner, axis): 3 * index + axis for index, corner in enumerate(corners) for axis in range(3)}
    polygons = [[number[corner, axis] for axis in range(3)] for corner in corners]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        # Around the axis, one corner after the other.
        around = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        for side in (-1, 1):
            polygons.append([number[_corner(axis, side, u, a, v, b), axis] for a, b in around])
        for a, b in around:
            low, high = (_corner(axis, side, u, a, v, b) for side in (-1, 1))
            polygons.append([number[low, u], number[high, u], number[high, v], number[low, v]])
    faces = []
    for polygon in polygons:
        first, second, third = vertices[polygon[:3]]
        inward = np.dot(np.cross(second - first, third - first), vertices[polygon].mean(0)) < 0
        ring = polygon[::-1] if inward else polygon
        faces += [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
    return BaseMesh(vertices, np.array(faces, np.int64))


def _corner(axis: int, side: int, u: int, a: int, v: int, b: int) -> tuple[int, int, int]:
    signs = {axis: side, u: a, v: b}
    return signs[0], signs[1], signs[2]


def loose_cluster(count: int, side: float) -> tuple[Float[np.ndarray, "K 3"], float]:
    """(centres, side of a block): cubes that fill about the same space as one cube of a given side.

    No two centres agree in any coordinate: blocks that start in one place would be moved alike for ever.
    """
    block = side / count ** (1 / 3) * 1.2
    steps = np.arange(1, count + 1)[:, None] / _PLASTIC ** np.arange(1, 4)
    return (np.mod(0.5 + steps, 1.0) - 0.5) * (side - 0.5 * block), block
