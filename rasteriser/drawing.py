"""One mesh drawn by one thread, and the adjoint of that: all stages in a row."""

import numpy as np

from rasteriser.antialias import add_pieces, pieces_gradient
from rasteriser.compilation import kernel
from rasteriser.coverage import rasterise, set_up_colours, set_up_edges, set_up_faces
from rasteriser.cuts import cuts_between
from rasteriser.grid import grid_over, sort_into_cells
from rasteriser.pieces import find_pieces
from rasteriser.segments import find_segments
from rasteriser.shading import add_interior, faces_gradient, interior_gradient
from rasteriser.shadows import find_shadows
from rasteriser.vectors import WIDE


@kernel(error_model="numpy")
def workspace_for(vertex_count, topology, channels, width, height):
    """Scratch memory of one thread: what is known of edges, faces and pixels (10 arrays), gradients (3)."""
    face_count, edge_count = len(topology[0]), len(topology[1])
    return (
        np.empty((edge_count, 3)),
        np.empty((face_count, 1 + 2 * channels, 3)),
        np.empty((face_count, 3), np.int8),
        np.empty((edge_count, 2), np.int8),
        np.empty((face_count, 6)),
        np.empty((face_count, 16)),
        np.empty((height, width + WIDE)),
        np.empty((height, width + WIDE), np.int32),
        np.empty(1 + face_count, np.bool_),
        np.empty(1 + face_count, np.bool_),
        np.empty((face_count, 1 + 2 * channels, 3)),
        np.empty((vertex_count, 3)),
        np.empty((vertex_count, channels)),
    )


@kernel(error_model="numpy")
def find_visible(screen, colours, topology, crease, workspace, box, width, height):
    """What is seen of one mesh, inside its box: leaves it in the workspace, and returns the pieces of contour, crease
    and crossing; there are none where crease is negative."""
    faces, edges, edge_faces, face_edges = topology
    lines, planes, sides, edge_sides, boxes, covers, depths, visible, seen, bordering = workspace[:10]
    set_up_edges(screen, edges, lines)
    set_up_faces(screen, faces, edge_faces, face_edges, lines, planes, sides, edge_sides, boxes, covers)
    rasterise(covers, sides, boxes, box, width, depths, visible, seen)
    # Where the jump of a colour decides what is a crease, any edge may be a border.
    bordering[:] = 0.0 <= crease < np.inf
    if crease < np.inf:
        set_up_colours(screen, colours, faces, sides, seen, bordering, planes)
    if crease < 0.0:
        return np.empty((0, 5), np.int32), np.empty((0, 7)), np.empty((0, 9), np.int32), 0

    grid = grid_over(box, len(faces))
    spans, starts, items = sort_into_cells(boxes, len(faces), grid)
    ends, segment_codes, count = find_segments(
        screen, faces, edges, edge_faces, face_edges, lines, planes, sides, edge_sides, boxes, colours.shape[1], crease,
        width, height, grid, spans, starts, items,
    )  # fmt: skip
    heads, links, link_places, link_count = cuts_between(ends, count, box)
    points, codes, found = find_pieces(
        edges, covers, grid, starts, items, ends, segment_codes, count,
        heads, links, link_places, link_count, width, height,
    )  # fmt: skip
    find_shadows(points, found)
    if crease == np.inf:
        for n in range(found):
            bordering[codes[n, 2] + 1] = bordering[codes[n, 3] + 1] = True
        set_up_colours(screen, colours, faces, sides, seen, bordering, planes)
    return segment_codes, points, codes, found


@kernel(error_model="numpy")
def paint_visible(workspace, pieces, width, picture):
    """Adds the antialiased picture of what `find_visible` found to picture [C, H, W + WIDE]."""
    _, planes, _, _, boxes, _, depths, visible, seen, _ = workspace[:10]
    _, points, codes, found = pieces
    add_interior(planes, boxes, seen, visible, depths, width, picture)
    add_pieces(planes, boxes, points, codes, found, picture)


@kernel(error_model="numpy")
def visible_gradient(screen, colours, topology, workspace, pieces, width, picture_gradient):
    """Adjoint of `find_visible` and `paint_visible`, after the former; leaves the gradients of vertices and colours in
    the workspace."""
    faces, edges = topology[0], topology[1]
    lines, planes, sides, _, boxes, _, depths, visible, seen, _ = workspace[:10]
    plane_gradients, screen_gradient, colour_gradient = workspace[10:13]
    segment_codes, points, codes, found = pieces
    plane_gradients[:] = 0.0
    screen_gradient[:] = 0.0
    colour_gradient[:] = 0.0
    interior_gradient(planes, boxes, seen, visible, depths, width, picture_gradient, plane_gradients)
    pieces_gradient(
        screen, edges, lines, planes, boxes, segment_codes, points, codes, found, picture_gradient,
        plane_gradients, screen_gradient,
    )  # fmt: skip
    faces_gradient(screen, colours, faces, planes, sides, plane_gradients, screen_gradient, colour_gradient)
