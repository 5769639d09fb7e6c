"""What a rasteriser must know of a mesh beside its vertices: which edges it has, and which faces meet there."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

IntArray = npt.NDArray[np.int32]


class Topology(NamedTuple):
    """Faces and edges of a mesh, as int32 arrays."""

    faces: IntArray
    """[F, 3] vertex indices."""
    edges: IntArray
    """[E, 2] vertex indices, the smaller first."""
    edge_faces: IntArray
    """[E, 2] the faces that meet at an edge; -1 where there is only one."""
    face_edges: IntArray
    """[F, 3] the edge opposite each corner: corner 0's lies between corners 1 and 2."""


def build_topology(faces: npt.NDArray[np.integer]) -> Topology:
    """Edges of a mesh. An edge where three or more faces meet becomes one boundary edge for each of them.

    Raises:
        ValueError: `faces` is not an integer array [F, 3].
    """
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
        raise ValueError(f"expected faces as an integer array [F, 3], found {faces.dtype} {list(faces.shape)}")
    count = len(faces)
    opposite = np.sort(np.stack((faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]), 1).reshape(-1, 2), axis=1)
    # As one number each, edges are found several times as fast as in pairs, in the same order.
    vertices = int(faces.max(initial=0)) + 1
    numbers, edge_of_side, uses = np.unique(
        opposite.astype(np.int64) @ (vertices, 1), return_inverse=True, return_counts=True
    )
    edges = np.stack(np.divmod(numbers, vertices), 1)
    crowded = np.flatnonzero(uses[edge_of_side] > 2)
    if len(crowded):
        edges = np.concatenate((edges, opposite[crowded]))
        edge_of_side[crowded] = np.arange(len(edges) - len(crowded), len(edges))
    edge_faces = np.full((len(edges), 2), -1, dtype=np.int32)
    order = np.argsort(edge_of_side, kind="stable")
    second = np.concatenate(([False], edge_of_side[order][1:] == edge_of_side[order][:-1]))[: len(order)]
    edge_faces[edge_of_side[order], second.astype(int)] = order // 3
    kept = edge_faces[:, 0] >= 0
    renumbered = np.cumsum(kept) - 1
    return Topology(
        faces.astype(np.int32),
        edges[kept].astype(np.int32),
        edge_faces[kept],
        renumbered[edge_of_side].reshape(count, 3).astype(np.int32),
    )
