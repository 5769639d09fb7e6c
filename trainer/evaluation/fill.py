"""Occupancy of meshes as they are found: open, overlapping, inward-facing, with walls of no thickness.

The space outside is found by flooding a fine grid, which asks neither for orientation nor for closed parts, and what
the flood does not reach is solid. Two rules beyond that:

- The underside of many models is missing, since nobody sees it. Space that the flood enters only by rising, and that
  the surface around it encloses more than half (by the generalised winding number, Jacobson et al. 2013), is solid. A
  hollow that opens upwards or sideways, such as a bathtub's, stays hollow; so does one below a closed surface.
- A wall without thickness has no volume, yet is part of the object: it becomes one layer of voxels.
"""

import numpy as np
from jaxtyping import Bool, Float, Integer
from numba import njit
from numpy import ndarray

from trainer.evaluation.columns import crossings
from trainer.evaluation.voxels import RESOLUTION

_FINENESS = 4
_MARGIN = 1


def voxelise_solid(
    vertices: Float[ndarray, "V 3"],
    faces: Integer[ndarray, "F 3"],
    resolution: int = RESOLUTION,
    fineness: int = _FINENESS,
) -> Bool[ndarray, "R R R"]:
    """The voxels of the cube [-0.5, 0.5]³ that are at least half full, on a grid `fineness` times as fine.

    Fine voxels that the surface passes count half, so that a solid neither grows nor shrinks. Gaps narrower than a
    fine voxel are closed. Raises ValueError for coordinates that are not finite.
    """
    if not np.isfinite(vertices).all():
        raise ValueError("expected finite vertices, found NaN or infinity")
    fine = resolution * fineness
    triangles = np.asarray(vertices, np.float64)[np.asarray(faces)]
    surface = np.zeros((fine + 2 * _MARGIN,) * 3, np.bool_)
    for axis in range(3):
        order = (axis - 1) % 3, axis, (axis + 1) % 3
        corners = np.ascontiguousarray(((triangles + 0.5) * fine - 0.5 + _MARGIN)[..., order])
        # A view whose second axis is `axis`, so that the columns run along it.
        _mark(corners, surface.transpose(order))

    reached = _flood(surface, True)
    inside = ~reached & ~surface
    inside |= _sheltered(triangles, reached & ~_flood(surface, False), resolution, fineness)
    sheet = surface & ~_neighbourhood(inside)
    full = _blocks(inside, fineness) + 0.5 * _blocks(surface & ~sheet & ~inside, fineness)
    return (full >= 0.5 * fineness**3) | (_blocks(sheet, fineness) >= 0.5 * fineness**2)


@njit(nogil=True, cache=True)
def _mark(corners, surface):
    """Marks, in each column along the second axis, the voxel that each triangle crosses."""
    size = surface.shape[0]
    columns, heights = np.empty((size**2, 2), np.int64), np.empty(size**2)
    for face in range(corners.shape[0]):
        count, _ = crossings(corners[face], size, columns, heights)
        for crossing in range(count):
            y = int(np.floor(heights[crossing] + 0.5))
            if 0 <= y < size:
                surface[columns[crossing, 0], y, columns[crossing, 1]] = True


@njit(nogil=True, cache=True)
def _flood(surface, rising):
    """What is reached from the border through faces of free voxels; without `rising`, never along +y."""
    size = surface.shape[0]
    reached = np.zeros_like(surface)
    stack = np.empty((surface.size, 3), np.int16)
    count = 0
    for x in range(size):
        for y in range(size):
            for z in range(size):
                border = x in (0, size - 1) or y == size - 1 or z in (0, size - 1) or (rising and y == 0)
                if border and not surface[x, y, z]:
                    reached[x, y, z] = True
                    stack[count] = x, y, z
                    count += 1
    while count:
        count -= 1
        x, y, z = stack[count]
        for axis in range(3):
            for step in (-1, 1):
                if axis == 1 and step == 1 and not rising:
                    continue
                i, j, k = x + step * (axis == 0), y + step * (axis == 1), z + step * (axis == 2)
                if min(i, j, k) < 0 or max(i, j, k) >= size or surface[i, j, k] or reached[i, j, k]:
                    continue
                reached[i, j, k] = True
                stack[count] = i, j, k
                count += 1
    return reached


def _sheltered(
    triangles: Float[ndarray, "F 3 3"], doubtful: Bool[ndarray, "M M M"], resolution: int, fineness: int
) -> Bool[ndarray, "M M M"]:
    """Those of the doubtful fine voxels that lie in a voxel which the surface encloses more than half."""
    blocks = np.argwhere(_blocks(doubtful, fineness) >= 0.5 * fineness**3)
    enclosed = np.zeros((resolution,) * 3, np.bool_)
    winding = _winding_numbers(triangles, (blocks + 0.5) / resolution - 0.5)
    enclosed[tuple(blocks[np.abs(winding) > 0.5].T)] = True
    fine = enclosed.repeat(fineness, 0).repeat(fineness, 1).repeat(fineness, 2)
    return doubtful & np.pad(fine, _MARGIN)


@njit(nogil=True, cache=True)
def _winding_numbers(triangles, points):
    """Generalised winding number: solid angles of all triangles, by Van Oosterom and Strackee's formula."""
    winding = np.zeros(len(points))
    for index in range(len(points)):
        px, py, pz = points[index]
        for face in range(len(triangles)):
            ax, ay, az = triangles[face, 0, 0] - px, triangles[face, 0, 1] - py, triangles[face, 0, 2] - pz
            bx, by, bz = triangles[face, 1, 0] - px, triangles[face, 1, 1] - py, triangles[face, 1, 2] - pz
            cx, cy, cz = triangles[face, 2, 0] - px, triangles[face, 2, 1] - py, triangles[face, 2, 2] - pz
            a, b, c = np.sqrt(ax**2 + ay**2 + az**2), np.sqrt(bx**2 + by**2 + bz**2), np.sqrt(cx**2 + cy**2 + cz**2)
            volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
            ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
            winding[index] += np.arctan2(volume, a * b * c + ab * c + bc * a + ca * b)
    return winding / (2 * np.pi)


def _neighbourhood(solid: Bool[ndarray, "M M M"]) -> Bool[ndarray, "M M M"]:
    """The voxels that touch a solid one, by a face, an edge or a corner."""
    for axis in range(3):
        solid = solid | np.roll(solid, 1, axis) | np.roll(solid, -1, axis)
    return solid


def _blocks(fine: Bool[ndarray, "M M M"], fineness: int) -> Integer[ndarray, "R R R"]:
    """How many fine voxels are set in each voxel."""
    inner = fine[_MARGIN:-_MARGIN, _MARGIN:-_MARGIN, _MARGIN:-_MARGIN]
    size = len(inner) // fineness
    counts: Integer[ndarray, "R R R"] = inner.reshape(size, fineness, size, fineness, size, fineness).sum((1, 3, 5))
    return counts
