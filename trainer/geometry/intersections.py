"""Where a mesh passes through itself."""

import numpy as np
from jaxtyping import Bool, Float64, Int64
from numpy import ndarray

# Pairs of a face and an edge that are looked at together; about 200 bytes each.
_MOST_PAIRS = 1 << 20


def crossed_faces(vertices: Float64[ndarray, "V 3"], faces: Int64[ndarray, "F 3"]) -> Bool[ndarray, "F"]:
    """Which faces an edge of the mesh passes through. Edges that end at one of a face's own corners, that lie in its
    plane or only touch its border do not count."""
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), 1), axis=0)
    crossed = np.zeros(len(faces), bool)
    size = max(1, _MOST_PAIRS // max(1, len(edges)))
    for start in range(0, len(faces), size):
        crossed[start : start + size] = _crossed(vertices, faces[start : start + size], edges)
    return crossed


def _crossed(
    vertices: Float64[ndarray, "V 3"], faces: Int64[ndarray, "F 3"], edges: Int64[ndarray, "E 2"]
) -> Bool[ndarray, "F"]:
    """The test of Möller and Trumbore ("Fast, minimum storage ray/triangle intersection", 1997) for all pairs."""
    corner, along, beside = (vertices[faces[:, k]] for k in range(3))
    along, beside = along - corner, beside - corner
    start, towards = vertices[edges[:, 0]], vertices[edges[:, 1]] - vertices[edges[:, 0]]
    across = np.cross(towards[None], beside[:, None])
    determinant = (across * along[:, None]).sum(-1)
    away = start[None] - corner[:, None]
    turned = np.cross(away, along[:, None])
    # An edge along the face's plane divides by 0, and compares false.
    with np.errstate(all="ignore"):
        u = (across * away).sum(-1) / determinant
        v = (turned * towards[None]).sum(-1) / determinant
        t = (turned * beside[:, None]).sum(-1) / determinant
        inside = (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
    own = (faces[:, None, :, None] == edges[None, :, None, :]).any((2, 3))
    crossed: Bool[ndarray, " F"] = (inside & ~own).any(1)
    return crossed
