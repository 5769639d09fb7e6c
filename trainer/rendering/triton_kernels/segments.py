"""The stretches of line along which what is seen may change abruptly, mesh after mesh in one list."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int32
from torch import Tensor

from trainer.rendering.triton_kernels.crossings import Crossings
from trainer.rendering.triton_kernels.geometry import Geometry, Records, side_of
from trainer.rendering.triton_kernels.mesh import Mesh


class Segments(NamedTuple):
    """Those of mesh n are numbers offsets[n] to offsets[n + 1]; what follows the last mesh's is unused.

    Lines are numbered through all meshes: E edges for each mesh in turn, then the crossings.
    """

    offsets: Int32[Tensor, "N+1"]
    mesh: Int32[Tensor, "S"]
    line: Int32[Tensor, "S"]
    ends: Float[Tensor, "S 4"]
    """x and y of the start, then of the end."""
    ended_by: Int32[Tensor, "S 2"]
    """The line that ends it there; -1 - 3v for vertex v."""
    faces: Int32[Tensor, "S 2"]
    """Whose border this is; the same face twice where there is one alone."""


def segments_of(geometry: Geometry, records: Records, crossings: Crossings, mesh: Mesh, crease: float) -> Segments:
    """Contours and creases, then crossings, of each mesh in turn; no list's length has to be known on the host."""
    screen, (meshes, edges) = geometry.screen, geometry.lines.shape[:2]
    active = torch.cat((_sharp_edges(geometry, records, mesh, crease).flatten(), crossings.long))
    edge_mesh = torch.arange(meshes, device=screen.device, dtype=torch.int32).repeat_interleave(edges)
    owner = torch.cat((edge_mesh, crossings.mesh))
    order = torch.where(active, owner, meshes).argsort(stable=True)
    ends = torch.cat((screen[:, mesh.edges, :2].reshape(-1, 4), crossings.ends))
    vertices = (-1 - 3 * mesh.edges).repeat(meshes, 1)
    ended_by = torch.cat((vertices, crossings.mesh[:, None] * edges + crossings.ended_by))
    faces = torch.cat((_drawn_faces(records, mesh).flatten(0, 1), crossings.faces))
    counts = torch.zeros(meshes + 1, dtype=torch.int32, device=screen.device)
    counts.index_add_(0, owner + 1, active.int())
    return Segments(counts.cumsum(0).int(), owner[order], order.int(), ends[order], ended_by[order], faces[order])


def _drawn_faces(records: Records, mesh: Mesh) -> Int32[Tensor, "N E 2"]:
    """The faces at each edge; one that has no area gives way to the other."""
    both = mesh.edge_faces.expand(len(records.drawn), -1, -1)
    return torch.where(records.drawn[:, mesh.edge_faces], both, both.flip(-1))


def _sharp_edges(geometry: Geometry, records: Records, mesh: Mesh, crease: float) -> Bool[Tensor, "N E"]:
    """Contours, whose faces all lie on one side of them on the screen, and creases, where colours bend sharply."""
    x, y = geometry.screen[:, mesh.edge_opposite, 0], geometry.screen[:, mesh.edge_opposite, 1]
    sides = side_of(geometry.lines[:, :, None], x, y)
    drawn = records.drawn[:, mesh.edge_faces]
    one_side = (sides[..., 0] == sides[..., 1]) | (drawn[..., 0] != drawn[..., 1])
    channels = geometry.planes.shape[2] // 2
    slopes = geometry.planes[:, :, 1 + channels :, 1:]
    bend = slopes[:, mesh.edge_faces[:, 0]] - slopes[:, mesh.edge_faces[:, 1]]
    bent = bend.square().sum(-1).sqrt().amax(-1) >= crease
    return drawn.any(-1) & (one_side | bent)
