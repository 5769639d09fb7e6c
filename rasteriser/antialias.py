"""Exact antialiasing of contours: mesh edges beyond which the surface ends or folds back.

Each straight piece of contour inside a pixel casts a *shadow* away from the pixel's centre, the part of the square
behind it, and adds area · (colour behind - colour in front) to the centre's colour. docs/renderer.md says why this is
exact for flat colours and any number of contours, and what is approximate: colours are taken at the middle of a piece,
and a piece is either visible or not.
"""

import numpy as np
from numba import njit

from rasteriser.coverage import NOTHING, line_value, plane_value, touches
from rasteriser.shading import add_colour_gradient

AT_VERTEX, AT_COLUMN, AT_ROW = 0, 1, 2
# A piece is hidden by a face in front of it by more than this share of its inverse depth.
DEPTH_MARGIN = 1e-6


@njit(cache=True, nogil=True, error_model="numpy")
def contour_side(lines, sides, edges, edge_faces, face_edges, edge):
    """+1 or -1, the side of an edge on which its surface lies; 0 for an edge that is no contour."""
    found = 0
    for slot in range(2):
        face = edge_faces[edge, slot]
        if face >= 0:
            for corner in range(3):
                if face_edges[face, corner] == edge and sides[face, corner] != 0:
                    if found == 0:
                        found = sides[face, corner]
                    elif found != sides[face, corner]:
                        return 0
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def cut_at_pixels(x0, y0, x1, y1, width, height, cuts, kinds):
    """Parameters t in [0, 1], in order, at which a segment enters, changes pixel in, and leaves the picture.

    kinds tells what is met at each: the segment's own end, a column boundary or a row boundary. Returns how many there
    are; fewer than two when the segment misses the picture.
    """
    dx, dy = x1 - x0, y1 - y0
    start, end, start_kind, end_kind = 0.0, 1.0, AT_VERTEX, AT_VERTEX
    for axis in range(2):
        origin, step, size = (x0, dx, np.float64(width)) if axis == 0 else (y0, dy, np.float64(height))
        kind = AT_COLUMN if axis == 0 else AT_ROW
        if step == 0.0:
            if not 0.0 <= origin < size:
                return 0
            continue
        enter, leave = -origin / step, (size - origin) / step
        if enter > leave:
            enter, leave = leave, enter
        if enter > start:
            start, start_kind = enter, kind
        if leave < end:
            end, end_kind = leave, kind
    if not start < end:
        return 0
    count = 1
    cuts[0], kinds[0] = start, start_kind
    # The next column and row boundary ahead of the start, and the parameter from one boundary to the next.
    column = np.floor(x0 + start * dx) + (1 if dx > 0 else 0)
    row = np.floor(y0 + start * dy) + (1 if dy > 0 else 0)
    while True:
        at_column = (column - x0) / dx if dx != 0.0 else np.inf
        at_row = (row - y0) / dy if dy != 0.0 else np.inf
        at = min(at_column, at_row)
        if not at < end or count >= len(cuts) - 1:
            break
        if at > cuts[count - 1]:
            cuts[count], kinds[count] = at, AT_COLUMN if at_column <= at_row else AT_ROW
            count += 1
        if at_column <= at_row:
            column += 1 if dx > 0 else -1
        else:
            row += 1 if dy > 0 else -1
    cuts[count], kinds[count] = end, end_kind
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy")
def perimeter_position(x, y):
    """Where the ray from the square's centre through (x, y) leaves it: 0 to 4 counter-clockwise, a unit a side."""
    if abs(x) >= abs(y):
        if x == 0.0:
            return 0.0
        return 0.5 * y / x + (0.0 if x > 0 else 2.0)
    return -0.5 * x / y + (1.0 if y > 0 else 3.0)


@njit(cache=True, nogil=True, error_model="numpy")
def shadow_area(ax, ay, bx, by):
    """Area of the unit square around the origin that lies behind the segment a b, as seen from the origin."""
    turn = abs(perimeter_position(bx, by) - perimeter_position(ax, ay))
    return min(turn, 4.0 - turn) / 4.0 - abs(ax * by - ay * bx) / 2.0


@njit(cache=True, nogil=True, error_model="numpy")
def is_hidden(lines, planes, sides, face_edges, edge_faces, visible, edge, x, y, w, ix, iy):
    """Whether the face seen at pixel (ix, iy) covers the point (x, y) of an edge and lies in front of it."""
    face = visible[iy + 1, ix + 1]
    if face == NOTHING or face == edge_faces[edge, 0] or face == edge_faces[edge, 1]:
        return False
    in_front = plane_value(planes, face, 0, x, y) > w * (1.0 + DEPTH_MARGIN)
    return in_front and touches(lines, face_edges, sides, face, x, y)


