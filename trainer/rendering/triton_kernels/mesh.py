"""A topology in a device's memory, in the form that kernels read."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Int32
from torch import Tensor

from rasteriser.topology import Topology


class Mesh(NamedTuple):
    """What all meshes of a batch share."""

    faces: Int32[Tensor, "F 3"]
    edges: Int32[Tensor, "E 2"]
    edge_faces: Int32[Tensor, "E 2"]
    """Where there is one face alone, it stands twice."""
    edge_opposite: Int32[Tensor, "E 2"]
    """The corner opposite an edge in each of those faces."""
    face_edges: Int32[Tensor, "F 3"]


def mesh_on(topology: Topology, device: torch.device) -> Mesh:
    """Copies a topology to a device, once for each: the same arrays give the same tensors again."""
    shape = len(topology.faces), len(topology.edges)
    return _mesh_on(*(np.ascontiguousarray(part, np.int32).tobytes() for part in topology), shape, device)


@lru_cache(maxsize=16)
def _mesh_on(
    faces: bytes, edges: bytes, edge_faces: bytes, face_edges: bytes, shape: tuple[int, int], device: torch.device
) -> Mesh:
    corners, sides = (np.frombuffer(part, np.int32).reshape(shape[0], 3) for part in (faces, face_edges))
    ends, beside = (np.frombuffer(part, np.int32).reshape(shape[1], 2) for part in (edges, edge_faces))
    beside = np.where(beside < 0, beside[:, :1], beside)
    across = (sides[beside] == np.arange(shape[1])[:, None, None]).argmax(2)
    opposite = np.take_along_axis(corners[beside], across[..., None], 2)[..., 0]
    return Mesh(*(torch.tensor(part, device=device) for part in (corners, ends, beside, opposite, sides)))
