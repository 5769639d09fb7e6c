"""Perspective-correct Gouraud colours at pixel centres, and their adjoint.

The colour of a face at a point is N_c / w, both planes of the face (`coverage.set_up_faces`). Gradients are gathered
per plane and turned into gradients of vertices and colours once per face.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import is_thin, pixels_between
from rasteriser.vectors import LANES, as_doubles, as_singles, load, ramp, select, store, total, zeros


@kernel(error_model="numpy", _nrt=False)
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


@kernel(error_model="numpy", _nrt=False)
def interior_gradient(planes, boxes, seen, visible, depths, width, picture_gradient, plane_gradients):
    """Adjoint of `add_interior`; plane_gradients [F, 1 + 2C, 3] is added to."""
    channels, height = picture_gradient.shape[0], picture_gradient.shape[1]
    for f in range(len(boxes)):
        if not seen[f + 1]:
            continue
        first_x, last_x = pixels_between(boxes[f, 0], boxes[f, 1], width)
        first_y, last_y = pixels_between(boxes[f, 2], boxes[f, 3], height)
        to_depth, to_depth_x, to_depth_y = zeros(), zeros(), zeros()
        for c in range(channels):
            to_value, to_value_x, to_value_y = zeros(), zeros(), zeros()
            along = planes[f, 1 + c, 1]
            for iy in range(first_y, last_y):
                y, there, behind, upstream = iy + 0.5, visible[iy], depths[iy], picture_gradient[c, iy]
                value = planes[f, 1 + c, 0] + planes[f, 1 + c, 2] * y
                for start in range(first_x, last_x, LANES):
                    x, depth = ramp(start + 0.5), select(load(there, start) == f, load(behind, start), 0.0)
                    part = as_doubles(load(upstream, start)) * depth
                    to_value = to_value + part
                    to_value_x = to_value_x + part * x
                    to_value_y = to_value_y + part * y
                    part = part * (x * along + value) * depth
                    to_depth = to_depth + part
                    to_depth_x = to_depth_x + part * x
                    to_depth_y = to_depth_y + part * y
            plane_gradients[f, 1 + c, 0] += total(to_value)
            plane_gradients[f, 1 + c, 1] += total(to_value_x)
            plane_gradients[f, 1 + c, 2] += total(to_value_y)
        plane_gradients[f, 0, 0] -= total(to_depth)
        plane_gradients[f, 0, 1] -= total(to_depth_x)
        plane_gradients[f, 0, 2] -= total(to_depth_y)


@kernel(error_model="numpy", _nrt=False)
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
        area, thin = x1 * y2 - x2 * y1, is_thin(x1, y1, x2, y2)
        for corner in range(3):
            v = faces[f, corner]
            if corner == 0:
                along_x, along_y = (y1 - y2) / area, (x2 - x1) / area
                constant = 1.0 - along_x * x0 - along_y * y0
            elif corner == 1:
                along_x, along_y = y2 / area, -x2 / area
                constant = -along_x * x0 - along_y * y0
            else:
                along_x, along_y = -y1 / area, x1 / area
                constant = -along_x * x0 - along_y * y0
            for channel in range(1 + 2 * channels if linear else 1 + channels):
                to_value = (
                    plane_gradients[f, channel, 0] * constant
                    + plane_gradients[f, channel, 1] * along_x
                    + plane_gradients[f, channel, 2] * along_y
                )
                screen_gradient[v, 0] -= to_value * planes[f, channel, 1]
                screen_gradient[v, 1] -= to_value * planes[f, channel, 2]
                if channel == 0:
                    screen_gradient[v, 2] += to_value
                    continue
                c = channel - 1 if channel <= channels else channel - 1 - channels
                if channel <= channels:
                    colour = (colours[i, c] + colours[j, c] + colours[k, c]) / 3.0 if thin else colours[v, c]
                    screen_gradient[v, 2] += to_value * colour
                    to_value *= screen[v, 2]
                if thin:
                    colour_gradient[i, c] += to_value / 3.0
                    colour_gradient[j, c] += to_value / 3.0
                    colour_gradient[k, c] += to_value / 3.0
                else:
                    colour_gradient[v, c] += to_value
