"""Normals of a solid's corners: smooth across shallow edges, hard across sharp ones."""

import math

import numpy as np
from jaxtyping import Float64
from numba import njit
from numpy import ndarray

from trainer.data.shapes.solid import Mesh

CREASE_DEGREES = 35.0
"""Faces that meet at a smaller angle than this are shaded as one smooth surface."""


def corner_normals(mesh: Mesh, crease_degrees: float = CREASE_DEGREES) -> Float64[ndarray, "F 3 3"]:
    """Unit normals [F, corner, xyz], in the frame of the mesh.

    The normal at a corner of a face is the mean of the normals of all faces at that vertex that turn away from the
    face by less than `crease_degrees`, each weighted by its angle there, so that it does not depend on how flat
    regions are cut into triangles. Faces without area get the normal (0, 1, 0).
    """
    points = mesh.vertices[mesh.faces]
    edges = np.roll(points, -1, axis=1) - points
    normals = np.cross(edges[:, 0], edges[:, 1])
    length = np.linalg.norm(normals, axis=1)
    flat = length < 1e-14
    normals = np.where(flat[:, None], (0.0, 1.0, 0.0), normals / np.where(flat, 1.0, length)[:, None])
    weights = np.where(flat[:, None], 0.0, _corner_angles(edges, length))

    vertex = mesh.faces.reshape(-1)
    by_vertex = np.argsort(vertex, kind="stable")
    ends = np.cumsum(np.bincount(vertex))
    means: Float64[ndarray, "F 3 3"] = _mean_normals(
        normals, weights, by_vertex, ends, math.cos(math.radians(crease_degrees))
    )
    return means


def _corner_angles(edges: Float64[ndarray, "F 3 3"], double_area: Float64[ndarray, "F"]) -> Float64[ndarray, "F 3"]:
    """The angle of each face at each of its corners, radians; `edges` leave from the corners in turn."""
    back = -np.roll(edges, 1, axis=1)
    # The cross product of two sides is twice the area at each of the three corners.
    angles: Float64[ndarray, "F 3"] = np.arctan2(double_area[:, None], (edges * back).sum(-1))
    return angles


@njit(nogil=True, cache=True)
def _mean_normals(normals, weights, by_vertex, ends, cosine):
    means = np.empty((len(normals), 3, 3))
    start = 0
    for end in ends:
        for here in by_vertex[start:end]:
            face, corner = here // 3, here % 3
            x, y, z = normals[face]
            total_x, total_y, total_z = 0.0, 0.0, 0.0
            for there in by_vertex[start:end]:
                other = there // 3
                other_x, other_y, other_z = normals[other]
                if other == face or x * other_x + y * other_y + z * other_z > cosine:
                    weight = weights[other, there % 3]
                    total_x += weight * other_x
                    total_y += weight * other_y
                    total_z += weight * other_z
            length = math.sqrt(total_x**2 + total_y**2 + total_z**2)
            if length > 1e-12:
                means[face, corner] = total_x / length, total_y / length, total_z / length
            else:
                means[face, corner] = x, y, z
        start = end
    return means
