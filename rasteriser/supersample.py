"""Pictures of triangle meshes by brute force: a hard z-buffer at k times the resolution, averaged down.

This is how training pictures are made, and the truth that the antialiased renderer is measured against: as k grows,
the result converges to the box-filtered picture.

Frame: camera coordinates x right, y up, z depth (forward, positive in front of the camera). The projection of a point
is x_pixel = W/2 + f·x/z and y_pixel = H/2 - f·y/z with the focal length f in pixels; row 0 is on top, and the centre
of pixel (row j, column i) lies at (i + 0.5, j + 0.5).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rasteriser.compilation import kernel
from rasteriser.projection import bounds, first_sample, project


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
    closed: bool = False,
) -> Picture:
    """Draws triangles, both sides visible, nearest first, over black.

    `corners` [F, 3, 3] are the corners of the faces in camera coordinates; `colours` [F, 3, C] their colours,
    interpolated perspective-correctly (linear on the surface, not on the screen); `focal_length` in pixels. Each pixel
    is the mean of `supersampling`² samples on a regular grid. A sample on an edge that two faces share belongs to
    exactly one of them (left and top edges are inside, right and bottom edges outside), so neither gaps nor double
    coverage occur. Degenerate faces and corners that are not finite draw nothing.

    `closed` says that the faces are solids seen from outside, counter-clockwise as in `trainer.data.shapes.solid`:
    those that turn away from the camera are behind others, and are spared.

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
        closed,
    )
    return Picture(colour, alpha)


@kernel(error_model="numpy")
def _render(corners, colours, focal_length, width, height, supersampling, closed):
    faces, channels = colours.shape[0], colours.shape[2]
    # A face that crosses the near plane leaves at most two triangles; all others leave one.
    screen = np.empty((2 * faces, 3, 2))
    planes = np.empty((2 * faces, 1 + channels, 3))
    triangles = project(corners, colours, focal_length, width, height, supersampling, closed, screen, planes)

    left, right, top, bottom = bounds(screen[:triangles], width * supersampling, height * supersampling)
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
        _rasterise(screen, planes, triangle, left, top, nearness, owner)
    _resolve(owner, planes, left, top, supersampling, colour, alpha)
    return colour, alpha


@kernel(error_model="numpy")
def _rasterise(screen, planes, triangle, left, top, nearness, owner):
    """Marks the samples of one triangle that are nearer than what the buffers hold."""
    height, width = owner.shape
    upper, middle, lower = 0, 1, 2
    if screen[triangle, upper, 1] > screen[triangle, middle, 1]:
        upper, middle = middle, upper
    if screen[triangle, middle, 1] > screen[triangle, lower, 1]:
        middle, lower = lower, middle
    if screen[triangle, upper, 1] > screen[triangle, middle, 1]:
        upper, middle = middle, upper
    x0, y0 = screen[triangle, upper, 0], screen[triangle, upper, 1]
    x1, y1 = screen[triangle, middle, 0], screen[triangle, middle, 1]
    x2, y2 = screen[triangle, lower, 0], screen[triangle, lower, 1]
    # Each edge from its upper to its lower corner, whatever the face's winding: two faces that share an edge then
    # compute the same floating-point crossings, and every sample falls to exactly one of them.
    slope, upper_slope, lower_slope = (x2 - x0) / (y2 - y0), (x1 - x0) / (y1 - y0), (x2 - x1) / (y2 - y1)
    middle_row = first_sample(y1 - top, height)
    depth_x, depth_y, depth_constant = planes[triangle, 0, 0], planes[triangle, 0, 1], planes[triangle, 0, 2]
    for row in range(first_sample(y0 - top, height), first_sample(y2 - top, height)):
        y = row + top + 0.5
        one = x0 + (y - y0) * slope
        other = x0 + (y - y0) * upper_slope if row < middle_row else x1 + (y - y1) * lower_slope
        first, last = first_sample(min(one, other) - left, width), first_sample(max(one, other) - left, width)
        row_constant = depth_y * y + depth_constant + depth_x * (left + 0.5)
        for column in range(first, last):
            near = np.float32(depth_x * column + row_constant)
            if near > nearness[row, column]:
                nearness[row, column] = near
                owner[row, column] = triangle


@kernel(error_model="numpy")
def _resolve(owner, planes, left, top, supersampling, colour, alpha):
    """Averages the samples of each pixel."""
    channels, width = colour.shape[2], owner.shape[1]
    weight = 1.0 / (supersampling * supersampling)
    totals = np.empty((width // supersampling, channels))
    covered = np.empty(width // supersampling, np.int64)
    for row in range(owner.shape[0]):
        if row % supersampling == 0:
            totals[:] = 0.0
            covered[:] = 0
        _add_samples(owner[row], planes, left + 0.5, row + top + 0.5, supersampling, totals, covered)
        if row % supersampling == supersampling - 1:
            pixel_row, first = (row + top) // supersampling, left // supersampling
            for pixel in range(len(covered)):
                alpha[pixel_row, first + pixel] = covered[pixel] * weight
                for channel in range(channels):
                    colour[pixel_row, first + pixel, channel] = totals[pixel, channel] * weight


@kernel(error_model="numpy")
def _add_samples(owner, planes, left, y, supersampling, totals, covered):
    """Adds the colours of a row of samples to its pixels, those that one triangle has in one pixel at once:
    Σ (a·x + b·y + c)·depth = a·Σ x·depth + (b·y + c)·Σ depth."""
    start = 0
    while start < len(owner):
        triangle = owner[start]
        if triangle < 0:
            start += 1
            continue
        pixel, end = start // supersampling, start
        near_x, near_constant = planes[triangle, 0, 0], planes[triangle, 0, 1] * y + planes[triangle, 0, 2]
        depths, depths_x = 0.0, 0.0
        while end < (pixel + 1) * supersampling and owner[end] == triangle:
            x = end + left
            depth = 1.0 / (near_x * x + near_constant)
            depths += depth
            depths_x += x * depth
            end += 1
        for channel in range(totals.shape[1]):
            along_x, along_y = planes[triangle, channel + 1, 0], planes[triangle, channel + 1, 1]
            totals[pixel, channel] += along_x * depths_x + (along_y * y + planes[triangle, channel + 1, 2]) * depths
        covered[pixel] += end - start
        start = end
