"""Exact antialiasing: what each piece of contour, crease or crossing changes in its pixel.

Seen from the pixel's centre, a piece casts a *shadow*, the part of the pixel's square behind it. The pixel changes by
the shadow's integral of (colour of the face beyond the piece - colour of the face on this side of it), both linear
around the centre: area and first moments of the shadow are all that is needed. docs/renderer.md says why the sum over
all pieces is the box filter.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import NOTHING, plane_value
from rasteriser.pieces import AT_COLUMN, AT_EDGE, AT_ROW, AT_VERTEX
from rasteriser.segments import CROSSING


@kernel(error_model="numpy", _nrt=False, inline="always")
def perimeter_position(x, y):
    """Where the ray from the centre of the unit square through (x, y) leaves it: side k has the positions k ± 1/2,
    counter-clockwise from the right."""
    if abs(x) >= abs(y):
        if x == 0.0:
            return 0.0
        return 0.5 * y / x + (0.0 if x > 0 else 2.0)
    return -0.5 * x / y + (1.0 if y > 0 else 3.0)


@kernel(error_model="numpy", _nrt=False, inline="always")
def swept_moment(position):
    """First moments of the part of the square that a ray sweeps from the lower right corner up to a position."""
    if position < 0.5 or position >= 3.5:
        s = position if position < 0.5 else position - 4.0
        return (s + 0.5) / 12.0, (s * s - 0.25) / 12.0
    if position < 1.5:
        s = position - 1.0
        return (1.0 - (s * s - 0.25)) / 12.0, (s + 0.5) / 12.0
    if position < 2.5:
        s = position - 2.0
        return (1.0 - (s + 0.5)) / 12.0, (1.0 - (s * s - 0.25)) / 12.0
    s = position - 3.0
    return (s * s - 0.25) / 12.0, (1.0 - (s + 0.5)) / 12.0


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


@kernel(error_model="numpy", _nrt=False, inline="always")
def face_integral(planes, boxes, face, x, y, channel, channels, area, moment_x, moment_y):
    """∫ colour of a face over a shadow whose moments are about (x, y), of one channel; 0 where there is no face.

    The colour is taken as linear: tangent to the true one at (x, y) where the face's plane has a depth there that
    occurs on the face; elsewhere as between the face's corners.
    """
    value = 0.0
    if face != NOTHING:
        depth = plane_value(planes, face, 0, x, y)
        if boxes[face, 4] <= depth <= boxes[face, 5]:
            inverse, k = 1.0 / depth, 1 + channel
            slope = moment_x * planes[face, 0, 1] + moment_y * planes[face, 0, 2]
            change = moment_x * planes[face, k, 1] + moment_y * planes[face, k, 2]
            value = ((area - slope * inverse) * plane_value(planes, face, k, x, y) + change) * inverse
        else:
            k = 1 + channels + channel
            change = moment_x * planes[face, k, 1] + moment_y * planes[face, k, 2]
            value = area * plane_value(planes, face, k, x, y) + change
    return value


@kernel(error_model="numpy", _nrt=False, inline="always")
def face_gradient(planes, boxes, face, x, y, sign, area, moment_x, moment_y, picture_gradient, ix, iy, plane_gradients):
    """Adjoint of sign · `face_integral`; returns the gradients of area and moments, and adds to plane_gradients."""
    channels = picture_gradient.shape[0]
    depth, slope_x, slope_y = plane_value(planes, face, 0, x, y), planes[face, 0, 1], planes[face, 0, 2]
    to_area, to_x, to_y = 0.0, 0.0, 0.0
    if boxes[face, 4] <= depth <= boxes[face, 5]:
        inverse = 1.0 / depth
        to_value = (area - (moment_x * slope_x + moment_y * slope_y) * inverse) * inverse
        along_x, along_y = moment_x * inverse, moment_y * inverse
        to_depth, value_sum = 0.0, 0.0
        for c in range(channels):
            upstream = sign * np.float64(picture_gradient[c, iy, ix])
            value = plane_value(planes, face, 1 + c, x, y) * inverse
            change_x = (planes[face, 1 + c, 1] - value * slope_x) * inverse
            change_y = (planes[face, 1 + c, 2] - value * slope_y) * inverse
            to_area += upstream * value
            to_x += upstream * change_x
            to_y += upstream * change_y
            plane_gradients[face, 1 + c, 0] += upstream * to_value
            plane_gradients[face, 1 + c, 1] += upstream * (to_value * x + along_x)
            plane_gradients[face, 1 + c, 2] += upstream * (to_value * y + along_y)
            to_depth -= upstream * (value * to_value + along_x * change_x + along_y * change_y)
            value_sum += upstream * value
        plane_gradients[face, 0, 0] += to_depth
        plane_gradients[face, 0, 1] += to_depth * x - along_x * value_sum
        plane_gradients[face, 0, 2] += to_depth * y - along_y * value_sum
    else:
        for c in range(1 + channels, 1 + 2 * channels):
            upstream = sign * np.float64(picture_gradient[c - 1 - channels, iy, ix])
            to_area += upstream * plane_value(planes, face, c, x, y)
            to_x += upstream * planes[face, c, 1]
            to_y += upstream * planes[face, c, 2]
            plane_gradients[face, c, 0] += upstream * area
            plane_gradients[face, c, 1] += upstream * (area * x + moment_x)
            plane_gradients[face, c, 2] += upstream * (area * y + moment_y)
    return to_area, to_x, to_y


@kernel(error_model="numpy", _nrt=False)
def add_pieces(planes, boxes, points, codes, count, picture):
    """Adds to picture [C, H, >= W] what pieces change in the pixels that they lie in."""
    channels = picture.shape[0]
    for n in range(count):
        ix, iy, here, beyond = codes[n, 0], codes[n, 1], codes[n, 2], codes[n, 3]
        area, moment_x, moment_y = shadow_of(points[n, 0], points[n, 1], points[n, 2], points[n, 3])
        x, y = ix + 0.5, iy + 0.5
        for c in range(channels):
            ahead = face_integral(planes, boxes, beyond, x, y, c, channels, area, moment_x, moment_y)
            picture[c, iy, ix] += ahead - face_integral(
                planes, boxes, here, x, y, c, channels, area, moment_x, moment_y
            )


@kernel(error_model="numpy", _nrt=False, inline="always")
def line_of(segment, codes, lines, planes):
    """(a, b, c) of the line that a segment lies on."""
    if codes[segment, 0] != CROSSING:
        e = codes[segment, 0]
        return lines[e, 0], lines[e, 1], lines[e, 2]
    f, g = codes[segment, 1], codes[segment, 2]
    return (
        planes[f, 0, 1] - planes[g, 0, 1],
        planes[f, 0, 2] - planes[g, 0, 2],
        planes[f, 0, 0] - planes[g, 0, 0],
    )


@kernel(error_model="numpy", _nrt=False, inline="always")
def edge_gradient(screen, edges, edge, x, y, to_value, screen_gradient):
    """Adjoint of the value of an edge's line at a fixed point."""
    i, j = edges[edge, 0], edges[edge, 1]
    screen_gradient[i, 0] += to_value * (y - screen[j, 1])
    screen_gradient[i, 1] += to_value * (screen[j, 0] - x)
    screen_gradient[j, 0] += to_value * (screen[i, 1] - y)
    screen_gradient[j, 1] += to_value * (x - screen[i, 0])


