"""Pictures of triangle meshes by brute force: a hard z-buffer at k times the resolution, averaged down.

This is how training pictures are made, and the truth that the antialiased renderer is measured against: as k grows,
the result converges to the box-filtered picture.

Frame: camera coordinates x right, y up, z depth (forward, positive in front of the camera). The projection of a point
is x_pixel = W/2 + f·x/z and y_pixel = H/2 - f·y/z with the focal length f in pixels; row 0 is on top, and the centre
of pixel (row j, column i) lies at (i + 0.5, j + 0.5).
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEAR = 1e-3
"""Distance of the near plane from the camera; what lies in front of it is cut away exactly."""

_DEGENERATE = 1e-6
"""Triangles of less area than this (in samples squared) have no reliable plane, and are too thin to hold a sample."""


class Picture(NamedTuple):
    """`colour` [H, W, C] over black, hence premultiplied by `alpha` [H, W], the share of each pixel that is covered."""

    colour: NDArray[np.float32]
    alpha: NDArray[np.float32]


def render(
    corners: NDArray[np.float64],
    colours: NDArray[np.float64],
    focal_length: float,
    width: int,
    height: int,
    supersampling: int = 4,
) -> Picture:
    """Draws triangles, both sides visible, nearest first, over black.

    `corners` [F, 3, 3] are the corners of the faces in camera coordinates; `colours` [F, 3, C] their colours,
    interpolated perspective-correctly (linear on the surface, not on the screen); `focal_length` in pixels. Each pixel
    is the mean of `supersampling`² samples on a regular grid. A sample on an edge that two faces share belongs to
    exactly one of them (left and top edges are inside, right and bottom edges outside), so neither gaps nor double
    coverage occur. Degenerate faces and corners that are not finite draw nothing.

    Raises ValueError where shapes disagree or a size is not positive.
    """
    if corners.ndim != 3 or corners.shape[1:] != (3, 3) or colours.shape[:2] != corners.shape[:2] or colours.ndim != 3:
        raise ValueError(f"expected corners [F, 3, 3] and colours [F, 3, C], found {corners.shape} and {colours.shape}")
    if min(width, height, supersampling) < 1 or not focal_length > 0:
        raise ValueError(
            "expected a positive width, height, supersampling and focal length, "
            f"found {width}, {height}, {supersampling} and {focal_length}"
        )
    colour, alpha = _render(
        np.ascontiguousarray(corners, np.float64),
        np.ascontiguousarray(colours, np.float64),
        float(focal_length),
        width,
        height,
        supersampling,
    )
    return Picture(colour, alpha)


@njit(nogil=True, cache=True, error_model="numpy")
def _render(corners, colours, focal_length, width, height, supersampling):
    faces, channels = colours.shape[0], colours.shape[2]
    # A face that crosses the near plane leaves at most two triangles; all others leave one.
    screen = np.empty((2 * faces, 3, 2))
    planes = np.empty((2 * faces, 1 + channels, 3))
    triangles = _project(corners, colours, focal_length, width, height, supersampling, screen, planes)

    left, right, top, bottom = _bounds(screen[:triangles], width * supersampling, height * supersampling)
    # Whole pixels only, so that each pixel's samples all lie inside the buffers.
    left, top = left // supersampling * supersampling, top // supersampling * supersampling
    right, bottom = -(-right // supersampling) * supersampling, -(-bottom // supersampling) * supersampling
    colour = np.zeros((height, width, channels), np.float32)
    alpha = np.zeros((height, width), np.float32)
    if right <= left or bottom <= top:
        return colour, alpha

    nearness = np.zeros((bottom - top, right - left), np.float32)
    owner = np.full((bottom - top, right - left), -1, np.int32)
    for triangle in range(triangles):
        _rasterise(screen[triangle], planes[triangle, 0], triangle, left, top, nearness, owner)
    _resolve(owner, planes, left, top, supersampling, colour, alpha)
    return colour, alpha


@njit(nogil=True, cache=True, error_model="numpy")
def _project(corners, colours, focal_length, width, height, supersampling, screen, planes):
    """Clips at the near plane, projects to samples, and returns the number of triangles written."""
    channels = colours.shape[2]
    polygon = np.empty((4, 3 + channels))
    count = 0
    for face in range(corners.shape[0]):
        sides = _clip(corners[face], colours[face], polygon)
        for fan in range(sides - 2):
            for corner in range(3):
                source = 0 if corner == 0 else fan + corner
                depth = polygon[source, 2]
                scale = focal_length / depth
                screen[count, corner, 0] = supersampling * (width / 2 + scale * polygon[source, 0])
                screen[count, corner, 1] = supersampling * (height / 2 - scale * polygon[source, 1])
            if _plane_equations(screen[count], polygon, fan, planes[count]):
                count += 1
    return count


@njit(nogil=True, cache=True, error_model="numpy")
def _clip(corner, colour, polygon):
    """Writes what remains beyond the near plane, [sides, xyz + colour]; returns the number of its sides, 0, 3 or 4."""
    channels = colour.shape[1]
    beyond = 0
    for start in range(3):
        if not (np.isfinite(corner[start, 0]) and np.isfinite(corner[start, 1]) and np.isfinite(corner[start, 2])):
            return 0
        beyond += corner[start, 2] >= NEAR
    if beyond == 0:
        return 0
    sides = 0
    for start in range(3):
        end = (start + 1) % 3
        if corner[start, 2] >= NEAR:
            for axis in range(3):
                polygon[sides, axis] = corner[start, axis]
            for channel in range(channels):
                polygon[sides, 3 + channel] = colour[start, channel]
            sides += 1
        if beyond < 3 and (corner[start, 2] >= NEAR) != (corner[end, 2] >= NEAR):
            share = (NEAR - corner[start, 2]) / (corner[end, 2] - corner[start, 2])
            for axis in range(2):
                polygon[sides, axis] = corner[start, axis] + share * (corner[end, axis] - corner[start, axis])
            polygon[sides, 2] = NEAR
            for channel in range(channels):
                polygon[sides, 3 + channel] = (1 - share) * colour[start, channel] + share * colour[end, channel]
            sides += 1
    return sides


@njit(nogil=True, cache=True, error_model="numpy")
def _plane_equations(points, polygon, fan, plane):
    """1/z and colour/z as affine functions (∂x, ∂y, constant) of the sample position; False if there are none."""
    x0, y0 = points[0, 0], points[0, 1]
    x1, y1 = points[1, 0] - x0, points[1, 1] - y0
    x2, y2 = points[2, 0] - x0, points[2, 1] - y0
    area = x1 * y2 - x2 * y1
    if abs(area) < _DEGENERATE:
        return False
    for row in range(plane.shape[0]):
        value0, value1, value2 = 1 / polygon[0, 2], 1 / polygon[fan + 1, 2], 1 / polygon[fan + 2, 2]
        if row > 0:
            value0 *= polygon[0, 2 + row]
            value1 *= polygon[fan + 1, 2 + row]
            value2 *= polygon[fan + 2, 2 + row]
        value1, value2 = value1 - value0, value2 - value0
        plane[row, 0] = (value1 * y2 - value2 * y1) / area
        plane[row, 1] = (value2 * x1 - value1 * x2) / area
        plane[row, 2] = value0 - plane[row, 0] * x0 - plane[row, 1] * y0
    return True


@njit(nogil=True, cache=True, error_model="numpy")
def _first_sample(position, limit):
    """Index of the first sample whose centre is at or beyond `position`, within [0, limit]."""
    return int(min(max(np.ceil(position - 0.5), 0.0), float(limit)))


@njit(nogil=True, cache=True, error_model="numpy")
def _bounds(screen, width, height):
    left, right, top, bottom = width, 0, height, 0
    for triangle in range(screen.shape[0]):
        for corner in range(3):
            column = _first_sample(screen[triangle, corner, 0], width)
            row = _first_sample(screen[triangle, corner, 1], height)
            left, right = min(left, column), max(right, column)
            top, bottom = min(top, row), max(bottom, row)
    return left, right, top, bottom


@njit(nogil=True, cache=True, error_model="numpy")
def _rasterise(points, depth_plane, triangle, left, top, nearness, owner):
    """Marks the samples of one triangle that are nearer than what the buffers hold."""
    height, width = owner.shape
    # Each edge from its upper to its lower corner, whatever the face's winding: two faces that share an edge then
    # compute the same floating-point crossings, and every sample falls to exactly one of them.
    x_start, y_start, y_end, slope = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for edge in range(3):
        upper, lower = edge, (edge + 1) % 3
        if points[upper, 1] > points[lower, 1]:
            upper, lower = lower, upper
        x_start[edge], y_start[edge], y_end[edge] = points[upper, 0], points[upper, 1], points[lower, 1]
        slope[edge] = (points[lower, 0] - points[upper, 0]) / (points[lower, 1] - points[upper, 1])
    first_row = _first_sample(min(y_start[0], y_start[1]) - top, height)
    last_row = _first_sample(max(y_end[0], y_end[1]) - top, height)
    depth_x, depth_y, depth_constant = depth_plane[0], depth_plane[1], depth_plane[2]
    for row in range(first_row, last_row):
        y = row + top + 0.5
        x_low, x_high = np.inf, -np.inf
        for edge in range(3):
            if y_start[edge] <= y < y_end[edge]:
                x = x_start[edge] + (y - y_start[edge]) * slope[edge]
                x_low = min(x_low, x)
                x_high = max(x_high, x)
        first, last = _first_sample(x_low - left, width), _first_sample(x_high - left, width)
        if last <= first:
            continue
        row_constant = depth_y * y + depth_constant + depth_x * (left + 0.5)
        for column in range(first, last):
            near = np.float32(depth_x * column + row_constant)
            if near > nearness[row, column]:
                nearness[row, column] = near
                owner[row, column] = triangle


@njit(nogil=True, cache=True, error_model="numpy")
def _resolve(owner, planes, left, top, supersampling, colour, alpha):
    """Averages the samples of each pixel."""
    channels = colour.shape[2]
    weight = 1.0 / (supersampling * supersampling)
    total = np.empty(channels)
    for row in range(owner.shape[0] // supersampling):
        for column in range(owner.shape[1] // supersampling):
            covered = 0
            total[:] = 0.0
            for sample_row in range(row * supersampling, (row + 1) * supersampling):
                y = sample_row + top + 0.5
                for sample_column in range(column * supersampling, (column + 1) * supersampling):
                    triangle = owner[sample_row, sample_column]
                    if triangle < 0:
                        continue
                    x = sample_column + left + 0.5
                    depth = 1.0 / (planes[triangle, 0, 0] * x + planes[triangle, 0, 1] * y + planes[triangle, 0, 2])
                    for channel in range(1, channels + 1):
                        value = planes[triangle, channel, 0] * x + planes[triangle, channel, 1] * y
                        total[channel - 1] += (value + planes[triangle, channel, 2]) * depth
                    covered += 1
            if covered:
                pixel_row, pixel_column = row + top // supersampling, column + left // supersampling
                alpha[pixel_row, pixel_column] = covered * weight
                for channel in range(channels):
                    colour[pixel_row, pixel_column, channel] = total[channel] * weight
