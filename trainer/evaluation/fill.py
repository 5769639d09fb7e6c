"""Occupancy of meshes as they are found: open, overlapping, inward-facing, with walls of no thickness.

Two witnesses are heard on a fine grid. Rays along the three axes count what they enter and leave, as in
`trainer.evaluation.voxels`; where all six directions say inside, it is inside. So a mesh of closed parts is found
exactly, and a hole lets in no more than the rays that pass through it. Where they disagree, a flood from outside
decides, which asks neither for orientation nor for closed parts: what it does not reach is solid, sealed hollows too.
Two rules complete that:

- The underside of many models is missing, since nobody sees it. Space that the flood enters only by rising, and that
  the surface around it encloses more than half (by the generalised winding number, Jacobson et al. 2013), is solid. A
  hollow that opens upwards or sideways, such as a bathtub's, stays hollow; so does one below a closed surface.
- A wall without thickness has no volume, yet is part of the object: it becomes one layer of voxels, as thin parts do
  everywhere (`trainer.evaluation.voxels`).
"""

import numpy as np
from jaxtyping import Bool, Float, Integer, UInt8
from numpy import ndarray

from rasteriser.compilation import kernel
from trainer.evaluation.columns import crossings, first_centre
from trainer.evaluation.voxels import FINENESS, RESOLUTION, Solid, blocks, centres, thin_layers

MARGIN = 2
"""Fine voxels around the cube: the inner layer is free, so that the flood gets around, and the outer one ends it."""

# A fine voxel of the surface with fewer solid ones than this among the 27 around it belongs to a wall that is too thin
# for the grid. One on the side of anything thicker has nine.
_SHEET_NEIGHBOURS = 3

_FREE, _FALLEN, _RISEN, _WALL = 0, 1, 2, 3


def fill(vertices: Float[ndarray, "V 3"], faces: Integer[ndarray, "F 3"], resolution: int = RESOLUTION) -> Solid:
    """The solid that a mesh shows from outside.

    A voxel is full where the rays say that its centre is inside; where they disagree, or where there is space that
    nobody can see, if at least half of it is solid; and where a thin part passes through. For closed and consistently
    oriented parts that is what `occupy` says, save for walls thinner than a fine voxel, which `occupy` may miss, and
    for gaps as narrow as that, which are closed here.

    Raises ValueError for coordinates that are not finite.
    """
    if not np.isfinite(vertices).all():
        raise ValueError("expected finite vertices, found NaN or infinity")
    triangles = np.asarray(vertices, np.float64)[np.asarray(faces)]
    surface, inside, doubtful = _cast_rays(triangles, resolution)
    state = _flood(surface)
    unseen = (state == _FREE) | _sheltered(triangles, state == _RISEN, resolution)
    surface, inside, doubtful, unseen = (_within(grid) for grid in (surface, inside, doubtful, unseen))
    unseen &= ~inside
    solid = inside | unseen
    sheet = surface & ~solid & (_neighbours(solid) < _SHEET_NEIGHBOURS)
    # Of a fine voxel that the surface of an open part passes, half is solid: nothing grows or shrinks.
    half_full = blocks(solid) + 0.5 * blocks(surface & ~sheet & ~solid) >= 0.5 * FINENESS**3
    decided_by_flood = centres(doubtful) | (blocks(unseen) > 0)
    full = centres(inside) | (decided_by_flood & half_full) | thin_layers(solid | sheet)
    return Solid(full, ~solid & ~surface)


def _within(grid: Bool[ndarray, "L L L"]) -> Bool[ndarray, "M M M"]:
    """The fine voxels of the cube, without those around it."""
    return grid[MARGIN:-MARGIN, MARGIN:-MARGIN, MARGIN:-MARGIN]


def _cast_rays(
    triangles: Float[ndarray, "F 3 3"], resolution: int
) -> tuple[Bool[ndarray, "M M M"], Bool[ndarray, "M M M"], Bool[ndarray, "M M M"]]:
    """(surface, inside, doubtful): the fine voxels that the surface passes, those whose centres all rays find inside,
    and those on which they disagree."""
    size = resolution * FINENESS + 2 * MARGIN
    surface = np.zeros((size,) * 3, np.bool_)
    inside, outside = np.ones_like(surface), np.ones_like(surface)
    for axis in range(3):
        order = (axis - 1) % 3, axis, (axis + 1) % 3
        corners = np.ascontiguousarray(((triangles + 0.5) * (resolution * FINENESS) - 0.5 + MARGIN)[..., order])
        # Views whose second axis is `axis`, so that the columns run along it.
        _cast(corners, surface.transpose(order), inside.transpose(order), outside.transpose(order))
    return surface, inside, ~inside & ~outside


