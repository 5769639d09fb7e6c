"""Occupancy of closed, oriented meshes on a grid: the learnt meshes and the procedural shapes.

The grid spans the cube [-0.5, 0.5]³ of the object frame; a voxel [i, j, k] is full where its centre,
((i, j, k) + 0.5) / R - 0.5 along x, y, z, is inside.
"""

import numpy as np
from jaxtyping import Bool, Float, Integer
from numba import njit
from numpy import ndarray

from trainer.evaluation.columns import crossings, first_centre

RESOLUTION = 32
"""Voxels along each side of the cube (paper: 32³, section 5.2)."""


def voxelise(
    vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"], resolution: int = RESOLUTION
) -> Bool[ndarray, "R R R"]:
    """The voxels whose centres have a winding number other than zero.

    Right for closed surfaces, consistently oriented part by part, that may overlap and intersect themselves, whichever
    way they look. Exact also for centres in line with vertices and edges: each column meets every fold of a closed
    surface once, and a centre on the surface counts as just above it. For real meshes, which may be open, see
    `trainer.evaluation.fill.voxelise_solid`.

    Raises ValueError for coordinates that are not finite.
    """
    if not np.isfinite(vertices).all():
        raise ValueError("expected finite vertices, found NaN or infinity")
    # In units of voxels, so that centres are whole numbers: crossings of a face are then found without rounding.
    corners = (np.asarray(vertices, np.float64)[np.asarray(faces)] + 0.5) * resolution - 0.5
    full: Bool[ndarray, "R R R"] = _winding(np.ascontiguousarray(corners), resolution) != 0
    return full


@njit(nogil=True, cache=True)
def _winding(corners, resolution):
    """Winding number of each centre, up to its sign: the signs of the faces below it, summed up along its column."""
    winding = np.zeros((resolution, resolution, resolution), np.int32)
    columns, heights = np.empty((resolution**2, 2), np.int64), np.empty(resolution**2)
    for face in range(corners.shape[0]):
        count, sign = crossings(corners[face], resolution, columns, heights)
        for crossing in range(count):
            y = first_centre(heights[crossing], resolution)
            if y < resolution:
                winding[columns[crossing, 0], y, columns[crossing, 1]] += sign
    for x in range(resolution):
        for y in range(1, resolution):
            for z in range(resolution):
                winding[x, y, z] += winding[x, y - 1, z]
    return winding
