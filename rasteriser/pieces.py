"""Segments cut into pieces, each inside one pixel and seen along all of its length or nowhere."""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.coverage import NOTHING
from rasteriser.grid import is_hidden_by, nearest_faces
from rasteriser.segments import CROSSING

# What a piece's end lies on: a vertex of the mesh, a pixel boundary, an edge, or another segment.
AT_VERTEX, AT_COLUMN, AT_ROW, AT_EDGE, AT_SEGMENT = 0, 1, 2, 3, 4
# What is seen on either side of a piece is looked up this far from it, in pixels.
ASIDE = 1e-6


@kernel(error_model="numpy", _nrt=False, inline="always")
def cut_at_pixels(x0, y0, x1, y1, width, height, places, kinds, at):
    """Where, from 0 to 1 and in order, a segment enters, changes pixel in, and leaves the picture.

    kinds and at tell on which boundary each cut lies. Returns how many there are; fewer than two when the segment
    misses the picture. The first and the last are the segment's own ends, unless they lie outside.
    """
    dx, dy = x1 - x0, y1 - y0
    start, end = 0.0, 1.0
    kinds[0], at[0] = NOTHING, NOTHING
    last_kind, last_at = NOTHING, NOTHING
    for axis in range(2):
        origin, step, size = (x0, dx, width) if axis == 0 else (y0, dy, height)
        kind = AT_COLUMN if axis == 0 else AT_ROW
        if step == 0.0:
            if not 0.0 <= origin < size:
                return 0
            continue
        enter, leave = -origin / step, (size - origin) / step
        enter_at, leave_at = 0, size
        if enter > leave:
            enter, leave, enter_at, leave_at = leave, enter, size, 0
        if enter > start:
            start, kinds[0], at[0] = enter, kind, enter_at
        if leave < end:
            end, last_kind, last_at = leave, kind, leave_at
    if not start < end:
        return 0
    count = 1
    places[0] = start
    per_x, per_y = 1.0 / dx, 1.0 / dy
    # The next column and row boundary ahead of the start.
    column = int(np.floor(x0 + start * dx)) + (1 if dx > 0 else 0)
    row = int(np.floor(y0 + start * dy)) + (1 if dy > 0 else 0)
    step_column, step_row = 1 if dx > 0 else -1, 1 if dy > 0 else -1
    while True:
        at_column = (column - x0) * per_x if dx != 0.0 else np.inf
        at_row = (row - y0) * per_y if dy != 0.0 else np.inf
        place = min(at_column, at_row)
        if not place < end or count >= width + height + 6:
            break
        # Without branches: nobody could predict them.
        at_a_column = at_column <= at_row
        places[count], kinds[count] = place, AT_COLUMN if at_a_column else AT_ROW
        at[count] = column if at_a_column else row
        count += 1 if place > places[count - 1] else 0
        column += step_column if at_a_column else 0
        row += 0 if at_a_column else step_row
    places[count], kinds[count], at[count] = end, last_kind, last_at
    return count + 1


@kernel(error_model="numpy", _nrt=False, inline="always")
def insert_cut(places, kinds, at, count, place, segment):
    """Puts a cut by another segment in its place among the others; returns how many there are then."""
    if not places[0] < place < places[count - 1]:
        return count
    k = count
    while places[k - 1] > place:
        places[k], kinds[k], at[k] = places[k - 1], kinds[k - 1], at[k - 1]
        k -= 1
    places[k], kinds[k], at[k] = place, AT_SEGMENT, segment
    return count + 1


