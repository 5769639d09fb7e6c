"""The arithmetic of solids, compiled: numpy takes ten times as long for arrays as small as these."""

import math

import numpy as np

from rasteriser.compilation import kernel


@kernel()
def with_centres(rings):
    """The points of all rings [S, N, 3] in order, then the mean of the first ring and that of the last."""
    sections, points, _ = rings.shape
    vertices = np.zeros((sections * points + 2, 3))
    for section in range(sections):
        for point in range(points):
            for axis in range(3):
                vertices[section * points + point, axis] = rings[section, point, axis]
    for end, section in enumerate((0, sections - 1)):
        centre = vertices[sections * points + end]
        for point in range(points):
            for axis in range(3):
                centre[axis] += rings[section, point, axis]
        for axis in range(3):
            centre[axis] /= points
    return vertices


@kernel()
def volume(vertices, faces):
    """What the faces enclose, parts that overlap counted twice; negative where they look inward."""
    total = 0.0
    for face in range(len(faces)):
        a, b, c = vertices[faces[face, 0]], vertices[faces[face, 1]], vertices[faces[face, 2]]
        total += a[0] * (b[1] * c[2] - b[2] * c[1])
        total += a[1] * (b[2] * c[0] - b[0] * c[2])
        total += a[2] * (b[0] * c[1] - b[1] * c[0])
    return total / 6


@kernel()
def tube_sections(centres, radii, cosine, sine):
    """The sections [S, N, 3] of a bar: at each of its centres [S, 3], a ring of its radius there. The ring is carried
    along by the smallest turn at each bend and set across the bisector."""
    steps, points = len(centres), len(cosine)
    tangents = np.empty((steps, 3))
    _tangents(centres, tangents)
    # A bar keeps its sides parallel to the axis that it leans on least.
    least, across = np.inf, np.zeros(3)
    for axis in range(3):
        leaning = 0.0
        for step in range(steps):
            leaning += abs(tangents[step, axis])
        if leaning < least:
            least, chosen = leaning, axis
    across[chosen] = 1.0
    beside, rings = np.empty(3), np.empty((steps, points, 3))
    for step in range(steps):
        tangent = tangents[step]
        along = across[0] * tangent[0] + across[1] * tangent[1] + across[2] * tangent[2]
        for axis in range(3):
            across[axis] -= tangent[axis] * along
        _shorten(across)
        for axis in range(3):
            second, third = (axis + 1) % 3, (axis + 2) % 3
            beside[axis] = tangent[second] * across[third] - tangent[third] * across[second]
        for point in range(points):
            for axis in range(3):
                around = cosine[point] * across[axis] + sine[point] * beside[axis]
                rings[step, point, axis] = centres[step, axis] + radii[step] * around
    return rings


@kernel()
def _tangents(centres, tangents):
    """Unit directions of a path: along its ends, and across the bisectors of its bends."""
    steps = len(centres)
    segments = np.empty((steps - 1, 3))
    for step in range(steps - 1):
        for axis in range(3):
            segments[step, axis] = centres[step + 1, axis] - centres[step, axis]
        _shorten(segments[step])
    for step in range(steps):
        for axis in range(3):
            before, after = segments[max(step - 1, 0), axis], segments[min(step, steps - 2), axis]
            tangents[step, axis] = before if step in (0, steps - 1) else before + after
        _shorten(tangents[step])


@kernel(error_model="numpy")
def _shorten(vector):
    """To length one, in place."""
    length = math.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
    for axis in range(3):
        vector[axis] /= length


@kernel()
def rotated(vertices, axis, cosine, sine, pivot):
    """Points, turned right-handedly about the axis (0 x, 1 y, 2 z) through `pivot`."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turned = vertices.copy()
    for vertex in range(len(vertices)):
        one, other = vertices[vertex, first] - pivot[first], vertices[vertex, second] - pivot[second]
        turned[vertex, first] = cosine * one - sine * other + pivot[first]
        turned[vertex, second] = sine * one + cosine * other + pivot[second]
    return turned


@kernel(error_model="numpy")
def centred(vertices, faces):
    """Points, moved and scaled until the bounding box of those that faces have is centred and its diagonal is one."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for face in range(len(faces)):
        for corner in range(3):
            for axis in range(3):
                value = vertices[faces[face, corner], axis]
                low[axis], high[axis] = min(low[axis], value), max(high[axis], value)
    diagonal = math.sqrt((high[0] - low[0]) ** 2 + (high[1] - low[1]) ** 2 + (high[2] - low[2]) ** 2)
    points = np.empty_like(vertices)
    for axis in range(3):
        middle = (low[axis] + high[axis]) / 2
        for vertex in range(len(vertices)):
            points[vertex, axis] = (vertices[vertex, axis] - middle) / diagonal
    return points
