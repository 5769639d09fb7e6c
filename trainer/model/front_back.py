"""How unlike the front and the back of displaced meshes are."""

from typing import NamedTuple

import torch
from jaxtyping import Float, Int64
from torch import Tensor

from trainer.model.mirror import tied_points

# Diagonals of the object; less than a pixel of the paper's pictures shows.
LIKE_ENOUGH = 0.01


class Sides(NamedTuple):
    """Of each vertex of a mesh the one across the middle, front to back, whose mirror image it is."""

    source: Int64[Tensor, "V"]
    sign: Float[Tensor, "V 3"]
    """What that one's coordinates are multiplied with."""


def sides_of(base_vertices: Float[Tensor, "V 3"]) -> Sides:
    """Those of a base mesh that is its own mirror image in z = 0."""
    ties = tied_points(base_vertices.cpu().numpy(), axes=[2])
    return Sides(torch.as_tensor(ties.source, device=base_vertices.device), base_vertices.new_tensor(ties.sign))


def unlikeness(vertices: Float[Tensor, "B V 3"], sides: Sides, knee: float = 0.0) -> Float[Tensor, "B"]:
    """How far vertices lie from the mirror images of those across the middle (object frame, a diagonal of the object is
    1), summed over the vertices of each shape.

    Distances, not their squares: a handle on one side costs no more than as much unlikeness that is spread over all,
    so that shapes are the same from front and back but where pictures show that they are not. Those of less than
    `LIKE_ENOUGH` are told less and less. A sum d counts as knee · log(1 + d / knee), so that a shape that is unlike as
    a whole is hardly drawn to be alike any more; with a `knee` of 0, as d.
    """
    beside = vertices - sides.sign * vertices[:, sides.source]
    distance = (beside.square().sum(2) + LIKE_ENOUGH**2).sqrt() - LIKE_ENOUGH
    total: Tensor = distance.sum(1)
    return knee * (total / knee).log1p() if knee else total