@kernel(error_model="numpy", _nrt=False)
def add_pieces_of_segments(
    edges, covers, grid, starts, items, ends, codes, segment_count,
    heads, links, link_places, width, height, places, kinds, at, points, piece_codes,
):  # fmt: skip
    """Writes the pieces as `find_pieces` says; returns how many there are. Those for which there is no room are only
    counted."""
    found, hider = 0, NOTHING
    for s in range(segment_count):
        x0, y0, x1, y1 = ends[s, 0], ends[s, 1], ends[s, 2], ends[s, 3]
        dx, dy = x1 - x0, y1 - y0
        count = cut_at_pixels(x0, y0, x1, y1, width, height, places, kinds, at)
        if count < 2:
            continue
        for end in range(2):
            k = 0 if end == 0 else count - 1
            if kinds[k] == NOTHING:
                if codes[s, 0] == CROSSING:
                    kinds[k], at[k] = AT_EDGE, codes[s, 3 + end]
                else:
                    kinds[k], at[k] = AT_VERTEX, edges[codes[s, 0], end]
        link = heads[s]
        while link != NOTHING:
            count = insert_cut(places, kinds, at, count, link_places[link], links[link, 0])
            link = links[link, 1]
        aside = ASIDE / np.sqrt(dx * dx + dy * dy)
        f, g, needed = codes[s, 1], codes[s, 2], 2 if codes[s, 0] == CROSSING else 1
        for k in range(count - 1):
            middle = 0.5 * (places[k] + places[k + 1])
            x, y = x0 + middle * dx, y0 + middle * dy
            ix, iy = min(max(int(x), 0), width - 1), min(max(int(y), 0), height - 1)
            # A step of ASIDE away from the pixel's centre.
            step_x, step_y = -dy * aside, dx * aside
            if step_x * (ix + 0.5 - x) + step_y * (iy + 0.5 - y) > 0.0:
                step_x, step_y = -step_x, -step_y
            # Most are hidden, and by the face that hid the one before.
            if hider != NOTHING and is_hidden_by(hider, f, g, covers, x, y, step_x, step_y):
                continue
            here, beyond = nearest_faces(grid, starts, items, covers, x, y, step_x, step_y)
            # Without branches where nobody could predict them: which of the two is NOTHING.
            own = (here != NOTHING) & ((here == f) | (here == g))
            own += (beyond != NOTHING) & ((beyond == f) | (beyond == g))
            if (here == beyond) | (own < needed):
                hider = here if (own == 0) & (here == beyond) else hider
                continue
            found += 1
            if found > len(points):
                continue
            last = found - 1
            points[last, 0] = x0 + places[k] * dx - ix - 0.5
            points[last, 1] = y0 + places[k] * dy - iy - 0.5
            points[last, 2] = x0 + places[k + 1] * dx - ix - 0.5
            points[last, 3] = y0 + places[k + 1] * dy - iy - 0.5
            piece_codes[last, 0], piece_codes[last, 1], piece_codes[last, 4] = ix, iy, s
            piece_codes[last, 2], piece_codes[last, 3] = here, beyond
            piece_codes[last, 5], piece_codes[last, 6] = kinds[k], at[k]
            piece_codes[last, 7], piece_codes[last, 8] = kinds[k + 1], at[k + 1]
    return found


@kernel(error_model="numpy")
def find_pieces(
    edges, covers, grid, starts, items, ends, codes, segment_count,
    heads, links, link_places, link_count, width, height,
):  # fmt: skip
    """(points, codes, count) of the pieces along which two faces meet in what is seen: both those of a crossing, or
    one of those at an edge.

    points [P, 7]: x and y of either end, from the centre of the piece's pixel; the others are left to
    `shadows.find_shadows`. codes [P, 9]: column and row of the pixel; the face seen on the centre's side of the piece
    and that beyond, or NOTHING; the segment; and, for either end, what it lies on: its kind, and which vertex,
    boundary, edge or segment.
    """
    room = width + height + 8 + link_count
    places, kinds, at = np.empty(room), np.empty(room, np.int32), np.empty(room, np.int32)
    room = 256 + 8 * segment_count
    while True:
        points, piece_codes = np.empty((room, 7)), np.empty((room, 9), np.int32)
        found = add_pieces_of_segments(
            edges, covers, grid, starts, items, ends, codes, segment_count,
            heads, links, link_places, width, height, places, kinds, at, points, piece_codes,
        )  # fmt: skip
        if found <= room:
            return points, piece_codes, found
        room = found
