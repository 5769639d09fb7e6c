"""Which face each pixel centre sees.

Everything here is linear on the screen. A *line* (a, b, c) is the function a·x + b·y + c that vanishes on an edge; it
is computed once per edge from its vertices in a fixed order, so that the two faces at an edge, and the antialiasing
later, take bit-identical decisions on which side a point lies. A *plane* (p, q, r) is p + q·x + r·y.
"""

import numpy as np
from numba import njit

# Twice the area below which a face is nothing, in squared pixels.
SMALLEST_DOUBLED_AREA = 1e-12
NOTHING = -1
# Distance to an edge times its length, in squared pixels: far above rounding, far below anything seen.
BORDER = 1e-6
# A face must be nearer by this factor than those before it: coplanar faces then tie whatever the rounding.
TIE = 1.0 + 1e-9


@njit(cache=True, nogil=True, error_model="numpy")
def line_value(lines, edge, x, y):
    return lines[edge, 0] * x + lines[edge, 1] * y + lines[edge, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def plane_value(planes, face, channel, x, y):
    return planes[face, channel, 0] + planes[face, channel, 1] * x + planes[face, channel, 2] * y


@njit(cache=True, nogil=True, error_model="numpy")
def set_up_edges(screen, edges, lines):
    """lines [E, 3] of the edges of one mesh; screen [V, 3] holds x, y, inverse depth."""
    for e in range(edges.shape[0]):
        xi, yi = np.float64(screen[edges[e, 0], 0]), np.float64(screen[edges[e, 0], 1])
        xj, yj = np.float64(screen[edges[e, 1], 0]), np.float64(screen[edges[e, 1], 1])
        lines[e, 0] = yj - yi
        lines[e, 1] = xi - xj
        lines[e, 2] = xj * yi - xi * yj


@njit(cache=True, nogil=True, error_model="numpy")
def set_up_faces(screen, colours, faces, face_edges, lines, planes, sides):
    """planes [F, 1 + C, 3]: inverse depth w, then w · colour for each channel; sides [F, 3]: on which side of each edge
    the face lies (+1 or -1, all 0 for a face without area)."""
    channels = colours.shape[1]
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x0, y0 = np.float64(screen[i, 0]), np.float64(screen[i, 1])
        x1, y1 = screen[j, 0] - x0, screen[j, 1] - y0
        x2, y2 = screen[k, 0] - x0, screen[k, 1] - y0
        area = x1 * y2 - x2 * y1
        if not abs(area) > SMALLEST_DOUBLED_AREA:
            sides[f, 0] = 0
            sides[f, 1] = 0
            sides[f, 2] = 0
            continue
        for corner in range(3):
            v = faces[f, corner]
            beyond = line_value(lines, face_edges[f, corner], np.float64(screen[v, 0]), np.float64(screen[v, 1]))
            sides[f, corner] = 1 if beyond >= 0 else -1
        w0, w1, w2 = np.float64(screen[i, 2]), np.float64(screen[j, 2]), np.float64(screen[k, 2])
        for channel in range(1 + channels):
            a0, a1, a2 = w0, w1, w2
            if channel > 0:
                a0 *= colours[i, channel - 1]
                a1 *= colours[j, channel - 1]
                a2 *= colours[k, channel - 1]
            a1 -= a0
            a2 -= a0
            along_x = (a1 * y2 - a2 * y1) / area
            along_y = (a2 * x1 - a1 * x2) / area
            planes[f, channel, 0] = a0 - along_x * x0 - along_y * y0
            planes[f, channel, 1] = along_x
            planes[f, channel, 2] = along_y


@njit(cache=True, nogil=True, error_model="numpy")
def touches(lines, face_edges, sides, face, x, y):
    """Whether a face, its border included, covers a point. The border is a hair wider than it is, so that a point which
    was computed to lie on an edge is found there whatever the rounding."""
    for corner in range(3):
        if line_value(lines, face_edges[face, corner], x, y) * sides[face, corner] < -BORDER:
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def pixels_between(lowest, highest, start, stop):
    """The range of pixels within start..stop whose centres lie in [lowest, highest]; the end is exclusive."""
    first = int(np.ceil(min(max(lowest - 0.5, np.float64(start)), np.float64(stop))))
    last = int(np.floor(min(max(highest - 0.5, start - 1.0), stop - 1.0)))
    return first, last + 1


@njit(cache=True, nogil=True, error_model="numpy")
def bounding_box(screen, width, height):
    """(left, top, right, bottom) of the pixels whose centres a mesh can cover, with a margin of one pixel; the right
    and bottom ends are exclusive. Pixel indices run from -1 to width and height: a border of one pixel is kept."""
    left, top, right, bottom = np.float64(width), np.float64(height), 0.0, 0.0
    for v in range(screen.shape[0]):
        left, right = min(left, screen[v, 0]), max(right, screen[v, 0])
        top, bottom = min(top, screen[v, 1]), max(bottom, screen[v, 1])
    first_x, last_x = pixels_between(left - 1.5, right + 1.5, -1, width + 1)
    first_y, last_y = pixels_between(top - 1.5, bottom + 1.5, -1, height + 1)
    return first_x, first_y, last_x, last_y


@njit(cache=True, nogil=True, error_model="numpy")
def rasterise(screen, faces, face_edges, lines, planes, sides, box, nearest, visible):
    """visible [H + 2, W + 2]: the face at each pixel centre inside `box` or NOTHING; nearest: its inverse depth.

    Row and column 0 of both are pixel -1. Of faces at the same depth, up to rounding, the first wins.
    """
    left, top, right, bottom = box
    for y in range(top, bottom):
        for x in range(left, right):
            nearest[y + 1, x + 1] = 0.0
            visible[y + 1, x + 1] = NOTHING
    for f in range(faces.shape[0]):
        if sides[f, 0] == 0:
            continue
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        xi, xj, xk = np.float64(screen[i, 0]), np.float64(screen[j, 0]), np.float64(screen[k, 0])
        yi, yj, yk = np.float64(screen[i, 1]), np.float64(screen[j, 1]), np.float64(screen[k, 1])
        first_x, last_x = pixels_between(min(xi, xj, xk), max(xi, xj, xk), left, right)
        first_y, last_y = pixels_between(min(yi, yj, yk), max(yi, yj, yk), top, bottom)
        e0, e1, e2 = face_edges[f, 0], face_edges[f, 1], face_edges[f, 2]
        a0, b0, c0, s0 = lines[e0, 0], lines[e0, 1], lines[e0, 2], sides[f, 0] > 0
        a1, b1, c1, s1 = lines[e1, 0], lines[e1, 1], lines[e1, 2], sides[f, 1] > 0
        a2, b2, c2, s2 = lines[e2, 0], lines[e2, 1], lines[e2, 2], sides[f, 2] > 0
        p, q, r = planes[f, 0, 0], planes[f, 0, 1], planes[f, 0, 2]
        for iy in range(first_y, last_y):
            y = iy + 0.5
            for ix in range(first_x, last_x):
                x = ix + 0.5
                inside = (
                    ((a0 * x + b0 * y + c0 >= 0) == s0)
                    & ((a1 * x + b1 * y + c1 >= 0) == s1)
                    & ((a2 * x + b2 * y + c2 >= 0) == s2)
                )
                if inside:
                    depth = p + q * x + r * y
                    if depth > nearest[iy + 1, ix + 1] * TIE:
                        nearest[iy + 1, ix + 1] = depth
                        visible[iy + 1, ix + 1] = f
