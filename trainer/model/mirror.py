"""Linear layers whose outputs are mirrored in x = 0: half of them are learnt, the others are theirs, with a sign.

A reflection in x turns the sign of x coordinates, and of rotations about y and z; of coordinates, scales and rotations
nothing else changes. Points may be mirrored in z = 0 as well: then a quarter is learnt. A shape that is its own mirror
image is so a matter of which rows of the decoder's last layers are tied; what computes with their outputs does not
know.
"""

from collections.abc import Sequence
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


class Ties(NamedTuple):
    """What each of N things has in place of three numbers of its own."""

    source: Int64[np.ndarray, "N"]
    """The thing that is learnt: a thing itself, or the one whose image it is."""
    sign: Float[np.ndarray, "N 3"]
    """What that one's numbers are multiplied with; 0 for those that the mirror it lies in does not leave free."""


class Mirror(NamedTuple):
    """Which of N things is whose mirror image."""

    source: Int64[np.ndarray, "N"]
    """The thing that is learnt: a thing itself, or the one whose mirror image it is."""
    side: Int64[np.ndarray, "N"]
    """1 for those that are learnt; −1 for their mirror images; 0 for those in the mirror, their own images."""


def tied_points(points: Float[np.ndarray, "V 3"], axes: Sequence[int]) -> Ties:
    """The displacements of points that come as their own images in the planes across some axes, or lie in these; those
    on the positive side of each plane are learnt."""
    learnt, sign = points.copy(), np.ones_like(points)
    for axis in axes:
        learnt[:, axis] = np.abs(points[:, axis])
        sign[:, axis] = np.sign(points[:, axis].round(9))
    return Ties(np.abs(points[:, None] - learnt).sum(-1).argmin(0), sign)


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


def tied(mirror: Mirror, signs: Signs) -> Ties:
    """Three numbers for each thing that a mirror has."""
    return Ties(mirror.source, _signs(mirror, signs))


def tie(layer: nn.Linear, ties: Ties) -> None:
    """Makes a layer of three outputs for each thing learn only those that are free."""
    own = ties.source == np.arange(len(ties.source))
    free = np.flatnonzero(own[:, None] & (ties.sign != 0))
    place = np.zeros(ties.sign.size, np.int64)
    place[free] = np.arange(len(free))
    source = place[3 * ties.source[:, None] + np.arange(3)].ravel()
    for name in ("weight", "bias"):
        parametrize.register_parametrization(layer, name, _Tied(source, ties.sign.ravel(), free))


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