@njit(cache=True, nogil=True, error_model="numpy")
def look_at_piece(lines, planes, sides, face_edges, edge_faces, visible, edge, side, x, y, w, ix, iy):
    """What meets at the middle (x, y, w) of a piece of contour in pixel (ix, iy).

    Returns (seen, sign, far_face, far_x, far_y): sign is +1 where the pixel's centre lies on the side of the edge's
    positive half-plane, -1 where not; the colour across the contour is that of far_face at (far_x, far_y).
    """
    sign = 1 if line_value(lines, edge, ix + 0.5, iy + 0.5) >= 0 else -1
    # One pixel along the larger component of the line's normal always reaches the other side.
    step_x, step_y = 0, 0
    if abs(lines[edge, 0]) > abs(lines[edge, 1]):
        step_x = -sign if lines[edge, 0] > 0 else sign
    else:
        step_y = -sign if lines[edge, 1] > 0 else sign
    across = visible[iy + step_y + 1, ix + step_x + 1]
    far_face, far_x, far_y = across, ix + step_x + 0.5, iy + step_y + 0.5
    if sign != side:
        far_face, far_x, far_y = visible[iy + 1, ix + 1], ix + 0.5, iy + 0.5
    seen = not is_hidden(lines, planes, sides, face_edges, edge_faces, visible, edge, x, y, w, ix, iy)
    seen = seen and not is_hidden(
        lines, planes, sides, face_edges, edge_faces, visible, edge, x, y, w, ix + step_x, iy + step_y
    )
    if seen and far_face != NOTHING and touches(lines, face_edges, sides, far_face, x, y):
        far_x, far_y = x, y
    return seen, sign, far_face, far_x, far_y


@njit(cache=True, nogil=True, error_model="numpy")
def add_contours(screen, colours, edges, edge_faces, face_edges, lines, planes, sides, visible, cuts, kinds, picture):
    """Adds to picture [C, H, W] what contours change in the pixels that they cross."""
    channels, height, width = picture.shape
    for edge in range(edges.shape[0]):
        side = contour_side(lines, sides, edges, edge_faces, face_edges, edge)
        if side == 0:
            continue
        i, j = edges[edge, 0], edges[edge, 1]
        x0, y0, w0 = np.float64(screen[i, 0]), np.float64(screen[i, 1]), np.float64(screen[i, 2])
        x1, y1, w1 = np.float64(screen[j, 0]), np.float64(screen[j, 1]), np.float64(screen[j, 2])
        count = cut_at_pixels(x0, y0, x1, y1, width, height, cuts, kinds)
        for piece in range(count - 1):
            middle = 0.5 * (cuts[piece] + cuts[piece + 1])
            x, y, w = x0 + middle * (x1 - x0), y0 + middle * (y1 - y0), w0 + middle * (w1 - w0)
            ix, iy = min(max(int(x), 0), width - 1), min(max(int(y), 0), height - 1)
            seen, sign, far_face, far_x, far_y = look_at_piece(
                lines, planes, sides, face_edges, edge_faces, visible, edge, side, x, y, w, ix, iy
            )
            if not seen:
                continue
            ax, ay = x0 + cuts[piece] * (x1 - x0) - ix - 0.5, y0 + cuts[piece] * (y1 - y0) - iy - 0.5
            bx, by = x0 + cuts[piece + 1] * (x1 - x0) - ix - 0.5, y0 + cuts[piece + 1] * (y1 - y0) - iy - 0.5
            area = shadow_area(ax, ay, bx, by)
            towards_far = area if sign == side else -area
            share = middle * w1 / w
            far_depth = 0.0 if far_face == NOTHING else 1.0 / plane_value(planes, far_face, 0, far_x, far_y)
            for c in range(channels):
                near = colours[i, c] + share * (colours[j, c] - colours[i, c])
                far = 0.0 if far_face == NOTHING else plane_value(planes, far_face, 1 + c, far_x, far_y) * far_depth
                picture[c, iy, ix] += towards_far * (far - near)


