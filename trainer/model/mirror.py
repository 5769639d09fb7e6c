"""Linear layers whose outputs are mirrored in x = 0: half of them are learnt, the others are theirs, with a sign.

A reflection in x turns the sign of x coordinates, and of rotations about y and z; of coordinates, scales and rotations
nothing else changes. All may be mirrored in z = 0 as well: then a quarter is learnt. A shape that is its own mirror
image is so a matter of which rows of the decoder's last layers are tied; what computes with their outputs does not
know.
"""

from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor, nn
from torch.nn.utils import parametrize

Kind = Literal["coordinates", "scales", "rotations"]
"""What three numbers of a thing are; rotations are angles as `euler_rotation` has them."""
ROTATION_AXES: Final = (1, 0, 2)
"""What the three angles turn about: y, x, z."""


class Ties(NamedTuple):
    """What each of N things has in place of three numbers of its own."""

    source: Int64[np.ndarray, "N"]
    """The thing that is learnt: a thing itself, or the one whose image it is."""
    sign: Float[np.ndarray, "N 3"]
    """What that one's numbers are multiplied with; 0 for those that the mirror it lies in does not leave free."""


class Mirrors(NamedTuple):
    """Which of N things is whose mirror image, in the planes across some axes."""

    source: Int64[np.ndarray, "N"]
    """The thing that is learnt: a thing itself, or the one whose image it is."""
    side: Int64[np.ndarray, "N 3"]
    """Along each axis: −1 for images in the plane across it; 0 for those in that plane, their own images; else 1."""


def tied_points(points: Float[np.ndarray, "V 3"], axes: Sequence[int]) -> Ties:
    """The displacements of points that come as their own images in the planes across some axes, or lie in these; those
    on the positive side of each plane are learnt."""
    learnt, sign = points.copy(), np.ones_like(points)
    for axis in axes:
        learnt[:, axis] = np.abs(points[:, axis])
        sign[:, axis] = np.sign(points[:, axis].round(9))
    return Ties(np.abs(points[:, None] - learnt).sum(-1).argmin(0), sign)


def mirrored_copies(count: int, axes: Sequence[int]) -> Mirrors:
    """The mirrors of a number of things that come in pairs, or of two axes in fours: first those that are learnt, then
    their images. What remains lies in the plane across the last axis, and is mirrored in the other; the last of an odd
    number lies in all of them."""
    copies = 2 ** len(axes)
    learnt = count // copies
    source, side = np.arange(count), np.ones((count, 3), np.int64)
    for copy in range(1, copies):
        images = slice(copy * learnt, (copy + 1) * learnt)
        source[images] = source[:learnt]
        side[images, [axis for place, axis in enumerate(axes) if copy >> place & 1]] = -1
    if rest := count - copies * learnt:
        within = mirrored_copies(rest, axes[:-1])
        source[-rest:], side[-rest:] = count - rest + within.source, within.side
        side[-rest:, axes[-1]] = 0
    return Mirrors(source, side)


def reflected(points: Float[np.ndarray, "N 3"], mirrors: Mirrors) -> Float[np.ndarray, "N 3"]:
    """A point for each thing, of which those of the learnt ones decide."""
    images: Float[np.ndarray, "N 3"] = points[mirrors.source] * _signs(mirrors, "coordinates")
    return images


def tied(mirrors: Mirrors, kind: Kind) -> Ties:
    """Three numbers of a kind for each thing that mirrors have."""
    return Ties(mirrors.source, _signs(mirrors, kind))


def tie(layer: nn.Linear, ties: Ties) -> None:
    """Makes a layer of three outputs for each thing learn only those that are free."""
    own = ties.source == np.arange(len(ties.source))
    free = np.flatnonzero(own[:, None] & (ties.sign != 0))
    place = np.zeros(ties.sign.size, np.int64)
    place[free] = np.arange(len(free))
    source = place[3 * ties.source[:, None] + np.arange(3)].ravel()
    for name in ("weight", "bias"):
        parametrize.register_parametrization(layer, name, _Tied(source, ties.sign.ravel(), free))


def _signs(mirrors: Mirrors, kind: Kind) -> Float[np.ndarray, "N 3"]:
    """What each thing's source is multiplied with. In a mirror, what a reflection turns round is 0."""
    signs = np.ones(mirrors.side.shape)
    for axis in range(3):
        signs[:, _turned_round(kind, axis)] *= mirrors.side[:, axis, None]
    return signs


def _turned_round(kind: Kind, axis: int) -> list[int]:
    """Which of three numbers a reflection across an axis makes negative."""
    match kind:
        case "coordinates":
            return [axis]
        case "scales":
            return []
        case "rotations":
            return [number for number, about in enumerate(ROTATION_AXES) if about != axis]


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
