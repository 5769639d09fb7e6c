"""Where a triangle crosses the columns of a grid: the ground that both occupancy tests stand on."""

import numpy as np

from rasteriser.compilation import kernel


@kernel(error_model="numpy")
def crossings(corner, resolution, columns, heights):
    """Finds the columns (x, z) along y that a triangle crosses, and the heights at which it does.

    `corner` [3, xyz] is in units of voxels, with voxel centres at whole numbers. Fills `columns` [R·R, 2] and
    `heights` [R·R], and returns their number and the triangle's sign: +1 where a column that rises along +y passes it
    from the back to the front, and so enters a solid whose faces look outward with -1.

    Which columns those are is decided as in scan conversion: half-open along z, then half-open along x between edge
    crossings that are computed from the edge's lower to its upper end, alike for both faces that share the edge. Each
    column thus meets every fold of a closed surface exactly once, edges and vertices included.
    """
    x0, y0, z0 = corner[0, 0], corner[0, 1], corner[0, 2]
    x1, y1, z1 = corner[1, 0] - x0, corner[1, 1] - y0, corner[1, 2] - z0
    x2, y2, z2 = corner[2, 0] - x0, corner[2, 1] - y0, corner[2, 2] - z0
    area = z1 * x2 - x1 * z2
    if area == 0.0:
        return 0, 0
    slope_x, slope_z = (z1 * y2 - y1 * z2) / area, (y1 * x2 - x1 * y2) / area
    low, high = min(corner[0, 1], corner[1, 1], corner[2, 1]), max(corner[0, 1], corner[1, 1], corner[2, 1])
    first_z = first_centre(min(corner[0, 2], corner[1, 2], corner[2, 2]), resolution)
    last_z = first_centre(max(corner[0, 2], corner[1, 2], corner[2, 2]), resolution)
    count = 0
    for z in range(first_z, last_z):
        x_low, x_high = np.inf, -np.inf
        for edge in range(3):
            start, end = edge, (edge + 1) % 3
            if corner[start, 2] > corner[end, 2]:
                start, end = end, start
            if corner[start, 2] <= z < corner[end, 2]:
                share = (z - corner[start, 2]) / (corner[end, 2] - corner[start, 2])
                x = corner[start, 0] + share * (corner[end, 0] - corner[start, 0])
                x_low, x_high = min(x_low, x), max(x_high, x)
        for x in range(first_centre(x_low, resolution), first_centre(x_high, resolution)):
            columns[count, 0], columns[count, 1] = x, z
            # Rounding must not carry a crossing beyond the triangle.
            heights[count] = min(max(y0 + slope_x * (x - x0) + slope_z * (z - z0), low), high)
            count += 1
    return count, 1 if area > 0 else -1


@kernel()
def first_centre(position, resolution):
    """The first voxel centre at or beyond a position, within [0, resolution]."""
    return int(min(max(np.ceil(position), 0.0), float(resolution)))
