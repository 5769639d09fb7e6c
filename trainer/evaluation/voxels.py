"""Occupancy of closed, oriented meshes, such as the learnt ones, on a grid.

The grid spans the cube [-0.5, 0.5]³ of the object frame; the centre of voxel [i, j, k] is ((i, j, k) + 0.5) / R - 0.5
along x, y, z. Predictions (`occupy`) and truths (`trainer.evaluation.fill`, which takes any mesh) are held to one rule:

- A voxel is full where its centre is inside.
- That alone would lose what is thinner than a voxel wherever no centre happens to lie in it: a table's top, a chair's
  legs, a wing. So a thin part also fills the voxels that its middle passes through, and becomes a layer or a bar of one
  voxel's thickness.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int32, Integer, UInt8
from numpy import ndarray

from rasteriser.compilation import kernel
from trainer.evaluation.columns import crossings, first_centre

RESOLUTION = 32
"""Voxels along each side of the cube (paper: 32³, section 5.2)."""
FINENESS = 5
"""Fine voxels along each side of a voxel; odd, so that the one in the middle has the voxel's own centre."""


class Solid(NamedTuple):
    """What is found of an object in the cube [-0.5, 0.5]³; M = R · FINENESS."""

    full: Bool[ndarray, "R R R"]
    """Occupancy, as IoU counts it."""
    air: Bool[ndarray, "M M M"]
    """The fine voxels outside of the object; where the surface of an open part passes, neither air nor inside."""


def occupy(vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"], resolution: int = RESOLUTION) -> Solid:
    """The solid of closed, consistently oriented parts.

    Raises ValueError for coordinates that are not finite.
    """
    fine = voxelise(vertices, faces, resolution * FINENESS)
    return Solid(centres(fine) | thin_layers(fine), ~fine)


def centres(fine: Bool[ndarray, "M M M"]) -> Bool[ndarray, "R R R"]:
    """The fine voxel in the middle of each voxel."""
    middle = slice(FINENESS // 2, None, FINENESS)
    return fine[middle, middle, middle]


def thin_layers(fine: Bool[ndarray, "M M M"]) -> Bool[ndarray, "R R R"]:
    """The voxels that the middle of a thin part passes through.

    Lines through the fine voxels along the three axes cross the object in stretches. A voxel is one of these where it
    holds the middles of at least half as many stretches shorter than a voxel as lines pass one of its faces. A plate is
    short along one axis, and has to cover half of a face; a bar is short along two; and so its middle is found where
    it is hardly thicker than a fine voxel. The silhouettes of thick parts are short only in negligible strips.
    """
    size = len(fine) // FINENESS
    counts = np.zeros((size,) * 3, np.uint8)
    low, high = _bounds(fine)
    box = tuple(slice(first, last) for first, last in zip(low, high, strict=True))
    for axis in range(3):
        order = (axis + 1) % 3, (axis + 2) % 3, axis
        _count_middles(fine[box].transpose(order), low[list(order)], counts.transpose(order))
    return counts >= 0.5 * FINENESS**2


def _bounds(fine: Bool[ndarray, "M M M"]) -> tuple[Integer[ndarray, "3"], Integer[ndarray, "3"]]:
    """The box that holds all that is set, in whole voxels: [low, high)."""
    low, high = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for axis in range(3):
        there = np.flatnonzero(fine.any(((axis + 1) % 3, (axis + 2) % 3)))
        if len(there):
            low[axis], high[axis] = there[0], there[-1] + 1
    return low // FINENESS * FINENESS, -(-high // FINENESS) * FINENESS


@kernel()
def _count_middles(fine, low, counts):
    """Adds up, in each voxel, the middles of the stretches along the last axis that are shorter than a voxel."""
    for x in range(fine.shape[0]):
        for y in range(fine.shape[1]):
            column = counts[(low[0] + x) // FINENESS, (low[1] + y) // FINENESS]
            length = 0
            for z in range(fine.shape[2] + 1):
                if z < fine.shape[2] and fine[x, y, z]:
                    length += 1
                elif length:
                    if length < FINENESS:
                        column[(low[2] + z - (length + 2) // 2) // FINENESS] += 1
                    length = 0


def blocks(fine: Bool[ndarray, "M M M"]) -> UInt8[ndarray, "R R R"]:
    """How many fine voxels are set in each voxel."""
    counts: UInt8[ndarray, "R R R"] = fine.astype(np.uint8)
    for _ in range(3):
        # Slices are added many times as fast as the axes of a reshaped array are summed up.
        counts = sum((counts[start::FINENESS] for start in range(1, FINENESS)), counts[::FINENESS]).transpose(1, 2, 0)
    return counts


def voxelise(
    vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"], resolution: int = RESOLUTION
) -> Bool[ndarray, "R R R"]:
    """The voxels whose centres have a winding number other than zero.

    Right for closed surfaces, consistently oriented part by part, that may overlap and intersect themselves, whichever
    way they look. Exact also for centres in line with vertices and edges: each column meets every fold of a closed
    surface once, and a centre on the surface counts as just above it. For real meshes, which may be open, see
    `trainer.evaluation.fill`.

    Raises ValueError for coordinates that are not finite.
    """
    full: Bool[ndarray, "R R R"] = winding_numbers(vertices, faces, resolution) != 0
    return full


def inside_out(vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"]) -> float:
    """The share of what a closed mesh encloses, in fine voxels, around which its faces look inward; 0 of a mesh that is
    too thin for any.

    Raises ValueError for coordinates that are not finite.
    """
    winding = winding_numbers(vertices, faces, RESOLUTION * FINENESS)
    enclosed = np.count_nonzero(winding)
    return np.count_nonzero(np.less(winding, 0)) / enclosed if enclosed else 0.0


def winding_numbers(
    vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"], resolution: int
) -> Int32[ndarray, "R R R"]:
    """How often a closed surface winds around each voxel's centre: 1 inside of a solid whose faces look outward.

    Raises ValueError for coordinates that are not finite.
    """
    if not np.isfinite(vertices).all():
        raise ValueError("expected finite vertices, found NaN or infinity")
    # In units of voxels, so that centres are whole numbers: crossings of a face are then found without rounding.
    corners = (np.asarray(vertices, np.float64)[np.asarray(faces)] + 0.5) * resolution - 0.5
    winding: Int32[ndarray, "R R R"] = _winding(np.ascontiguousarray(corners), resolution)
    return winding


@kernel()
def _winding(corners, resolution):
    """Winding number of each centre: the signs of the faces below it, summed up along its column."""
    winding = np.zeros((resolution, resolution, resolution), np.int32)
    columns, heights = np.empty((resolution**2, 2), np.int64), np.empty(resolution**2)
    for face in range(corners.shape[0]):
        count, sign = crossings(corners[face], resolution, columns, heights)
        for crossing in range(count):
            y = first_centre(heights[crossing], resolution)
            if y < resolution:
                winding[columns[crossing, 0], y, columns[crossing, 1]] -= sign
    for x in range(resolution):
        for y in range(1, resolution):
            for z in range(resolution):
                winding[x, y, z] += winding[x, y - 1, z]
    return winding
