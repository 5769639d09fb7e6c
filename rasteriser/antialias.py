"""Exact antialiasing: what each piece of contour, crease or crossing changes in its pixel.

Seen from the pixel's centre, a piece casts a *shadow*, the part of the pixel's square behind it. The pixel changes by
the shadow's integral of (colour of the face beyond the piece - colour of the face on this side of it), both linear
around the centre: area and first moments of the shadow are all that is needed. docs/renderer.md says why the sum over
all pieces is the box filter.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import NOTHING, plane_value
from rasteriser.pieces import AT_COLUMN, AT_EDGE, AT_SEGMENT, AT_VERTEX
from rasteriser.segments import CROSSING


@kernel(error_model="numpy", _nrt=False, inline="always")
def face_of(codes, piece, which):
    """The first or the second face at a piece, and the sign of what it adds: that on this side less, that beyond more.

    Where there is one face only, it is the first, on whichever side: so the processor learns to expect it.
    """
    here, beyond = codes[piece, 2], codes[piece, 3]
    if which == 0:
        return (here, -1.0) if here != NOTHING else (beyond, 1.0)
    return (beyond, 1.0) if here != NOTHING else (NOTHING, 1.0)


@kernel(error_model="numpy", _nrt=False, inline="always")
def face_integral(planes, boxes, face, x, y, area, moment_x, moment_y, channels):
    """∫ colour of a face over a shadow whose moments are about (x, y), as (k, p, q, r): that of channel c is the
    `product` of these three and the plane k + c.

    The colour is taken as linear: tangent to the true one at (x, y) where the face's plane has a depth there that
    occurs on the face; elsewhere as between the face's corners.
    """
    depth = plane_value(planes, face, 0, x, y)
    on_face = (boxes[face, 4] <= depth) & (depth <= boxes[face, 5])
    first, inverse = (1, 1.0 / depth) if on_face else (1 + channels, 1.0)
    along_x, along_y = moment_x * inverse, moment_y * inverse
    slope = along_x * planes[face, 0, 1] + along_y * planes[face, 0, 2]
    to_value = (area - (slope if on_face else 0.0)) * inverse
    return first, to_value, to_value * x + along_x, to_value * y + along_y


@kernel(error_model="numpy", _nrt=False, inline="always")
def face_gradient(planes, boxes, face, x, y, sign, area, moment_x, moment_y, picture_gradient, ix, iy, plane_gradients):
    """Adjoint of sign · `face_integral`; returns the gradients of area and moments, and adds to plane_gradients."""
    channels = picture_gradient.shape[0]
    depth = plane_value(planes, face, 0, x, y)
    on_face = (boxes[face, 4] <= depth) & (depth <= boxes[face, 5])
    first, inverse = (1, 1.0 / depth) if on_face else (1 + channels, 1.0)
    slope_x, slope_y = (planes[face, 0, 1], planes[face, 0, 2]) if on_face else (0.0, 0.0)
    along_x, along_y = moment_x * inverse, moment_y * inverse
    to_value = (area - along_x * slope_x - along_y * slope_y) * inverse
    to_area, to_x, to_y, to_depth, value_sum = 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(channels):
        k, upstream = first + c, sign * np.float64(picture_gradient[c, iy, ix])
        value = plane_value(planes, face, k, x, y) * inverse
        change_x = (planes[face, k, 1] - value * slope_x) * inverse
        change_y = (planes[face, k, 2] - value * slope_y) * inverse
        to_area += upstream * value
        to_x += upstream * change_x
        to_y += upstream * change_y
        plane_gradients[face, k, 0] += upstream * to_value
        plane_gradients[face, k, 1] += upstream * (to_value * x + along_x)
        plane_gradients[face, k, 2] += upstream * (to_value * y + along_y)
        to_depth -= upstream * (value * to_value + along_x * change_x + along_y * change_y)
        value_sum += upstream * value
    if not on_face:
        to_depth, value_sum = 0.0, 0.0
    plane_gradients[face, 0, 0] += to_depth
    plane_gradients[face, 0, 1] += to_depth * x - along_x * value_sum
    plane_gradients[face, 0, 2] += to_depth * y - along_y * value_sum
    return to_area, to_x, to_y


@kernel(error_model="numpy", _nrt=False, inline="always")
def product(planes, face, plane, p, q, r):
    return p * planes[face, plane, 0] + q * planes[face, plane, 1] + r * planes[face, plane, 2]


@kernel(error_model="numpy", _nrt=False)
def add_pieces(planes, boxes, points, codes, count, picture):
    """Adds to picture [C, H, >= W] what pieces change in the pixels that they lie in."""
    channels = picture.shape[0]
    for n in range(count):
        ix, iy, area, moment_x, moment_y = codes[n, 0], codes[n, 1], points[n, 4], points[n, 5], points[n, 6]
        x, y = ix + 0.5, iy + 0.5
        face, sign = face_of(codes, n, 0)
        k, p, q, r = face_integral(planes, boxes, face, x, y, area, moment_x, moment_y, channels)
        p, q, r = sign * p, sign * q, sign * r
        other, _ = face_of(codes, n, 1)
        if other == NOTHING:
            for c in range(channels):
                picture[c, iy, ix] += product(planes, face, k + c, p, q, r)
            continue
        m, s, t, u = face_integral(planes, boxes, other, x, y, area, moment_x, moment_y, channels)
        for c in range(channels):
            picture[c, iy, ix] += product(planes, face, k + c, p, q, r) + product(planes, other, m + c, s, t, u)


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
    other_a, other_b = (1.0, 0.0) if kind == AT_COLUMN else (0.0, 1.0)
    if kind == AT_EDGE:
        other_a, other_b = lines[at, 0], lines[at, 1]
    elif kind == AT_SEGMENT:
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
    elif kind == AT_SEGMENT:
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
        area, moment_x, moment_y = points[n, 4], points[n, 5], points[n, 6]
        to_area, to_x, to_y = 0.0, 0.0, 0.0
        for which in range(2):
            face, sign = face_of(codes, n, which)
            if face != NOTHING:
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
