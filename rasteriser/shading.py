"""Perspective-correct Gouraud colours at pixel centres, and their adjoint.

The colour of a face at a point is N_c / w, both planes of the face (`coverage.set_up_faces`). Gradients are gathered
per plane and turned into gradients of vertices and colours once per face.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import is_thin, pixels_between
from rasteriser.vectors import LANES, as_doubles, as_singles, load, ramp, select, store, total, zeros


@kernel(error_model="numpy", _nrt=False, fastmath={"contract"})
def add_interior(planes, boxes, seen, visible, depths, width, picture):
    """Adds the colour at each covered pixel centre to picture [C, H, W + LANES]."""
    channels, height = picture.shape[0], picture.shape[1]
    for f in range(len(boxes)):
        if not seen[f + 1]:
            continue
        first_x, last_x = pixels_between(boxes[f, 0], boxes[f, 1], width)
        first_y, last_y = pixels_between(boxes[f, 2], boxes[f, 3], height)
        for iy in range(first_y, last_y):
            y, there, behind = iy + 0.5, visible[iy], depths[iy]
            for start in range(first_x, last_x, LANES):
                x, depth = ramp(start + 0.5), select(load(there, start) == f, load(behind, start), 0.0)
                for c in range(channels):
                    value, along = planes[f, 1 + c, 0] + planes[f, 1 + c, 2] * y, planes[f, 1 + c, 1]
                    out = picture[c, iy]
                    store(out, start, load(out, start) + as_singles((x * along + value) * depth))


@kernel(error_model="numpy", _nrt=False, fastmath={"contract"})
def interior_gradient(planes, boxes, seen, visible, depths, width, picture_gradient, plane_gradients):
    """Adjoint of `add_interior`; plane_gradients [F, 1 + 2C, 3] is added to."""
    channels, height = picture_gradient.shape[0], picture_gradient.shape[1]
    for f in range(len(boxes)):
        if not seen[f + 1]:
            continue
        first_x, last_x = pixels_between(boxes[f, 0], boxes[f, 1], width)
        first_y, last_y = pixels_between(boxes[f, 2], boxes[f, 3], height)
        to_depth, to_depth_x, to_depth_y = zeros(), zeros(), zeros()
        # Three channels at once, so that what they share is looked up once. Those beyond the last count as nothing.
        for c in range(0, channels, 3):
            d, e = min(c + 1, channels - 1), min(c + 2, channels - 1)
            second, third = 1.0 if d > c else 0.0, 1.0 if e > d else 0.0
            c0, cx, cy = zeros(), zeros(), zeros()
            d0, dx, dy = zeros(), zeros(), zeros()
            e0, ex, ey = zeros(), zeros(), zeros()
            along_c, along_d, along_e = planes[f, 1 + c, 1], planes[f, 1 + d, 1], planes[f, 1 + e, 1]
            for iy in range(first_y, last_y):
                y, there, behind = iy + 0.5, visible[iy], depths[iy]
                row_c, row_d, row_e = picture_gradient[c, iy], picture_gradient[d, iy], picture_gradient[e, iy]
                value_c = planes[f, 1 + c, 0] + planes[f, 1 + c, 2] * y
                value_d = planes[f, 1 + d, 0] + planes[f, 1 + d, 2] * y
                value_e = planes[f, 1 + e, 0] + planes[f, 1 + e, 2] * y
                for start in range(first_x, last_x, LANES):
                    x, depth = ramp(start + 0.5), select(load(there, start) == f, load(behind, start), 0.0)
                    part = as_doubles(load(row_c, start)) * depth
                    c0, cx, cy = c0 + part, cx + part * x, cy + part * y
                    nearer = part * (x * along_c + value_c)
                    part = as_doubles(load(row_d, start)) * (depth * second)
                    d0, dx, dy = d0 + part, dx + part * x, dy + part * y
                    nearer = nearer + part * (x * along_d + value_d)
                    part = as_doubles(load(row_e, start)) * (depth * third)
                    e0, ex, ey = e0 + part, ex + part * x, ey + part * y
                    nearer = (nearer + part * (x * along_e + value_e)) * depth
                    to_depth = to_depth + nearer
                    to_depth_x = to_depth_x + nearer * x
                    to_depth_y = to_depth_y + nearer * y
            for channel, to_value, to_value_x, to_value_y in ((c, c0, cx, cy), (d, d0, dx, dy), (e, e0, ex, ey)):
                plane_gradients[f, 1 + channel, 0] += total(to_value)
                plane_gradients[f, 1 + channel, 1] += total(to_value_x)
                plane_gradients[f, 1 + channel, 2] += total(to_value_y)
        plane_gradients[f, 0, 0] -= total(to_depth)
        plane_gradients[f, 0, 1] -= total(to_depth_x)
        plane_gradients[f, 0, 2] -= total(to_depth_y)


@kernel(error_model="numpy", _nrt=False, fastmath={"contract"})
def faces_gradient(screen, colours, faces, planes, sides, plane_gradients, screen_gradient, colour_gradient):
    """Adjoint of `coverage.set_up_faces`: from planes to vertices [V, 3] and colours [V, C], which are added to.

    A plane through three corner values a_i is Σ_i a_i b_i, with b_i the barycentric coordinates; moving corner i on the
    screen by δ changes it by -(slope · δ) b_i.
    """
    channels = colours.shape[1]
    for f in range(faces.shape[0]):
        if sides[f, 0] == 0:
            continue
        used, linear = False, False
        for channel in range(1 + 2 * channels):
            for k in range(3):
                used |= plane_gradients[f, channel, k] != 0.0
                linear |= (plane_gradients[f, channel, k] != 0.0) & (channel > channels)
        if not used:
            continue
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x0, y0 = np.float64(screen[i, 0]), np.float64(screen[i, 1])
        x1, y1 = screen[j, 0] - x0, screen[j, 1] - y0
        x2, y2 = screen[k, 0] - x0, screen[k, 1] - y0
        thin, per_area = is_thin(x1, y1, x2, y2), 1.0 / (x1 * y2 - x2 * y1)
        for corner in range(3):
            v = faces[f, corner]
            if corner == 0:
                along_x, along_y = (y1 - y2) * per_area, (x2 - x1) * per_area
                constant = 1.0 - along_x * x0 - along_y * y0
            elif corner == 1:
                along_x, along_y = y2 * per_area, -x2 * per_area
                constant = -along_x * x0 - along_y * y0
            else:
                along_x, along_y = -y1 * per_area, x1 * per_area
                constant = -along_x * x0 - along_y * y0
            to_x, to_y, to_depth, depth = 0.0, 0.0, 0.0, np.float64(screen[v, 2])
            for channel in range(1 + 2 * channels if linear else 1 + channels):
                to_value = (
                    plane_gradients[f, channel, 0] * constant
                    + plane_gradients[f, channel, 1] * along_x
                    + plane_gradients[f, channel, 2] * along_y
                )
                to_x += to_value * planes[f, channel, 1]
                to_y += to_value * planes[f, channel, 2]
                if channel == 0:
                    to_depth += to_value
                    continue
                c = channel - 1 if channel <= channels else channel - 1 - channels
                if channel <= channels:
                    colour = (colours[i, c] + colours[j, c] + colours[k, c]) / 3.0 if thin else colours[v, c]
                    to_depth += to_value * colour
                    to_value *= depth
                if thin:
                    colour_gradient[i, c] += to_value / 3.0
                    colour_gradient[j, c] += to_value / 3.0
                    colour_gradient[k, c] += to_value / 3.0
                else:
                    colour_gradient[v, c] += to_value
            screen_gradient[v, 0] -= to_x
            screen_gradient[v, 1] -= to_y
            screen_gradient[v, 2] += to_depth