@kernel(error_model="numpy", _nrt=False, inline="always")
def segment_gradient(screen, edges, segment, codes, x, y, to_value, screen_gradient, plane_gradients):
    """Adjoint of the value of a segment's line at a fixed point."""
    if codes[segment, 0] != CROSSING:
        edge_gradient(screen, edges, codes[segment, 0], x, y, to_value, screen_gradient)
        return
    for which in range(2):
        face, part = codes[segment, 1 + which], to_value if which == 0 else -to_value
        plane_gradients[face, 0, 0] += part
        plane_gradients[face, 0, 1] += part * x
        plane_gradients[face, 0, 2] += part * y


@kernel(error_model="numpy", _nrt=False, inline="always")
def end_gradient(
    screen, edges, lines, planes, segment, kind, at, segment_codes, x, y, to_x, to_y, screen_gradient, plane_gradients
):
    """Adjoint of where a piece ends: at a vertex, or where its segment's line meets another line."""
    if kind == AT_VERTEX:
        screen_gradient[at, 0] += to_x
        screen_gradient[at, 1] += to_y
        return
    a, b, _ = line_of(segment, segment_codes, lines, planes)
    if kind == AT_COLUMN:
        other_a, other_b = 1.0, 0.0
    elif kind == AT_ROW:
        other_a, other_b = 0.0, 1.0
    elif kind == AT_EDGE:
        other_a, other_b = lines[at, 0], lines[at, 1]
    else:
        other_a, other_b, _ = line_of(at, segment_codes, lines, planes)
    determinant = a * other_b - b * other_a
    if determinant == 0.0:
        return
    # Both lines vanish at the point: d point = -J⁻¹ (d own, d other), with J the lines' slopes.
    to_own = (other_a * to_y - other_b * to_x) / determinant
    to_other = (b * to_x - a * to_y) / determinant
    segment_gradient(screen, edges, segment, segment_codes, x, y, to_own, screen_gradient, plane_gradients)
    if kind == AT_EDGE:
        edge_gradient(screen, edges, at, x, y, to_other, screen_gradient)
    elif kind not in (AT_COLUMN, AT_ROW):
        segment_gradient(screen, edges, at, segment_codes, x, y, to_other, screen_gradient, plane_gradients)


