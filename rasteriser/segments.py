"""The straight stretches of the screen along which what is seen may change: contours, creases, and lines where faces
interpenetrate. `rasteriser.cuts` finds where they cut one another.

A segment is a row of `ends` [S, 4] (x and y of its start, then of its end) and of `codes` [S, 5]: its edge, or CROSSING
for two faces that interpenetrate; those two faces, or the one or two at the edge; for a crossing, the edges at which it
starts and ends.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import NOTHING
from rasteriser.grid import meet_first_in

CROSSING = -1
# Inverse depths that differ by less than this share of the greatest are the same.
SAME_DEPTH = 1e-9
# Crossings shorter than this, in pixels, are rounding.
SHORTEST = 1e-6


@kernel(error_model="numpy", _nrt=False, inline="always")
def is_border(edge, edge_faces, planes, edge_sides, channels, crease):
    """Whether an edge is a contour, its surface on one side of it only, or a crease, where the colour's change per
    pixel jumps by `crease` or more."""
    bend = -1.0
    if edge_sides[edge, 0] * edge_sides[edge, 1] < 0 and crease < np.inf:
        f, g = edge_faces[edge, 0], edge_faces[edge, 1]
        for channel in range(1 + channels, 1 + 2 * channels):
            bend_x, bend_y = (
                planes[f, channel, 1] - planes[g, channel, 1],
                planes[f, channel, 2] - planes[g, channel, 2],
            )
            bend = max(bend, bend_x * bend_x + bend_y * bend_y)
    return (edge_sides[edge, 0] + edge_sides[edge, 1] != 0) | (bend >= crease * crease)


@kernel(error_model="numpy", _nrt=False)
def border_segments(screen, edges, edge_faces, planes, edge_sides, channels, crease, width, height, ends, codes):
    """Writes the contours and creases that touch the picture; returns how many."""
    count = 0
    for edge in range(edges.shape[0]):
        i, j = edges[edge, 0], edges[edge, 1]
        x0, y0, x1, y1 = screen[i, 0], screen[i, 1], screen[j, 0], screen[j, 1]
        outside = (max(x0, x1) < 0) | (min(x0, x1) > width) | (max(y0, y1) < 0) | (min(y0, y1) > height)
        empty = (x0 == x1) & (y0 == y1)
        if is_border(edge, edge_faces, planes, edge_sides, channels, crease) & (not (outside | empty)):
            ends[count, 0], ends[count, 1], ends[count, 2], ends[count, 3] = x0, y0, x1, y1
            codes[count, 0], codes[count, 1], codes[count, 2] = edge, edge_faces[edge, 0], edge_faces[edge, 1]
            count += 1
    return count


@kernel(error_model="numpy", _nrt=False, inline="always")
def pierces(screen, faces, planes, f, g, margin):
    """Whether corners of face g lie on both sides of face f's plane."""
    above = below = False
    p, q, r = planes[f, 0, 0], planes[f, 0, 1], planes[f, 0, 2]
    for corner in range(3):
        v = faces[g, corner]
        height = screen[v, 2] - (p + q * screen[v, 0] + r * screen[v, 1])
        above |= height > margin
        below |= height < -margin
    return above & below


@kernel(error_model="numpy", _nrt=False, inline="always")
def shared_corners(faces, f, g):
    shared = 0
    for corner in range(3):
        v = faces[f, corner]
        shared += (v == faces[g, 0]) + (v == faces[g, 1]) + (v == faces[g, 2])
    return shared


