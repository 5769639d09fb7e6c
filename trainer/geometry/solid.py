"""The solid inside the cube's surface, and how much of it a displaced surface turns inside out.

Where the hidden side of a wing passes through the seen one, pictures hardly change, and its curvature does not: what
is thin comes out as sheets that cross. The lattice inside the cube tells: each of its tetrahedra has a volume, which is
negative where the solid is inside out. Its inner points may lie anywhere, or where the surface carries them.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int64
from torch import Tensor

from trainer.geometry.topology import subdivided_cube

# A cell's corner of even parity is cut off by each of four tetrahedra, and the fifth is what is left.
_CELL = np.array(
    [
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(1, 1, 0), (0, 1, 0), (1, 0, 0), (1, 1, 1)],
        [(1, 0, 1), (1, 0, 0), (0, 0, 1), (1, 1, 1)],
        [(0, 1, 1), (0, 0, 1), (0, 1, 0), (1, 1, 1)],
        [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)],
    ]
)


class Solid(NamedTuple):
    """What fills `topology.subdivided_cube`. Points are its vertices, and after them those of the lattice inside."""

    inner: Float[np.ndarray, "I V"]
    """Where the surface carries each inner point, as a mean of vertices: the harmonic one, so that it lies in the
    middle of its six neighbours."""
    tetrahedra: Int64[np.ndarray, "T 4"]
    """Points; of positive volume in the cube."""


def cube_solid(segments: int, proportions: tuple[int, int, int] = (1, 1, 1)) -> Solid:
    """The lattice of (segments + 1)³ points, whose surface is that of `subdivided_cube(segments)`, in 5·segments³
    tetrahedra, or of as many more as the `proportions` say; its own mirror image in x, y and z where edges are cut into
    even numbers."""
    counts = segments * np.array(proportions)
    surface = np.rint((subdivided_cube(segments, 1, proportions).vertices + 0.5) * counts).astype(int)
    number = np.full(counts + 1, -1)
    number[tuple(surface.T)] = np.arange(len(surface))
    inside = np.argwhere(number < 0)
    number[tuple(inside.T)] = len(surface) + np.arange(len(inside))

    pull = np.zeros((len(inside), number.size))
    steps = np.concatenate((np.eye(3, dtype=int), -np.eye(3, dtype=int)))
    for row, point in enumerate(inside):
        pull[row, number[tuple((point + steps).T)]] = -1
        pull[row, number[tuple(point)]] = 6
    inner = np.linalg.solve(pull[:, len(surface) :], -pull[:, : len(surface)])

    cells = np.argwhere(np.ones(counts, bool))
    odd = cells.sum(1) % 2
    corners = np.repeat(_CELL[None], len(cells), 0)
    corners[..., 0] ^= odd[:, None, None]
    # A mirrored tetrahedron is turned over.
    corners[odd == 1] = corners[odd == 1][:, :, [0, 2, 1, 3]]
    points = cells[:, None, None] + corners
    return Solid(inner, number[tuple(np.moveaxis(points, -1, 0))].reshape(-1, 4))


def inverted_volume(
    points: Float[Tensor, "B P 3"], tetrahedra: Int64[Tensor, "T 4"], margin: float = 0
) -> Float[Tensor, "B"]:
    """The volume of a solid's tetrahedra that are inside out, in units of its points'; with a `margin`, also what each
    lacks of that share of its shape's mean."""
    # Shapes last: whole rows are gathered then, in half of the time.
    rows = points.permute(1, 2, 0).flatten(1)
    origin, *others = (rows.index_select(0, corner).unflatten(1, (3, -1)) for corner in tetrahedra.unbind(1))
    one, two, three = (other - origin for other in others)
    volumes: Tensor = (one.cross(two, dim=1) * three).sum(1) / 6
    least = margin * volumes.detach().mean(0).clamp(min=0)
    return (least - volumes).clamp(min=0).sum(0)