@kernel(error_model="numpy", _nrt=False)
def pieces_gradient(
    screen, edges, lines, planes, boxes, segment_codes, points, codes, count, picture_gradient,
    plane_gradients, screen_gradient,
):  # fmt: skip
    """Adjoint of `add_pieces`, and of where the pieces end; the last two arrays are added to."""
    for n in range(count):
        ix, iy = codes[n, 0], codes[n, 1]
        ax, ay, bx, by = points[n, 0], points[n, 1], points[n, 2], points[n, 3]
        area, moment_x, moment_y = shadow_of(ax, ay, bx, by)
        to_area, to_x, to_y = 0.0, 0.0, 0.0
        for which in range(2):
            face = codes[n, 2 + which]
            if face != NOTHING:
                sign = -1.0 if which == 0 else 1.0
                part, part_x, part_y = face_gradient(
                    planes, boxes, face, ix + 0.5, iy + 0.5, sign, area, moment_x, moment_y, picture_gradient, ix, iy,
                    plane_gradients,
                )  # fmt: skip
                to_area += part
                to_x += part_x
                to_y += part_y
        cross = ax * by - ay * bx
        turn = 1.0 if cross > 0.0 else -1.0
        along_sum = to_x * (ax + bx) + to_y * (ay + by)
        for end in range(2):
            px, py, ox, oy = (ax, ay, bx, by) if end == 0 else (bx, by, ax, ay)
            outward = -turn if end == 0 else turn
            # The ray through the end sweeps (p × dp) / (8 max|p|²), whose centroid lies at 2/3 of the way to the
            # border; the triangle in front of the piece grows by (other × dp) / 2.
            reach = max(abs(px), abs(py))
            spin = 0.0
            if reach > 0.0:
                spin = 0.125 / (reach * reach) * (to_area + (to_x * px + to_y * py) / (3.0 * reach))
            triangle = 0.5 * to_area + along_sum / 6.0
            to_px = outward * (-spin * py + triangle * oy) - abs(cross) / 6.0 * to_x
            to_py = outward * (spin * px - triangle * ox) - abs(cross) / 6.0 * to_y
            end_gradient(
                screen, edges, lines, planes, codes[n, 4], codes[n, 5 + 2 * end], codes[n, 6 + 2 * end], segment_codes,
                px + ix + 0.5, py + iy + 0.5, to_px, to_py, screen_gradient, plane_gradients,
            )  # fmt: skip
