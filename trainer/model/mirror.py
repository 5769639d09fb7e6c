"""Linear layers whose outputs are mirrored in x = 0: half of them are learnt, the others are theirs, with a sign.

A reflection in x turns the sign of x coordinates, and of rotations about y and z; of coordinates, scales and rotations
nothing else changes. A shape that is its own mirror image is so a matter of which rows of the decoder's last layers are
tied; what computes with their outputs does not know.
"""

from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor, nn
from torch.nn.utils import parametrize

Signs = tuple[float, float, float]

# What a reflection in x makes of three numbers; of angles as `euler_rotation` has them.
COORDINATES: Signs = (-1.0, 1.0, 1.0)
SCALES: Signs = (1.0, 1.0, 1.0)
ROTATIONS: Signs = (-1.0, 1.0, -1.0)


class Mirror(NamedTuple):
    """Which of N things is whose mirror image."""

    source: Int64[np.ndarray, "N"]
    """The thing that is learnt: a thing itself, or the one whose mirror image it is."""
    side: Int64[np.ndarray, "N"]
    """1 for those that are learnt; −1 for their mirror images; 0 for those in the mirror, their own images."""


def mirrored_points(points: Float[np.ndarray, "V 3"]) -> Mirror:
    """The mirror of points that come in pairs, or lie in x = 0; those of positive x are learnt."""
    images = points * COORDINATES
    other = np.abs(points[:, None] - images).sum(-1).argmin(0)
    number = np.arange(len(points))
    side = np.where(other == number, 0, np.where(points[:, 0] > 0, 1, -1))
    return Mirror(np.where(side < 0, other, number), side)


def mirrored_pairs(count: int) -> Mirror:
    """The mirror of a number of things of which the second half are the images of the first; the last of an odd number
    lies in it."""
    half = count // 2
    number = np.arange(count)
    side = np.where(number < half, 1, np.where(number < 2 * half, -1, 0))
    return Mirror(np.where(side < 0, number - half, number), side)


def reflected(values: Float[np.ndarray, "N 3"], mirror: Mirror, signs: Signs) -> Float[np.ndarray, "N 3"]:
    """Three values for each thing, of which the learnt ones decide."""
    images: Float[np.ndarray, "N 3"] = values[mirror.source] * _signs(mirror, signs)
    return images


def tie(layer: nn.Linear, mirror: Mirror, signs: Signs) -> None:
    """Makes a layer of three outputs for each thing learn only those that are free."""
    sign = _signs(mirror, signs)
    free = np.flatnonzero((mirror.side[:, None] >= 0) & (sign != 0))
    place = np.zeros(sign.size, np.int64)
    place[free] = np.arange(len(free))
    source = place[3 * mirror.source[:, None] + np.arange(3)].ravel()
    for name in ("weight", "bias"):
        parametrize.register_parametrization(layer, name, _Tied(source, sign.ravel(), free))


def _signs(mirror: Mirror, signs: Signs) -> Float[np.ndarray, "N 3"]:
    """What each thing's source is multiplied with. In the mirror, what a reflection turns round is 0."""
    side = mirror.side[:, None]
    return np.where(side > 0, 1.0, np.where(side < 0, signs, np.maximum(signs, 0.0)))


class _Tied(nn.Module):
    """From the rows that are learnt to all rows."""

    source: Tensor
    sign: Tensor
    free: Tensor

    def __init__(
        self, source: Int64[np.ndarray, "R"], sign: Float[np.ndarray, "R"], free: Int64[np.ndarray, "F"]
    ) -> None:
        super().__init__()
        self.register_buffer("source", torch.as_tensor(source), persistent=False)
        self.register_buffer("sign", torch.as_tensor(sign, dtype=torch.float32), persistent=False)
        self.register_buffer("free", torch.as_tensor(free), persistent=False)

    def forward(self, learnt: Float[Tensor, "F *I"]) -> Float[Tensor, "R *I"]:
        rows = learnt[self.source]
        return rows * self.sign.view(-1, *[1] * (rows.dim() - 1))

    def right_inverse(self, rows: Float[Tensor, "R *I"]) -> Float[Tensor, "F *I"]:
        return rows[self.free]
