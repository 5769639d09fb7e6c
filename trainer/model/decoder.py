"""F_φ(z) of Appendix A and M(Π) of section 3: from a shape code to vertices."""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import BaseMesh
from trainer.model.mirror import tie, tied_points

# Displacements are learnt in this unit (a diagonal of the object is 1), so that weights are of ordinary size.
DISPLACEMENT_UNIT = 0.3
INITIAL_SPREAD = 0.01


class Part(NamedTuple):
    """A named piece of a mesh: consecutive faces."""

    name: str
    first_face: int
    face_count: int


class SubdivisionDecoder(nn.Module):
    """z → 32 → one displacement per vertex of a base mesh. Starts at (almost) that mesh itself. Every shape is its
    own mirror image in the planes across the axes `mirrored`: 0 is left to right, 2 front to back."""

    base_vertices: Tensor
    faces: Tensor

    def __init__(self, latent: int, hidden: int, base: BaseMesh, mirrored: Sequence[int] = ()) -> None:
        super().__init__()
        self.register_buffer("base_vertices", torch.as_tensor(base.vertices, dtype=torch.float32))
        self.register_buffer("faces", torch.as_tensor(base.faces))
        self.parts = (Part("body", 0, len(base.faces)),)
        self.hidden = nn.Sequential(nn.Linear(latent, hidden), nn.ReLU())
        self.displacements = nn.Linear(hidden, 3 * len(base.vertices))
        nn.init.normal_(self.displacements.weight, std=INITIAL_SPREAD)
        nn.init.zeros_(self.displacements.bias)
        if mirrored:
            tie(self.displacements, tied_points(base.vertices, mirrored))

    def forward(self, shape_code: Float[Tensor, "B Z"]) -> Float[Tensor, "B V 3"]:
        """Vertices in the object frame."""
        offsets = self.displacements(self.hidden(shape_code)).unflatten(1, (-1, 3))
        vertices: Tensor = self.base_vertices + DISPLACEMENT_UNIT * offsets
        return vertices

    def normals(self, shape_code: Float[Tensor, "B Z"]) -> Float[Tensor, "B V 3"]:
        """`vertex_normals` of those vertices."""
        return vertex_normals(self(shape_code), self.faces)