@kernel()
def _cast(corners, surface, inside, outside):
    """Marks, in each column along the second axis, the voxels that the triangles cross; of `inside` and `outside`
    remains what the column's rays from below and from above both confirm."""
    size = surface.shape[0]
    winding = np.zeros((size, size, size), np.int16)
    columns, heights = np.empty((size**2, 2), np.int64), np.empty(size**2)
    for face in range(corners.shape[0]):
        count, sign = crossings(corners[face], size, columns, heights)
        for crossing in range(count):
            x, z, height = columns[crossing, 0], columns[crossing, 1], heights[crossing]
            passed, y = int(np.floor(height + 0.5)), first_centre(height, size)
            if 0 <= passed < size:
                surface[x, passed, z] = True
            if y < size:
                winding[x, y, z] += sign
    for x in range(size):
        for y in range(1, size):
            for z in range(size):
                winding[x, y, z] += winding[x, y - 1, z]
        for y in range(size):
            for z in range(size):
                # The winding number beyond the last crossing: not zero where what was entered is never left.
                left = winding[x, size - 1, z]
                inside[x, y, z] &= winding[x, y, z] != 0 and left == 0
                outside[x, y, z] &= winding[x, y, z] == 0 and left == 0


@kernel()
def _flood(surface):
    """The state of each fine voxel: _FALLEN where the air comes from above or from a side, _RISEN where it only comes
    by rising, _FREE where it does not come, _WALL on the surface and around the grid."""
    size = surface.shape[0]
    state = np.full(surface.shape, _WALL, np.uint8)
    for x in range(1, size - 1):
        for y in range(1, size - 1):
            for z in range(1, size - 1):
                if not surface[x, y, z]:
                    state[x, y, z] = _FREE
    flat, up = state.reshape(-1), size
    steps = np.array([-up, -size * size, size * size, -1, 1, up])
    stack = np.empty(flat.size, np.int32)
    # The free layer around the object is one: a single voxel of it, on top, is where the air comes from.
    stack[0] = size * size + (size - 2) * size + 1
    flat[stack[0]] = _FALLEN
    _spread(flat, stack, 1, steps[:5], _FALLEN)
    count = 0
    for index in range(flat.size - up):
        if flat[index] == _FALLEN and flat[index + up] == _FREE:
            flat[index + up] = _RISEN
            stack[count] = index + up
            count += 1
    _spread(flat, stack, count, steps, _RISEN)
    return state


@kernel()
def _spread(flat, stack, count, steps, mark):
    while count:
        count -= 1
        here = stack[count]
        for step in steps:
            if flat[here + step] == _FREE:
                flat[here + step] = mark
                stack[count] = here + step
                count += 1


def _sheltered(
    triangles: Float[ndarray, "F 3 3"], risen: Bool[ndarray, "M M M"], resolution: int
) -> Bool[ndarray, "M M M"]:
    """Those of the risen fine voxels that lie in a voxel which the surface encloses more than half."""
    voxels = np.argwhere(blocks(_within(risen)) >= 0.5 * FINENESS**3)
    enclosed = np.zeros((resolution,) * 3, np.bool_)
    winding = _winding_numbers(triangles, (voxels + 0.5) / resolution - 0.5)
    enclosed[tuple(voxels[np.abs(winding) > 0.5].T)] = True
    fine = enclosed.repeat(FINENESS, 0).repeat(FINENESS, 1).repeat(FINENESS, 2)
    return risen & np.pad(fine, MARGIN)


@kernel()
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


def _neighbours(solid: Bool[ndarray, "M M M"]) -> UInt8[ndarray, "M M M"]:
    """How many of the 27 voxels around each one are solid."""
    counts = solid.view(np.uint8)
    for axis in range(3):
        counts = counts + np.roll(counts, 1, axis) + np.roll(counts, -1, axis)
    return counts