@njit(cache=True, nogil=True, error_model="numpy")
def contours_gradient(
    screen, colours, edges, edge_faces, face_edges, lines, planes, sides, visible, cuts, kinds, picture_gradient,
    plane_gradients, screen_gradient, colour_gradient,
):  # fmt: skip
    """Adjoint of `add_contours`; the last three arrays are added to."""
    channels, height, width = picture_gradient.shape
    for edge in range(edges.shape[0]):
        side = contour_side(lines, sides, edges, edge_faces, face_edges, edge)
        if side == 0:
            continue
        i, j = edges[edge, 0], edges[edge, 1]
        x0, y0, w0 = np.float64(screen[i, 0]), np.float64(screen[i, 1]), np.float64(screen[i, 2])
        x1, y1, w1 = np.float64(screen[j, 0]), np.float64(screen[j, 1]), np.float64(screen[j, 2])
        dx, dy = x1 - x0, y1 - y0
        count = cut_at_pixels(x0, y0, x1, y1, width, height, cuts, kinds)
        for piece in range(count - 1):
            middle = 0.5 * (cuts[piece] + cuts[piece + 1])
            x, y, w = x0 + middle * dx, y0 + middle * dy, w0 + middle * (w1 - w0)
            ix, iy = min(max(int(x), 0), width - 1), min(max(int(y), 0), height - 1)
            seen, sign, far_face, far_x, far_y = look_at_piece(
                lines, planes, sides, face_edges, edge_faces, visible, edge, side, x, y, w, ix, iy
            )
            if not seen:
                continue
            ax, ay = x0 + cuts[piece] * dx - ix - 0.5, y0 + cuts[piece] * dy - iy - 0.5
            bx, by = x0 + cuts[piece + 1] * dx - ix - 0.5, y0 + cuts[piece + 1] * dy - iy - 0.5
            area = shadow_area(ax, ay, bx, by)
            flip = 1.0 if sign == side else -1.0
            share = middle * w1 / w
            far_depth = 0.0 if far_face == NOTHING else 1.0 / plane_value(planes, far_face, 0, far_x, far_y)
            follows = far_face != NOTHING and far_x == x and far_y == y
            to_area, to_share, to_x, to_y = 0.0, 0.0, 0.0, 0.0
            for c in range(channels):
                gradient = np.float64(picture_gradient[c, iy, ix])
                step = colours[j, c] - colours[i, c]
                near = colours[i, c] + share * step
                far = 0.0
                if far_face != NOTHING:
                    far = plane_value(planes, far_face, 1 + c, far_x, far_y) * far_depth
                    to_far = gradient * flip * area
                    add_colour_gradient(planes, far_face, far_x, far_y, c, to_far, plane_gradients)
                    if follows:
                        to_x += to_far * (planes[far_face, 1 + c, 1] - far * planes[far_face, 0, 1]) * far_depth
                        to_y += to_far * (planes[far_face, 1 + c, 2] - far * planes[far_face, 0, 2]) * far_depth
                to_area += gradient * flip * (far - near)
                to_near = -gradient * flip * area
                to_share += to_near * step
                colour_gradient[i, c] += to_near * (1.0 - share)
                colour_gradient[j, c] += to_near * share
            # share = t w1 / (w0 + t (w1 - w0)), with t the middle of the piece.
            to_middle = to_share * w0 * w1 / (w * w) + to_x * dx + to_y * dy
            screen_gradient[i, 2] -= to_share * middle * w1 * (1.0 - middle) / (w * w)
            screen_gradient[j, 2] += to_share * middle * w0 * (1.0 - middle) / (w * w)
            screen_gradient[i, 0] += to_x * (1.0 - middle)
            screen_gradient[i, 1] += to_y * (1.0 - middle)
            screen_gradient[j, 0] += to_x * middle
            screen_gradient[j, 1] += to_y * middle
            turn = 1.0 if ax * by - ay * bx >= 0 else -1.0
            for end in range(2):
                t, kind = cuts[piece + end], kinds[piece + end]
                # d area: the sector's end moves by (p × dp) / (8 max|p|²), the triangle by (dp × other) / 2.
                px, py, ox, oy = (ax, ay, bx, by) if end == 0 else (bx, by, ax, ay)
                outward = turn if end == 1 else -turn
                reach = max(abs(px), abs(py))
                spin = 0.125 / (reach * reach) if reach > 0.0 else 0.0
                to_px = to_area * outward * (-spin * py + 0.5 * oy)
                to_py = to_area * outward * (spin * px - 0.5 * ox)
                screen_gradient[i, 0] += (1.0 - t) * to_px
                screen_gradient[i, 1] += (1.0 - t) * to_py
                screen_gradient[j, 0] += t * to_px
                screen_gradient[j, 1] += t * to_py
                # Where the end lies on a pixel's boundary, t itself moves with the segment.
                to_t = to_px * dx + to_py * dy + 0.5 * to_middle
                if kind == AT_COLUMN:
                    screen_gradient[i, 0] -= to_t * (1.0 - t) / dx
                    screen_gradient[j, 0] -= to_t * t / dx
                elif kind == AT_ROW:
                    screen_gradient[i, 1] -= to_t * (1.0 - t) / dy
                    screen_gradient[j, 1] -= to_t * t / dy
