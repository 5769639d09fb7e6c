"""A face's colour around a point as (value there, slope), and its adjoint.

Tangent to the true colour if the face's plane has a depth there that occurs on the face; else linear between corners.
"""

import triton
import triton.language as tl

from trainer.rendering.triton_kernels.nearest import RECORD

DEPTH_RANGE = tl.constexpr(16)


@triton.jit
def depth_around(planes, records, row, channels, x, y, mask):
    """Whether the tangent applies, the depth there, its slope, and the first of the channels' planes.

    Where it does not apply the depth is 1 and flat: dividing by it leaves a linear colour as it is.
    """
    base = planes + row * (1 + 2 * channels) * 3
    p, q, r = tl.load(base, mask, 1.0), tl.load(base + 1, mask, 0.0), tl.load(base + 2, mask, 0.0)
    depth = p + q * x + r * y
    least = tl.load(records + row * RECORD + DEPTH_RANGE, mask, 0.0)
    greatest = tl.load(records + row * RECORD + DEPTH_RANGE + 1, mask, 0.0)
    tangent = mask & (least <= depth) & (depth <= greatest)
    depth, q, r = tl.where(tangent, depth, 1.0), tl.where(tangent, q, 0.0), tl.where(tangent, r, 0.0)
    return tangent, depth, q, r, 3 * tl.where(tangent, 1, 1 + channels)


@triton.jit
def colour_around(plane, depth, depth_x, depth_y, x, y, mask):
    """Value and slope of a channel from its plane; 0 for the background."""
    p, q, r = tl.load(plane, mask, 0.0), tl.load(plane + 1, mask, 0.0), tl.load(plane + 2, mask, 0.0)
    value = (p + q * x + r * y) / depth
    return value, (q - depth_x * value) / depth, (r - depth_y * value) / depth


@triton.jit
def colour_around_gradient(
    gradient, value, slope_x, slope_y, depth, depth_x, depth_y, to_value, to_x, to_y, x, y, mask
):
    """Adds to the gradient of a channel's plane; returns what goes to the depth and its slope."""
    to_value -= (to_x * depth_x + to_y * depth_y) / depth
    add_to_plane(gradient, to_value / depth, to_x / depth, to_y / depth, x, y, mask)
    to_depth = -(to_value * value + to_x * slope_x + to_y * slope_y) / depth
    return to_depth, -to_x * value / depth, -to_y * value / depth


@triton.jit
def add_to_plane(gradient, to_value, to_x, to_y, x, y, mask):
    """Adds the gradients of a plane's value at a point and of its slope to those of its coefficients."""
    tl.atomic_add(gradient, to_value, mask=mask)
    tl.atomic_add(gradient + 1, to_value * x + to_x, mask=mask)
    tl.atomic_add(gradient + 2, to_value * y + to_y, mask=mask)
