"""The shadow of a piece: the part of its pixel's square that lies behind it, seen from the pixel's centre.

Branches that nobody could predict are left out: on which side of the square a ray leaves it, for one.
"""

import numpy as np

from rasteriser.compilation import kernel


@kernel(error_model="numpy", _nrt=False, inline="always")
def perimeter_position(x, y):
    """Where the ray from the centre of the unit square through (x, y) leaves it: side k has the positions k ± 1/2,
    counter-clockwise from the right."""
    flat = abs(x) >= abs(y)
    far, near = (x, y) if flat else (y, -x)
    side = (0.0 if x > 0.0 else 2.0) if flat else (1.0 if y > 0.0 else 3.0)
    return side + 0.5 * near / far if far != 0.0 else 0.0


@kernel(error_model="numpy", _nrt=False, inline="always")
def swept_moment(position):
    """First moments of the part of the square that a ray sweeps from the lower right corner up to a position."""
    side = np.floor(position + 0.5)
    s = position - side
    along, across = (s + 0.5) / 12.0, (s * s - 0.25) / 12.0
    # Sides 1 and 2 are swept from the far end on; a position of 3.5 or more lies on side 0 again.
    x, y = (across, along) if (side == 1.0) | (side == 3.0) else (along, across)
    x = 1.0 / 12.0 - x if (side == 1.0) | (side == 2.0) else x
    y = 1.0 / 12.0 - y if (side == 2.0) | (side == 3.0) else y
    return x, y


@kernel(error_model="numpy", _nrt=False, inline="always")
def shadow_of(ax, ay, bx, by):
    """Area and first moments of the part of the unit square around the origin behind the segment a b."""
    cross = ax * by - ay * bx
    turn = 1.0 if cross > 0.0 else -1.0
    start, end = perimeter_position(ax, ay), perimeter_position(bx, by)
    swept = abs(end - start)
    start_x, start_y = swept_moment(start)
    end_x, end_y = swept_moment(end)
    triangle = abs(cross) / 6.0
    return (
        min(swept, 4.0 - swept) / 4.0 - abs(cross) / 2.0,
        turn * (end_x - start_x) - triangle * (ax + bx),
        turn * (end_y - start_y) - triangle * (ay + by),
    )


@kernel(error_model="numpy", _nrt=False)
def find_shadows(points, count):
    """Writes area and first moments of each piece's shadow to points[:, 4:7]."""
    for n in range(count):
        points[n, 4], points[n, 5], points[n, 6] = shadow_of(points[n, 0], points[n, 1], points[n, 2], points[n, 3])
