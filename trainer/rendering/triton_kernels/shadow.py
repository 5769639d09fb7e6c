"""Area and first moments of the part of a pixel's square that a piece hides from its centre, and their adjoint.

All points are relative to the centre. Positions on the square's perimeter run from -1/2 to 7/2, counter-clockwise;
side k, of outward normal (1, 0), (0, 1), (-1, 0), (0, -1), has the positions from k - 1/2 to k + 1/2.
"""

import triton
import triton.language as tl


@triton.jit
def shadow(ax, ay, bx, by):
    """Area, and moments along x and y."""
    cross = ax * by - ay * bx
    start, end = _perimeter_position(ax, ay), _perimeter_position(bx, by)
    turn = tl.abs(end - start)
    start_x, start_y = _swept_moment(start)
    end_x, end_y = _swept_moment(end)
    way = _sign(cross)
    area = tl.minimum(turn, 4 - turn) / 4 - tl.abs(cross) / 2
    moment_x = (end_x - start_x) * way - tl.abs(cross) / 6 * (ax + bx)
    moment_y = (end_y - start_y) * way - tl.abs(cross) / 6 * (ay + by)
    return area, moment_x, moment_y


@triton.jit
def shadow_gradient(ax, ay, bx, by, to_area, to_moment_x, to_moment_y):
    """Gradients of both ends from those of area and moments."""
    cross = ax * by - ay * bx
    start, end = _perimeter_position(ax, ay), _perimeter_position(bx, by)
    turn = tl.abs(end - start)
    to_turn = to_area * tl.where(turn < 2, 0.25, tl.where(turn > 2, -0.25, 0.0)) * _sign(end - start)
    way = _sign(cross)
    start_x, start_y = _swept_moment_slope(start)
    end_x, end_y = _swept_moment_slope(end)
    to_start = -to_turn - way * (to_moment_x * start_x + to_moment_y * start_y)
    to_end = to_turn + way * (to_moment_x * end_x + to_moment_y * end_y)
    to_cross = -way * (to_area / 2 + (to_moment_x * (ax + bx) + to_moment_y * (ay + by)) / 6)
    shared_x, shared_y = -tl.abs(cross) / 6 * to_moment_x, -tl.abs(cross) / 6 * to_moment_y
    spin_ax, spin_ay = _perimeter_position_slope(ax, ay)
    spin_bx, spin_by = _perimeter_position_slope(bx, by)
    to_ax = to_start * spin_ax + to_cross * by + shared_x
    to_ay = to_start * spin_ay - to_cross * bx + shared_y
    to_bx = to_end * spin_bx - to_cross * ay + shared_x
    to_by = to_end * spin_by + to_cross * ax + shared_y
    return to_ax, to_ay, to_bx, to_by


@triton.jit
def _sign(x):
    return tl.where(x > 0, 1.0, tl.where(x < 0, -1.0, 0.0))


@triton.jit
def _perimeter_position(x, y):
    """Where the ray through a point leaves the square."""
    steep = tl.abs(x) < tl.abs(y)
    on_side = 0.5 * tl.where(steep, -x, y) / _divisor(x, y)
    side = tl.where(steep, tl.where(y > 0, 1.0, 3.0), tl.where(x >= 0, 0.0, 2.0))
    return on_side + side


@triton.jit
def _perimeter_position_slope(x, y):
    """Derivatives by x and y."""
    steep, divisor = tl.abs(x) < tl.abs(y), _divisor(x, y)
    by_x = tl.where(steep, -0.5 / divisor, -0.5 * y / (divisor * divisor))
    by_y = tl.where(steep, 0.5 * x / (divisor * divisor), 0.5 / divisor)
    return tl.where((x == 0) & (y == 0), 0.0, by_x), tl.where((x == 0) & (y == 0), 0.0, by_y)


@triton.jit
def _divisor(x, y):
    """The larger coordinate; 1 at the centre itself."""
    larger = tl.where(tl.abs(x) < tl.abs(y), y, x)
    return tl.where(larger == 0, 1.0, larger)


@triton.jit
def _swept_moment(position):
    """First moments, along x and y, of the part of the square that a ray sweeps from position -1/2 on."""
    side, along = _side(position)
    # Around the square: sum of the normals of the sides before, normal, and the next side's normal.
    before_x = tl.where((side == 1) | (side == 2), 1.0, 0.0)
    before_y = tl.where((side == 2) | (side == 3), 1.0, 0.0)
    normal_x, normal_y, next_x, next_y = _normals(side)
    half, bow = along + 0.5, along * along - 0.25
    return (before_x + normal_x * half + next_x * bow) / 12, (before_y + normal_y * half + next_y * bow) / 12


@triton.jit
def _swept_moment_slope(position):
    """Derivatives of both moments by the position."""
    side, along = _side(position)
    normal_x, normal_y, next_x, next_y = _normals(side)
    return (normal_x + 2 * along * next_x) / 12, (normal_y + 2 * along * next_y) / 12


@triton.jit
def _side(position):
    """The side on which a position lies, and how far from the side's middle."""
    side = tl.floor(position + 0.5)
    return tl.where(side == 4, 0.0, side), position - side


@triton.jit
def _normals(side):
    """A side's outward normal and the next side's."""
    x = tl.where(side == 0, 1.0, tl.where(side == 2, -1.0, 0.0))
    y = tl.where(side == 1, 1.0, tl.where(side == 3, -1.0, 0.0))
    return x, y, -y, x
