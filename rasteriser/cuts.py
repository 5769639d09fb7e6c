"""Where segments of `rasteriser.segments` cut one another: there the piece that is seen may end."""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import NOTHING
from rasteriser.grid import grid_over, meet_first_in, sort_into_cells

# Segments that meet within this share of their length from an end do not cut each other there.
INTERIOR = 1e-9
# Segments at a smaller angle than this, in radians, do not cut each other.
PARALLEL = 1e-6


@kernel(error_model="numpy", _nrt=False)
def segment_boxes(ends, count, boxes):
    """Writes each segment's least and greatest x and y; returns the mean of their larger sides."""
    total = 0.0
    for s in range(count):
        boxes[s, 0], boxes[s, 1] = min(ends[s, 0], ends[s, 2]), max(ends[s, 0], ends[s, 2])
        boxes[s, 2], boxes[s, 3] = min(ends[s, 1], ends[s, 3]), max(ends[s, 1], ends[s, 3])
        total += max(boxes[s, 1] - boxes[s, 0], boxes[s, 3] - boxes[s, 2])
    return total / max(count, 1)


@kernel(error_model="numpy", _nrt=False)
def add_cuts(ends, grid, spans, starts, items, rows, near, heads, links, places):
    """Chains up where segments cut one another; the grid holds the segments. Returns how many cuts there are; those for
    which there is no room are only counted. rows [5, N] and near [N], N as many as the fullest cell holds, are
    scratch."""
    heads[:] = NOTHING
    x, y, along_x, along_y, square = rows[0], rows[1], rows[2], rows[3], rows[4]
    total = 0
    for cell in range(grid[3] * grid[4]):
        first, count = starts[cell], starts[cell + 1] - starts[cell]
        for k in range(count):
            s = items[first + k]
            x[k], y[k] = ends[s, 0], ends[s, 1]
            along_x[k], along_y[k] = ends[s, 2] - ends[s, 0], ends[s, 3] - ends[s, 1]
            square[k] = along_x[k] * along_x[k] + along_y[k] * along_y[k]
        for k in range(count):
            # A first look without divisions and branches, many at a time, with twice the margin of the second.
            for m in range(k + 1, count):
                determinant = along_x[k] * along_y[m] - along_y[k] * along_x[m]
                size, turn = abs(determinant), np.copysign(1.0, determinant)
                t = ((x[m] - x[k]) * along_y[m] - (y[m] - y[k]) * along_x[m]) * turn
                u = ((x[m] - x[k]) * along_y[k] - (y[m] - y[k]) * along_x[k]) * turn
                low, high = -2.0 * INTERIOR * size, (1.0 + 2.0 * INTERIOR) * size
                near[m] = (
                    (determinant * determinant > PARALLEL * PARALLEL * (square[k] * square[m]))
                    & (t >= low) & (t <= high) & (u >= low) & (u <= high)
                )  # fmt: skip
            for m in range(k + 1, count):
                if not near[m]:
                    continue
                a, b = items[first + k], items[first + m]
                determinant = along_x[k] * along_y[m] - along_y[k] * along_x[m]
                t = ((x[m] - x[k]) * along_y[m] - (y[m] - y[k]) * along_x[m]) / determinant
                u = ((x[m] - x[k]) * along_y[k] - (y[m] - y[k]) * along_x[k]) / determinant
                if not (-INTERIOR <= t <= 1.0 + INTERIOR and -INTERIOR <= u <= 1.0 + INTERIOR):
                    continue
                if not meet_first_in(spans, a, b, cell % grid[3], cell // grid[3]):
                    continue
                for which in range(2):
                    own, other, place = (a, b, t) if which == 0 else (b, a, u)
                    if INTERIOR < place < 1.0 - INTERIOR:
                        if total < len(links):
                            links[total, 0], links[total, 1], places[total] = other, heads[own], place
                            heads[own] = total
                        total += 1
    return total


@kernel(error_model="numpy")
def cuts_between(ends, count, box):
    """(heads, links, places, total): segment s is cut at places[k] (0 at its start, 1 at its end) by the segment
    links[k, 0], for k = heads[s], then links[k, 1], and so on until NOTHING."""
    boxes = np.empty((count, 4))
    extent = segment_boxes(ends, count, boxes)
    # In cells twice as large as a segment few of them lie in several.
    area = float(box[2] - box[0]) * float(box[3] - box[1])
    grid = grid_over(box, min(count, int(area / (2.0 * extent) ** 2)) if extent > 0.0 else count)
    spans, starts, items = sort_into_cells(boxes, count, grid)
    fullest = 0
    for cell in range(grid[3] * grid[4]):
        fullest = max(fullest, starts[cell + 1] - starts[cell])
    rows, near = np.empty((5, fullest)), np.empty(fullest, np.bool_)
    room = 8 * count + 64
    heads, links, places = np.empty(count, np.int32), np.empty((room, 2), np.int32), np.empty(room)
    total = add_cuts(ends, grid, spans, starts, items, rows, near, heads, links, places)
    if total > len(links):
        links, places = np.empty((total, 2), np.int32), np.empty(total)
        add_cuts(ends, grid, spans, starts, items, rows, near, heads, links, places)
    return heads, links, places, total
