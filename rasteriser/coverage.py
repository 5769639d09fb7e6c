"""Which face each pixel centre sees.

Everything here is linear on the screen. A *line* (a, b, c) is the function a·x + b·y + c that vanishes on an edge; it
is computed once per edge from its vertices in a fixed order, so that the two faces at an edge take bit-identical
decisions on which side a point lies. A *plane* (p, q, r) is p + q·x + r·y.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.vectors import LANES, load, ramp, select, store

# Twice the area below which a face is nothing, in squared pixels.
SMALLEST_DOUBLED_AREA = 1e-12
NOTHING = -1
# Faces of less height than this, in pixels, are painted in their mean colour: across them, colours change too fast.
THIN = 5e-2
# A face must be nearer by this factor than those before it: coplanar faces then tie whatever the rounding.
TIE = 1.0 + 1e-12
SMALLEST_NORMAL = 2.3e-308


@kernel(error_model="numpy", _nrt=False, inline="always")
def line_value(lines, edge, x, y):
    return lines[edge, 0] * x + lines[edge, 1] * y + lines[edge, 2]


@kernel(error_model="numpy", _nrt=False, inline="always")
def plane_value(planes, face, channel, x, y):
    return planes[face, channel, 0] + planes[face, channel, 1] * x + planes[face, channel, 2] * y


@kernel(error_model="numpy", _nrt=False)
def set_up_edges(screen, edges, lines):
    """lines [E, 3] of the edges of one mesh; screen [V, 3] holds x, y, inverse depth."""
    for e in range(edges.shape[0]):
        xi, yi = np.float64(screen[edges[e, 0], 0]), np.float64(screen[edges[e, 0], 1])
        xj, yj = np.float64(screen[edges[e, 1], 0]), np.float64(screen[edges[e, 1], 1])
        lines[e, 0] = yj - yi
        lines[e, 1] = xi - xj
        lines[e, 2] = xj * yi - xi * yj


@kernel(error_model="numpy", _nrt=False, inline="always")
def is_thin(x1, y1, x2, y2):
    """Whether a triangle's height is below THIN; its corners are (0, 0), (x1, y1) and (x2, y2)."""
    longest = max(x1 * x1 + y1 * y1, x2 * x2 + y2 * y2, (x2 - x1) * (x2 - x1) + (y2 - y1) * (y2 - y1))
    area = x1 * y2 - x2 * y1
    return area * area < THIN * THIN * longest


@kernel(error_model="numpy", _nrt=False)
def set_up_faces(screen, faces, edge_faces, face_edges, lines, planes, sides, edge_sides, boxes, covers):
    """What is known of a face before any pixel is visited.

    planes [F, 1 + 2C, 3]: inverse depth w first; those of colours are left to `set_up_colours`. sides [F, 3]: on which
    side of each edge the face lies (+1 or -1, all 0 for a face without area). edge_sides [E, 2]: the same, seen from
    the edge. boxes [F, 6]: least and greatest x, y and w; least above greatest for a face without area. covers [F, 16]:
    the four functions that decide what a face covers, its three lines, signed so that they are positive inside, and w:
    their slopes along x, along y, their constants, and their least values where it covers a point.
    """
    for e in range(edge_sides.shape[0]):
        edge_sides[e, 0] = edge_sides[e, 1] = 0
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x0, y0, w0 = np.float64(screen[i, 0]), np.float64(screen[i, 1]), np.float64(screen[i, 2])
        x1, y1, w1 = screen[j, 0] - x0, screen[j, 1] - y0, np.float64(screen[j, 2])
        x2, y2, w2 = screen[k, 0] - x0, screen[k, 1] - y0, np.float64(screen[k, 2])
        area = x1 * y2 - x2 * y1
        if not abs(area) > SMALLEST_DOUBLED_AREA:
            sides[f, 0] = sides[f, 1] = sides[f, 2] = 0
            boxes[f, 0] = boxes[f, 2] = boxes[f, 4] = np.inf
            boxes[f, 1] = boxes[f, 3] = boxes[f, 5] = -np.inf
            continue
        boxes[f, 0], boxes[f, 1] = x0 + min(0.0, x1, x2), x0 + max(0.0, x1, x2)
        boxes[f, 2], boxes[f, 3] = y0 + min(0.0, y1, y2), y0 + max(0.0, y1, y2)
        boxes[f, 4], boxes[f, 5] = min(w0, w1, w2), max(w0, w1, w2)
        for corner in range(3):
            v = faces[f, corner]
            edge = face_edges[f, corner]
            beyond = line_value(lines, edge, np.float64(screen[v, 0]), np.float64(screen[v, 1]))
            sides[f, corner] = 1 if beyond >= 0 else -1
            edge_sides[edge, 0 if edge_faces[edge, 0] == f else 1] = sides[f, corner]
            side = np.float64(sides[f, corner])
            for term in range(3):
                covers[f, 4 * term + corner] = side * lines[edge, term]
            # A point on the edge belongs to the face on its positive side.
            covers[f, 12 + corner] = 0.0 if beyond >= 0 else SMALLEST_NORMAL
        set_plane(planes, f, 0, x0, y0, x1, y1, x2, y2, 1.0 / area, w0, w1, w2)
        covers[f, 3], covers[f, 7], covers[f, 11] = planes[f, 0, 1], planes[f, 0, 2], planes[f, 0, 0]
        covers[f, 15] = 0.0


