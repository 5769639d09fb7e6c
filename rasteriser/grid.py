"""A uniform grid over the picture that finds what lies near what: which faces cover a point, which segments meet."""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import NOTHING, TIE
from rasteriser.vectors import all_set_above, all_set_below, beside, last_above, last_below, load_twice

# Boxes count as larger by this much, in pixels, so that rounding hides no neighbour.
MARGIN = 1e-3


@kernel(error_model="numpy", _nrt=False)
def grid_over(box, count):
    """(left, top, size, columns, rows): square cells over a box of pixels, about as many as there are things to put
    into them."""
    width, height = box[2] - box[0], box[3] - box[1]
    if width <= 0 or height <= 0:
        return np.float64(box[0]), np.float64(box[1]), 1.0, 1, 1
    size = np.sqrt(width * height / max(count, 1))
    columns, rows = max(int(np.ceil(width / size)), 1), max(int(np.ceil(height / size)), 1)
    return np.float64(box[0]), np.float64(box[1]), size, columns, rows


@kernel(error_model="numpy", _nrt=False)
def cell_range(lowest, highest, per_pixel, cells):
    """Cells, the last included, that an interval touches; first > last where it lies outside the grid."""
    low, high = (lowest - MARGIN) * per_pixel, (highest + MARGIN) * per_pixel
    if not (high >= 0.0 and low <= cells):
        return 1, 0
    return int(min(max(low, 0.0), cells - 1.0)), int(min(max(high, 0.0), cells - 1.0))


@kernel(error_model="numpy", _nrt=False)
def count_per_cell(boxes, count, grid, spans, starts):
    """Writes the cells that each box touches to spans [>= count, 4], and how many boxes touch each cell, summed up, to
    starts [cells + 1]; returns the total. boxes [>= count, >= 4]: least and greatest x, least and greatest y."""
    left, top, size, columns, rows = grid
    starts[:] = 0
    per_pixel = 1.0 / size
    for n in range(count):
        spans[n, 0], spans[n, 1] = cell_range(boxes[n, 0] - left, boxes[n, 1] - left, per_pixel, columns)
        spans[n, 2], spans[n, 3] = cell_range(boxes[n, 2] - top, boxes[n, 3] - top, per_pixel, rows)
        for row in range(spans[n, 2], spans[n, 3] + 1):
            for column in range(spans[n, 0], spans[n, 1] + 1):
                starts[row * columns + column] += 1
    total = 0
    for cell in range(columns * rows + 1):
        total += starts[cell]
        starts[cell] = total
    return total


@kernel(error_model="numpy", _nrt=False)
def fill_cells(spans, count, columns, starts, items):
    """Turns starts into where each cell's items start: cell k, counted row by row, then holds items[starts[k] :
    starts[k + 1]], in increasing order."""
    for n in range(count - 1, -1, -1):
        for row in range(spans[n, 2], spans[n, 3] + 1):
            for column in range(spans[n, 0], spans[n, 1] + 1):
                starts[row * columns + column] -= 1
                items[starts[row * columns + column]] = n


@kernel(error_model="numpy")
def sort_into_cells(boxes, count, grid):
    """(spans, starts, items): the cells that each box touches, and the boxes that touch each cell, as
    `count_per_cell` and `fill_cells` say."""
    spans, starts = np.empty((count, 4), np.int32), np.empty(grid[3] * grid[4] + 1, np.int32)
    items = np.empty(count_per_cell(boxes, count, grid, spans, starts), np.int32)
    fill_cells(spans, count, grid[3], starts, items)
    return spans, starts, items


@kernel(error_model="numpy", _nrt=False, inline="always")
def meet_first_in(spans, a, b, column, row):
    """Whether a cell that holds two boxes is the first, from the top left, of those that do."""
    return (max(spans[a, 0], spans[b, 0]) == column) & (max(spans[a, 2], spans[b, 2]) == row)


@kernel(error_model="numpy", _nrt=False, inline="always")
def nearest_faces(grid, starts, items, covers, x, y, step_x, step_y):
    """The faces seen at two points: a small step back from (x, y), and the same step ahead."""
    left, top, size, columns, rows = grid
    column, row = min(max(int((x - left) / size), 0), columns - 1), min(max(int((y - top) / size), 0), rows - 1)
    cell = row * columns + column
    behind, ahead, least_behind, least_ahead = NOTHING, NOTHING, 0.0, 0.0
    # The point behind in the lower lanes, that ahead in the upper ones.
    xs, ys = beside(x - step_x, x + step_x), beside(y - step_y, y + step_y)
    # Without branches: nobody could predict them.
    for k in range(starts[cell], starts[cell + 1]):
        f = items[k]
        face = covers[f]
        values = load_twice(face, 0) * xs + (load_twice(face, 4) * ys + load_twice(face, 8))
        inside = values >= load_twice(face, 12)
        back = last_below(values) if all_set_below(inside) else 0.0
        on = last_above(values) if all_set_above(inside) else 0.0
        behind, ahead = f if back > least_behind else behind, f if on > least_ahead else ahead
        # The next comparison waits for these alone.
        back, on = back * TIE, on * TIE
        least_behind = back if back > least_behind else least_behind
        least_ahead = on if on > least_ahead else least_ahead
    return behind, ahead


@kernel(error_model="numpy", _nrt=False, inline="always")
def is_hidden_by(face, f, g, covers, x, y, step_x, step_y):
    """Whether a face hides faces f and g at both points of `nearest_faces`, so that it would return neither.

    g may be NOTHING. Also false of a face that is one of the two.
    """
    hider, first, second = covers[face], covers[f], covers[f if g == NOTHING else g]
    xs, ys = beside(x - step_x, x + step_x), beside(y - step_y, y + step_y)
    values = load_twice(hider, 0) * xs + (load_twice(hider, 4) * ys + load_twice(hider, 8))
    inside = values >= load_twice(hider, 12)
    # Twice the margin of `nearest_faces`, against rounding.
    depth_f = first[3] * x + (first[7] * y + first[11]) + abs(first[3] * step_x + first[7] * step_y)
    depth_g = second[3] * x + (second[7] * y + second[11]) + abs(second[3] * step_x + second[7] * step_y)
    nearer = min(last_below(values), last_above(values)) > max(depth_f, depth_g) * (TIE * TIE)
    return all_set_below(inside) & all_set_above(inside) & nearer
