"""Normals of a solid's corners: smooth across shallow edges, hard across sharp ones."""

import math

import numpy as np
from jaxtyping import Float64
from numpy import ndarray

from rasteriser.compilation import kernel
from trainer.data.shapes.solid import Mesh

CREASE_DEGREES = 35.0
"""Faces that meet at a smaller angle than this are shaded as one smooth surface."""

_MOST_COMPARED = 2000


def corner_normals(mesh: Mesh, crease_degrees: float = CREASE_DEGREES) -> Float64[ndarray, "F 3 3"]:
    """Unit normals [F, corner, xyz], in the frame of the mesh.

    The normal at a corner of a face is the mean of the normals of all faces at that vertex that turn away from the
    face by less than `crease_degrees`. Each counts by its area and its angle there, so that a large flat face stays
    flat beside its bevels. Which side of a face is outside does not matter, as it does not for the light; where
    neighbours disagree, each keeps its own. Faces without area get the normal (0, 1, 0), and where thousands meet at
    one vertex, each face has its own normal there.
    """
    ends = np.cumsum(np.bincount(mesh.faces.reshape(-1)))
    normals, weights = _face_normals(mesh.vertices, mesh.faces)
    means: Float64[ndarray, "F 3 3"] = _mean_normals(
        normals, weights, _corners_by_vertex(mesh.faces, ends), ends, math.cos(math.radians(crease_degrees))
    )
    return means


@kernel()
def _face_normals(vertices, faces):
    """The unit normal of each face, and what it counts at each corner; (0, 1, 0) and 0 where it has no area."""
    normals, weights = np.empty((len(faces), 3)), np.zeros((len(faces), 3))
    sides = np.empty((3, 3))
    for face in range(len(faces)):
        for corner in range(3):
            start, end = faces[face, corner], faces[face, (corner + 1) % 3]
            for axis in range(3):
                sides[corner, axis] = vertices[end, axis] - vertices[start, axis]
        x = sides[0, 1] * sides[1, 2] - sides[0, 2] * sides[1, 1]
        y = sides[0, 2] * sides[1, 0] - sides[0, 0] * sides[1, 2]
        z = sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]
        # The cross product of two sides is twice the area at each of the three corners.
        double_area = math.sqrt(x**2 + y**2 + z**2)
        if double_area < 1e-14:
            normals[face] = 0.0, 1.0, 0.0
            continue
        normals[face] = x / double_area, y / double_area, z / double_area
        # The angles at two corners: all three make half a turn.
        remaining = math.pi
        for corner in range(2):
            back = sides[(corner + 2) % 3]
            cosine = -sides[corner, 0] * back[0] - sides[corner, 1] * back[1] - sides[corner, 2] * back[2]
            angle = math.atan2(double_area, cosine)
            weights[face, corner] = double_area * angle
            remaining -= angle
        weights[face, 2] = double_area * remaining
    return normals, weights


@kernel()
def _corners_by_vertex(faces, ends):
    """The corners (3 · face + corner) of vertex 0, then those of vertex 1 … in order; those of v end at `ends[v]`."""
    ordered, following = np.empty(faces.size, np.int64), ends.copy()
    for corner in range(faces.size - 1, -1, -1):
        vertex = faces[corner // 3, corner % 3]
        following[vertex] -= 1
        ordered[following[vertex]] = corner
    return ordered


@kernel()
def _mean_normals(normals, weights, by_vertex, ends, cosine):
    means = np.empty((len(normals), 3, 3))
    # The normals of the faces at one vertex, and what they count there.
    around = np.empty((_MOST_COMPARED, 4))
    start = 0
    for end in ends:
        count = end - start
        if count > _MOST_COMPARED:
            # Every face there is compared with every other. With thousands at one point it is the hub of a wheel or a
            # spoilt file, and each face is as good by itself.
            for place in range(start, end):
                face, corner = by_vertex[place] // 3, by_vertex[place] % 3
                for axis in range(3):
                    means[face, corner, axis] = normals[face, axis]
            start = end
            continue
        for place in range(count):
            face, corner = by_vertex[start + place] // 3, by_vertex[start + place] % 3
            for axis in range(3):
                around[place, axis] = normals[face, axis]
            around[place, 3] = weights[face, corner]
        for here in range(count):
            face, corner = by_vertex[start + here] // 3, by_vertex[start + here] % 3
            x, y, z = around[here, 0], around[here, 1], around[here, 2]
            total_x, total_y, total_z = 0.0, 0.0, 0.0
            for there in range(count):
                alike = x * around[there, 0] + y * around[there, 1] + z * around[there, 2]
                if there == here or abs(alike) > cosine:
                    weight = math.copysign(around[there, 3], alike)
                    total_x += weight * around[there, 0]
                    total_y += weight * around[there, 1]
                    total_z += weight * around[there, 2]
            length = math.sqrt(total_x**2 + total_y**2 + total_z**2)
            if length > 1e-30:
                x, y, z = total_x / length, total_y / length, total_z / length
            means[face, corner, 0], means[face, corner, 1], means[face, corner, 2] = x, y, z
        start = end
    return means