@kernel(error_model="numpy", _nrt=False, inline="always")
def set_plane(planes, face, channel, x0, y0, x1, y1, x2, y2, inverse_area, a0, a1, a2):
    """The plane through three values at a face's corners, which are (x0, y0), and (x1, y1) and (x2, y2) from there."""
    a1 -= a0
    a2 -= a0
    along_x = (a1 * y2 - a2 * y1) * inverse_area
    along_y = (a2 * x1 - a1 * x2) * inverse_area
    planes[face, channel, 0] = a0 - along_x * x0 - along_y * y0
    planes[face, channel, 1] = along_x
    planes[face, channel, 2] = along_y


@kernel(error_model="numpy", _nrt=False)
def set_up_colours(screen, colours, faces, sides, seen, bordering, planes):
    """The planes of colours, of faces with area that are `seen` or `bordering` [1 + F, face f at f + 1]: w · colour for
    each channel; and, of the latter, the colour itself, as if it were linear on the screen."""
    channels = colours.shape[1]
    for f in range(faces.shape[0]):
        if (sides[f, 0] == 0) | (not (seen[f + 1] | bordering[f + 1])):
            continue
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x0, y0, w0 = np.float64(screen[i, 0]), np.float64(screen[i, 1]), np.float64(screen[i, 2])
        x1, y1, w1 = screen[j, 0] - x0, screen[j, 1] - y0, np.float64(screen[j, 2])
        x2, y2, w2 = screen[k, 0] - x0, screen[k, 1] - y0, np.float64(screen[k, 2])
        thin, inverse_area = is_thin(x1, y1, x2, y2), 1.0 / (x1 * y2 - x2 * y1)
        for c in range(channels):
            c0, c1, c2 = np.float64(colours[i, c]), np.float64(colours[j, c]), np.float64(colours[k, c])
            if thin:
                c0 = c1 = c2 = (c0 + c1 + c2) / 3.0
            set_plane(planes, f, 1 + c, x0, y0, x1, y1, x2, y2, inverse_area, w0 * c0, w1 * c1, w2 * c2)
            if bordering[f + 1]:
                set_plane(planes, f, 1 + channels + c, x0, y0, x1, y1, x2, y2, inverse_area, c0, c1, c2)


@kernel(error_model="numpy", _nrt=False)
def pixels_between(lowest, highest, size):
    """The range of pixels of a picture whose centres lie in [lowest, highest]; the end is exclusive."""
    first = int(np.ceil(min(max(lowest - 0.5, 0.0), np.float64(size))))
    last = int(np.floor(min(max(highest - 0.5, -1.0), size - 1.0)))
    return first, last + 1


@kernel(error_model="numpy", _nrt=False)
def bounding_box(screen, width, height):
    """(left, top, right, bottom) of the pixels that a mesh can touch; the right and bottom ends are exclusive."""
    left, top, right, bottom = np.inf, np.inf, -np.inf, -np.inf
    for v in range(screen.shape[0]):
        left, right = min(left, screen[v, 0]), max(right, screen[v, 0])
        top, bottom = min(top, screen[v, 1]), max(bottom, screen[v, 1])
    first_x, last_x = pixels_between(left - 0.5, right + 0.5, width)
    first_y, last_y = pixels_between(top - 0.5, bottom + 0.5, height)
    return first_x, first_y, max(first_x, last_x), max(first_y, last_y)


@kernel(error_model="numpy", _nrt=False, fastmath={"contract"})
def rasterise(covers, sides, boxes, box, width, depths, visible, seen):
    """visible [H, W + WIDE]: the face at each pixel centre inside `box` or NOTHING; depths: its depth, or 0;
    seen [1 + F]: whether face f is
    visible at any, at f + 1. Of faces at the same depth, up to rounding, the first wins."""
    left, top, right, bottom = box
    for iy in range(top, bottom):
        depths[iy, left : right + LANES] = 0.0
        visible[iy, left : right + LANES] = NOTHING
    seen[:] = False
    for f in range(len(covers)):
        if sides[f, 0] == 0:
            continue
        first_x, last_x = pixels_between(boxes[f, 0], boxes[f, 1], width)
        first_y, last_y = pixels_between(boxes[f, 2], boxes[f, 3], bottom)
        face = covers[f]
        a0, a1, a2, q = face[0], face[1], face[2], face[3]
        b0, b1, b2, r = face[4], face[5], face[6], face[7]
        c0, c1, c2, p = face[8], face[9], face[10], face[11]
        t0, t1, t2 = face[12], face[13], face[14]
        for iy in range(first_y, last_y):
            y = iy + 0.5
            k0, k1, k2, depth_row = b0 * y + c0, b1 * y + c1, b2 * y + c2, p + r * y
            # Inverse depths, at first.
            inverse, faces_there = depths[iy], visible[iy]
            for start in range(first_x, last_x, LANES):
                x, near = ramp(start + 0.5), load(inverse, start)
                depth = x * q + depth_row
                wins = (x * a0 + k0 >= t0) & (x * a1 + k1 >= t1) & (x * a2 + k2 >= t2) & (depth > near * TIE)
                store(inverse, start, select(wins, depth, near))
                store(faces_there, start, select(wins, f, load(faces_there, start)))
    for iy in range(top, bottom):
        faces_there, row = visible[iy], depths[iy]
        faces_there[width:] = NOTHING
        for ix in range(left, right):
            # Without branches: nobody could predict where one face ends. The place before the first is NOTHING's.
            seen[faces_there[ix] + 1] = True
        for start in range(left, right, LANES):
            near = load(row, start)
            store(row, start, select(near > 0.0, 1.0 / near, 0.0))
