"""Perspective-correct Gouraud colours at pixel centres, and their adjoint.

The colour of a face at a point is N_c / w, both planes of the face (`coverage.set_up_faces`). Gradients are gathered
per plane and turned into gradients of vertices and colours once per face.
"""

import numpy as np
from numba import njit

from rasteriser.coverage import NOTHING, plane_value


@njit(cache=True, nogil=True, error_model="numpy")
def add_interior(planes, visible, box, picture):
    """Adds the colour at each covered pixel centre to picture [C, H, W]."""
    channels, height, width = picture.shape
    left, top, right, bottom = box
    for iy in range(max(top, 0), min(bottom, height)):
        y = iy + 0.5
        for ix in range(max(left, 0), min(right, width)):
            face = visible[iy + 1, ix + 1]
            if face != NOTHING:
                x = ix + 0.5
                depth = 1.0 / plane_value(planes, face, 0, x, y)
                for c in range(channels):
                    picture[c, iy, ix] += plane_value(planes, face, 1 + c, x, y) * depth


@njit(cache=True, nogil=True, error_model="numpy")
def add_colour_gradient(planes, face, x, y, channel, gradient, plane_gradients):
    """Adjoint of the colour of a face at (x, y) with respect to the face's planes."""
    depth = 1.0 / plane_value(planes, face, 0, x, y)
    to_numerator = gradient * depth
    to_depth = -to_numerator * plane_value(planes, face, 1 + channel, x, y) * depth
    plane_gradients[face, 1 + channel, 0] += to_numerator
    plane_gradients[face, 1 + channel, 1] += to_numerator * x
    plane_gradients[face, 1 + channel, 2] += to_numerator * y
    plane_gradients[face, 0, 0] += to_depth
    plane_gradients[face, 0, 1] += to_depth * x
    plane_gradients[face, 0, 2] += to_depth * y


@njit(cache=True, nogil=True, error_model="numpy")
def interior_gradient(planes, visible, box, picture_gradient, plane_gradients):
    """Adjoint of `add_interior`; plane_gradients [F, 1 + C, 3] is added to."""
    channels, height, width = picture_gradient.shape
    left, top, right, bottom = box
    for iy in range(max(top, 0), min(bottom, height)):
        for ix in range(max(left, 0), min(right, width)):
            face = visible[iy + 1, ix + 1]
            if face != NOTHING:
                x, y = ix + 0.5, iy + 0.5
                depth = 1.0 / plane_value(planes, face, 0, x, y)
                to_depth = 0.0
                for c in range(channels):
                    to_numerator = picture_gradient[c, iy, ix] * depth
                    to_depth -= to_numerator * plane_value(planes, face, 1 + c, x, y) * depth
                    plane_gradients[face, 1 + c, 0] += to_numerator
                    plane_gradients[face, 1 + c, 1] += to_numerator * x
                    plane_gradients[face, 1 + c, 2] += to_numerator * y
                plane_gradients[face, 0, 0] += to_depth
                plane_gradients[face, 0, 1] += to_depth * x
                plane_gradients[face, 0, 2] += to_depth * y


@njit(cache=True, nogil=True, error_model="numpy")
def faces_gradient(screen, colours, faces, planes, sides, plane_gradients, screen_gradient, colour_gradient):
    """Adjoint of `coverage.set_up_faces`: from planes to vertices [V, 3] and colours [V, C], which are added to.

    A plane through three corner values a_i is Σ_i a_i b_i, with b_i the barycentric coordinates; moving corner i on the
    screen by δ changes it by -(slope · δ) b_i.
    """
    channels = colours.shape[1]
    for f in range(faces.shape[0]):
        if sides[f, 0] == 0:
            continue
        used = False
        for channel in range(1 + channels):
            used = used or plane_gradients[f, channel, 0] != 0.0 or plane_gradients[f, channel, 1] != 0.0
            used = used or plane_gradients[f, channel, 2] != 0.0
        if not used:
            continue
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x0, y0 = np.float64(screen[i, 0]), np.float64(screen[i, 1])
        x1, y1 = screen[j, 0] - x0, screen[j, 1] - y0
        x2, y2 = screen[k, 0] - x0, screen[k, 1] - y0
        area = x1 * y2 - x2 * y1
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
            for channel in range(1 + channels):
                to_value = (
                    plane_gradients[f, channel, 0] * constant
                    + plane_gradients[f, channel, 1] * along_x
                    + plane_gradients[f, channel, 2] * along_y
                )
                screen_gradient[v, 0] -= to_value * planes[f, channel, 1]
                screen_gradient[v, 1] -= to_value * planes[f, channel, 2]
                if channel == 0:
                    screen_gradient[v, 2] += to_value
                else:
                    screen_gradient[v, 2] += to_value * colours[v, channel - 1]
                    colour_gradient[v, channel - 1] += to_value * screen[v, 2]
