"""Perspective-correct Gouraud colours at pixel centres, and their adjoint.

The colour of a face at a point is N_c / w, both planes of the face (`coverage.set_up_faces`). Gradients are gathered
per plane and turned into gradients of vertices and colours once per face.
"""

import numpy as np
from numba import njit

from rasteriser.coverage import LANES, NOTHING, is_thin, pixels_between


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, fastmath={"contract"})
def add_interior(planes, boxes, seen, visible, width, depth, picture):
    """Adds the colour at each covered pixel centre to picture [C, H, W + LANES]; depth [LANES] is scratch."""
    channels, height = picture.shape[0], picture.shape[1]
    for f in range(len(seen)):
        if not seen[f]:
            continue
        first_x, last_x = pixels_between(boxes[f, 0], boxes[f, 1], width)
        first_y, last_y = pixels_between(boxes[f, 2], boxes[f, 3], height)
        for iy in range(first_y, last_y):
            y = iy + 0.5
            row = planes[f, 0, 0] + planes[f, 0, 2] * y
            slope = planes[f, 0, 1]
            for start in range(first_x, last_x, LANES):
                there = visible[iy, start : start + LANES]
                for lane in range(LANES):
                    depth[lane] = 1.0 / (row + slope * (start + lane + 0.5)) if there[lane] == f else 0.0
                for c in range(channels):
                    value, along = planes[f, 1 + c, 0] + planes[f, 1 + c, 2] * y, planes[f, 1 + c, 1]
                    out = picture[c, iy, start : start + LANES]
                    for lane in range(LANES):
                        out[lane] += (value + along * (start + lane + 0.5)) * depth[lane]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, fastmath={"contract"})
def interior_gradient(planes, box, nearest, visible, picture_gradient, plane_gradients):
    """Adjoint of `add_interior`; plane_gradients [F, 1 + 2C, 3] is added to. Sums along runs of one face first."""
    channels = picture_gradient.shape[0]
    left, top, right, bottom = box
    for iy in range(top, bottom):
        y, start = iy + 0.5, left
        while start < right:
            face, end = visible[iy, start], start + 1
            while end < right and visible[iy, end] == face:
                end += 1
            if face != NOTHING:
                to_depth, to_depth_x = 0.0, 0.0
                for c in range(channels):
                    value, along = planes[face, 1 + c, 0] + planes[face, 1 + c, 2] * y, planes[face, 1 + c, 1]
                    total, total_x = 0.0, 0.0
                    for ix in range(start, end):
                        x, depth = ix + 0.5, 1.0 / nearest[iy, ix]
                        to_numerator = picture_gradient[c, iy, ix] * depth
                        total += to_numerator
                        total_x += to_numerator * x
                        part = to_numerator * (value + along * x) * depth
                        to_depth -= part
                        to_depth_x -= part * x
                    plane_gradients[face, 1 + c, 0] += total
                    plane_gradients[face, 1 + c, 1] += total_x
                    plane_gradients[face, 1 + c, 2] += total * y
                plane_gradients[face, 0, 0] += to_depth
                plane_gradients[face, 0, 1] += to_depth_x
                plane_gradients[face, 0, 2] += to_depth * y
            start = end


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
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