@kernel(error_model="numpy", _nrt=False)
def crossing_of(face_edges, lines, planes, sides, f, g):
    """(x0, y0, x1, y1, edge at the start, edge at the end, length) of the line where two faces' planes meet, inside
    both; a length that is not positive means that there is none."""
    a, b = planes[f, 0, 1] - planes[g, 0, 1], planes[f, 0, 2] - planes[g, 0, 2]
    c = planes[f, 0, 0] - planes[g, 0, 0]
    square = a * a + b * b
    foot_x, foot_y = -c * a / square, -c * b / square
    along_x, along_y = -b / np.sqrt(square), a / np.sqrt(square)
    first, last, first_edge, last_edge = -np.inf, np.inf, NOTHING, NOTHING
    for which in range(2):
        face = f if which == 0 else g
        for corner in range(3):
            edge = face_edges[face, corner]
            side = np.float64(sides[face, corner])
            rate = side * (lines[edge, 0] * along_x + lines[edge, 1] * along_y)
            at_foot = side * (lines[edge, 0] * foot_x + lines[edge, 1] * foot_y + lines[edge, 2])
            if rate == 0.0:
                if at_foot < 0.0:
                    last = -np.inf
            elif rate > 0.0:
                if -at_foot / rate > first:
                    first, first_edge = -at_foot / rate, edge
            elif -at_foot / rate < last:
                last, last_edge = -at_foot / rate, edge
    return (
        foot_x + first * along_x, foot_y + first * along_y, foot_x + last * along_x, foot_y + last * along_y,
        first_edge, last_edge, last - first,
    )  # fmt: skip


@kernel(error_model="numpy", _nrt=False)
def add_crossings(
    screen, faces, face_edges, lines, planes, sides, boxes, grid, spans, starts, items, candidates, ends, codes, count
):
    """Appends the lines where faces that share no edge interpenetrate; the grid holds the faces. Returns how many
    segments there are then; those for which there is no room are only counted."""
    columns, rows, margin = grid[3], grid[4], 0.0
    for v in range(screen.shape[0]):
        margin = max(margin, SAME_DEPTH * screen[v, 2])
    for row in range(rows):
        for column in range(columns):
            cell = row * columns + column
            for k in range(starts[cell], starts[cell + 1]):
                f, near_count = items[k], 0
                # Without branches: nobody could predict them.
                for m in range(k + 1, starts[cell + 1]):
                    g = items[m]
                    near = (boxes[f, 4] <= boxes[g, 5]) & (boxes[g, 4] <= boxes[f, 5])
                    near &= (boxes[f, 0] <= boxes[g, 1]) & (boxes[g, 0] <= boxes[f, 1])
                    near &= (boxes[f, 2] <= boxes[g, 3]) & (boxes[g, 2] <= boxes[f, 3])
                    near &= meet_first_in(spans, f, g, column, row)
                    candidates[near_count] = g
                    near_count += near
                for m in range(near_count):
                    g = candidates[m]
                    crossed = pierces(screen, faces, planes, f, g, margin) & pierces(
                        screen, faces, planes, g, f, margin
                    )
                    if not crossed or shared_corners(faces, f, g) > 1:
                        continue
                    x0, y0, x1, y1, start, end, length = crossing_of(face_edges, lines, planes, sides, f, g)
                    if length > SHORTEST:
                        count += 1
                        if count > len(ends):
                            continue
                        last = count - 1
                        ends[last, 0], ends[last, 1], ends[last, 2], ends[last, 3] = x0, y0, x1, y1
                        codes[last, 0], codes[last, 1], codes[last, 2] = CROSSING, f, g
                        codes[last, 3], codes[last, 4] = start, end
    return count


@kernel(error_model="numpy")
def find_segments(
    screen, faces, edges, edge_faces, face_edges, lines, planes, sides, edge_sides, boxes, channels, crease,
    width, height, grid, spans, starts, items,
):  # fmt: skip
    """(ends, codes, count) of all contours, creases and crossings; of contours alone where crease is infinite. The grid
    holds the faces."""
    room = len(edges) + 64
    ends, codes = np.empty((room, 4)), np.empty((room, 5), np.int32)
    borders = border_segments(
        screen, edges, edge_faces, planes, edge_sides, channels, crease, width, height, ends, codes
    )
    if crease == np.inf:
        return ends, codes, borders
    candidates = np.empty(len(faces), np.int32)
    while True:
        count = add_crossings(
            screen, faces, face_edges, lines, planes, sides, boxes, grid, spans, starts, items, candidates,
            ends, codes, borders,
        )  # fmt: skip
        if count <= room:
            return ends, codes, count
        room = count
        more_ends, more_codes = np.empty((room, 4)), np.empty((room, 5), np.int32)
        more_ends[:borders], more_codes[:borders] = ends[:borders], codes[:borders]
        ends, codes = more_ends, more_codes
