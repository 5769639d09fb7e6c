"""Shapes on loan between pictures of like objects, seen from other sides.

A shape that has only to explain its own picture may be anything on the sides that this does not show. So, once poses
are known, each picture is also explained by the shape of another one: of that whose code is nearest among those that
were seen from a direction drawn at random. "Neighbour reconstruction" of Monnier et al., *Share With Thy Neighbors*
(ECCV 2022). The paper has no such term.
"""

import math
from typing import Final

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn

from trainer import processes
from trainer.config import Symmetry
from trainer.geometry.conventions import wrap_angle

# Pictures that are remembered: about all of a small folder.
REMEMBERED: Final = 3840
# A neighbour is seen from a direction that differs by so much at least: what it sees, the picture does not.
APART: Final = math.radians(30)
# It is seen from the direction that was drawn, to so much.
NEAR: Final = math.radians(15)


class Memory(nn.Module):
    """Codes and azimuths of the pictures of the last minibatches, as they were encoded then; the latest come last."""

    codes: Float[Tensor, "M Z"]
    azimuths: Float[Tensor, "M"]
    """Radians; NaN where there has been no picture yet."""

    def __init__(self, latent: int) -> None:
        super().__init__()
        self.register_buffer("codes", torch.zeros(REMEMBERED, latent))
        self.register_buffer("azimuths", torch.full((REMEMBERED,), math.nan))

    def remember(self, codes: Float[Tensor, "B Z"], azimuths: Float[Tensor, "B"]) -> None:
        """Of this process; those of all are remembered by each. In the same memory, as recorded steps know it."""
        for kept, new in ((self.codes, codes), (self.azimuths, azimuths)):
            latest = processes.whole(new.detach())[-REMEMBERED:]
            kept.copy_(torch.cat([kept[len(latest) :], latest]))


def lent_codes(
    memory: Memory,
    codes: Float[Tensor, "B Z"],
    azimuths: Float[Tensor, "B"],
    directions: Float[Tensor, "B"],
    symmetry: Symmetry,
) -> Float[Tensor, "B Z"]:
    """The code of each picture's neighbour, without gradient; its own where there is none.

    `directions` are the azimuths to be seen from, radians. A shape that is its own mirror image shows the same from
    either side, so then a neighbour's azimuth may have either sign; and with two mirrors, be turned by half a turn.
    """
    with torch.no_grad():
        apart = _between(azimuths, memory.azimuths, symmetry) >= APART
        near = _between(directions, memory.azimuths, symmetry) <= NEAR
        eligible: Bool[Tensor, "B M"] = apart & near
        distance, nearest = torch.cdist(codes, memory.codes).where(eligible, math.inf).min(1)
        return torch.where(distance.isfinite()[:, None], memory.codes[nearest], codes)


def _between(azimuths: Float[Tensor, "B"], others: Float[Tensor, "M"], symmetry: Symmetry) -> Float[Tensor, "B M"]:
    """Angles from 0 to π between each two, or their likes; NaN where one is."""
    angle = wrap_angle(azimuths[:, None] - others).abs()
    if symmetry == "none":
        return angle
    other_side = wrap_angle(azimuths[:, None] + others).abs()
    if symmetry == "mirror":
        return torch.minimum(angle, other_side)
    return torch.stack([angle, other_side, math.pi - angle, math.pi - other_side]).amin(0)
