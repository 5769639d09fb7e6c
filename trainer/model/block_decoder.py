"""F_φ(z) and M(Π) of the block parameterisations: a shape code becomes cuboids, and these one mesh (section 3)."""

import math
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from trainer.geometry.blocks import chamfered_cube, loose_cluster
from trainer.geometry.conventions import euler_rotation
from trainer.geometry.normals import vertex_normals
from trainer.model.decoder import DISPLACEMENT_UNIT, INITIAL_SPREAD, Part
from trainer.model.mirror import Kind, mirrored_copies, reflected, tie, tied

# A block without extent has no normals.
SMALLEST_SIDE = 1e-3
# softplus of this is 1: a block then has its initial size.
_UNIT_SCALE = math.log(math.e - 1)


class BlockDecoder(nn.Module):
    """z → 32 → location, scale and, if `turning`, three Euler angles of each block.

    Scales are a softplus, so that they are positive, and no side is shorter than SMALLEST_SIDE, in diagonals of the
    object; the other parameters are free. Starts at (almost) a loose cluster
    of upright cubes. Each block has 24 vertices and 44 faces of its own, and blocks may overlap. Every shape is its own
    mirror image in the planes across the axes `mirrored`, as blocks are images of one another (`mirrored_copies`).
    """

    base_vertices: Tensor
    faces: Tensor
    corners: Tensor
    locations: Tensor

    def __init__(
        self, latent: int, hidden: int, blocks: int, side: float, turning: bool, mirrored: Sequence[int] = ()
    ) -> None:
        super().__init__()
        block = chamfered_cube()
        centres, self.block_side = loose_cluster(blocks, side)
        mirrors = mirrored_copies(blocks, mirrored)
        centres = reflected(centres, mirrors)
        self.register_buffer("corners", torch.as_tensor(block.vertices, dtype=torch.float32))
        self.register_buffer("locations", torch.as_tensor(centres, dtype=torch.float32))
        self.register_buffer(
            "base_vertices", (self.locations[:, None] + self.block_side * self.corners).flatten(0, 1).clone()
        )
        first_vertex = torch.arange(blocks)[:, None, None] * len(block.vertices)
        self.register_buffer("faces", (first_vertex + torch.as_tensor(block.faces)).flatten(0, 1))
        self.parts = tuple(Part(f"block-{k + 1}", k * len(block.faces), len(block.faces)) for k in range(blocks))
        self.hidden = nn.Sequential(nn.Linear(latent, hidden), nn.ReLU())
        self.offsets, self.scales = nn.Linear(hidden, 3 * blocks), nn.Linear(hidden, 3 * blocks)
        self.angles = nn.Linear(hidden, 3 * blocks) if turning else None
        layers: tuple[tuple[nn.Linear | None, Kind], ...] = (
            (self.offsets, "coordinates"),
            (self.scales, "scales"),
            (self.angles, "rotations"),
        )
        for layer, kind in layers:
            if layer is not None:
                nn.init.normal_(layer.weight, std=INITIAL_SPREAD)
                nn.init.zeros_(layer.bias)
                if mirrored:
                    tie(layer, tied(mirrors, kind))

    def forward(self, shape_code: Float[Tensor, "B Z"]) -> Float[Tensor, "B V 3"]:
        """Vertices in the object frame, block by block."""
        hidden = self.hidden(shape_code)
        locations = self.locations + DISPLACEMENT_UNIT * self.offsets(hidden).unflatten(1, (-1, 3))
        placed: Tensor = (self._turned(self._upright(hidden), hidden) + locations[:, :, None]).flatten(1, 2)
        return placed

    def normals(self, shape_code: Float[Tensor, "B Z"]) -> Float[Tensor, "B V 3"]:
        """`vertex_normals` of those vertices, found on the upright blocks around the origin: of a block as thin as
        paper, rounding would else decide."""
        hidden = self.hidden(shape_code)
        upright = vertex_normals(self._upright(hidden).flatten(1, 2), self.faces)
        return self._turned(upright.unflatten(1, (-1, len(self.corners))), hidden).flatten(1, 2)

    def _upright(self, hidden: Float[Tensor, "B H"]) -> Float[Tensor, "B K C 3"]:
        scales = functional.softplus(self.scales(hidden).unflatten(1, (-1, 3)) + _UNIT_SCALE)
        return self.corners * (SMALLEST_SIDE + (self.block_side - SMALLEST_SIDE) * scales)[:, :, None]

    def _turned(self, vectors: Float[Tensor, "B K C 3"], hidden: Float[Tensor, "B H"]) -> Float[Tensor, "B K C 3"]:
        if self.angles is None:
            return vectors
        return vectors @ euler_rotation(self.angles(hidden).unflatten(1, (-1, 3))).transpose(-1, -2)
