"""Triangles in front of a camera as triangles among the samples of its picture: what `rasteriser.supersample` draws.

Its frame is told there; positions are in samples, `supersampling` of them to a pixel.
"""

import numpy as np

from rasteriser.compilation import kernel

NEAR = 1e-3
"""Distance of the near plane from the camera; what lies in front of it is cut away exactly."""

_DEGENERATE = 1e-6
"""Triangles of less area than this (in samples squared) have no reliable plane, and are too thin to hold a sample."""


@kernel(error_model="numpy")
def project(corners, colours, focal_length, width, height, supersampling, closed, screen, planes):
    """Clips at the near plane, projects to samples, and returns the number of triangles written, at most two a face.

    Fills `screen` [2F, corner, xy] and `planes` [2F, 1 + C, 3]: 1/z and each colour/z as affine functions (∂x, ∂y,
    constant) of the position. Triangles that cannot hold a sample are left out, and of `closed` meshes those that turn
    their back to the camera.
    """
    polygon = np.empty((4, 3 + colours.shape[2]))
    columns, rows = width * supersampling, height * supersampling
    count = 0
    for face in range(corners.shape[0]):
        sides = _clip(corners, colours, face, polygon)
        for fan in range(sides - 2):
            for corner in range(3):
                source = 0 if corner == 0 else fan + corner
                scale = focal_length / polygon[source, 2]
                screen[count, corner, 0] = supersampling * (width / 2 + scale * polygon[source, 0])
                screen[count, corner, 1] = supersampling * (height / 2 - scale * polygon[source, 1])
            if not _holds_samples(screen, count, columns, rows):
                continue
            if _plane_equations(screen, planes, count, polygon, fan, closed):
                count += 1
    return count


@kernel(error_model="numpy")
def _clip(corners, colours, face, polygon):
    """Writes what remains beyond the near plane, [sides, xyz + colour]; returns the number of its sides, 0, 3 or 4."""
    channels = colours.shape[2]
    beyond = 0
    for start in range(3):
        for axis in range(3):
            if not np.isfinite(corners[face, start, axis]):
                return 0
        beyond += corners[face, start, 2] >= NEAR
    if beyond == 0:
        return 0
    sides = 0
    for start in range(3):
        end = (start + 1) % 3
        if corners[face, start, 2] >= NEAR:
            for axis in range(3):
                polygon[sides, axis] = corners[face, start, axis]
            for channel in range(channels):
                polygon[sides, 3 + channel] = colours[face, start, channel]
            sides += 1
        if beyond < 3 and (corners[face, start, 2] >= NEAR) != (corners[face, end, 2] >= NEAR):
            # From what is kept to what is lost, whichever way the face goes round: its neighbour's cut is the same.
            kept, lost = (start, end) if corners[face, start, 2] >= NEAR else (end, start)
            share = (NEAR - corners[face, kept, 2]) / (corners[face, lost, 2] - corners[face, kept, 2])
            for axis in range(2):
                step = corners[face, lost, axis] - corners[face, kept, axis]
                polygon[sides, axis] = corners[face, kept, axis] + share * step
            polygon[sides, 2] = NEAR
            for channel in range(channels):
                here, there = colours[face, kept, channel], colours[face, lost, channel]
                polygon[sides, 3 + channel] = (1 - share) * here + share * there
            sides += 1
    return sides


@kernel(error_model="numpy")
def _holds_samples(screen, triangle, columns, rows):
    """Whether there is a sample in the bounding box: many triangles fall between two of them."""
    x0, x1, x2 = screen[triangle, 0, 0], screen[triangle, 1, 0], screen[triangle, 2, 0]
    if first_sample(min(x0, x1, x2), columns) == first_sample(max(x0, x1, x2), columns):
        return False
    y0, y1, y2 = screen[triangle, 0, 1], screen[triangle, 1, 1], screen[triangle, 2, 1]
    return first_sample(min(y0, y1, y2), rows) != first_sample(max(y0, y1, y2), rows)


@kernel(error_model="numpy")
def _plane_equations(screen, planes, triangle, polygon, fan, closed):
    """Writes a triangle's planes; False if it has none, or is the back of a `closed` mesh."""
    x0, y0 = screen[triangle, 0, 0], screen[triangle, 0, 1]
    x1, y1 = screen[triangle, 1, 0] - x0, screen[triangle, 1, 1] - y0
    x2, y2 = screen[triangle, 2, 0] - x0, screen[triangle, 2, 1] - y0
    area = x1 * y2 - x2 * y1
    # Rows are counted downward: what goes round counter-clockwise as seen has a negative area.
    if abs(area) < _DEGENERATE or (closed and area > 0):
        return False
    near0, near1, near2 = 1 / polygon[0, 2], 1 / polygon[fan + 1, 2], 1 / polygon[fan + 2, 2]
    for row in range(planes.shape[1]):
        value0, value1, value2 = near0, near1, near2
        if row > 0:
            value0 *= polygon[0, 2 + row]
            value1 *= polygon[fan + 1, 2 + row]
            value2 *= polygon[fan + 2, 2 + row]
        value1, value2 = value1 - value0, value2 - value0
        along_x, along_y = (value1 * y2 - value2 * y1) / area, (value2 * x1 - value1 * x2) / area
        planes[triangle, row, 0], planes[triangle, row, 1] = along_x, along_y
        planes[triangle, row, 2] = value0 - along_x * x0 - along_y * y0
    return True


@kernel(error_model="numpy")
def first_sample(position, limit):
    """Index of the first sample whose centre is at or beyond `position`, within [0, limit]."""
    return int(min(max(np.ceil(position - 0.5), 0.0), float(limit)))


@kernel(error_model="numpy")
def bounds(screen, width, height):
    """Where samples can be covered: columns [left, right) and rows [top, bottom), none where there are no triangles."""
    left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
    for triangle in range(screen.shape[0]):
        for corner in range(3):
            x, y = screen[triangle, corner, 0], screen[triangle, corner, 1]
            left, right = min(left, x), max(right, x)
            top, bottom = min(top, y), max(bottom, y)
    columns = first_sample(left, width), first_sample(right, width)
    return *columns, first_sample(top, height), first_sample(bottom, height)
