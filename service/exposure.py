"""How much of each block shows: the area of its surface that lies outside of all others.

Blocks are convex, as the block parameterisations make them. A mesh of one part has nothing that could hide it.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from service.inference import Surface
from service.manifest import Block, Manifest

Blocks = Literal["all", "used"]
"""Which blocks of an object are wanted."""

LEAST_AREA: Final = 1 / 32**2
"""Of a block that counts as used, square diagonals: one side of one of the judge's voxels, or a pixel at 48 × 36."""
POINTS: Final = 256
"""Spread over the surface of each block."""
# Where two surfaces touch, rounding would decide.
_TOUCHING: Final = 1e-6


class Surfaces(NamedTuple):
    """The surfaces of K blocks."""

    areas: NDArray[np.float64]
    """Square diagonals [K]."""
    inside: NDArray[np.bool_]
    """Which of the points on block k lie inside block j: [K, K, POINTS] for j, k."""


def used_part(surface: Surface, manifest: Manifest) -> tuple[Surface, Manifest]:
    """The same object without the blocks that it does not use, and a manifest of what remains: faces, blocks, vertices.

    What it looks like, and what it fills, stays as it is to within LEAST_AREA for each block.
    """
    faces = np.array(manifest.faces, np.int64)
    used = [manifest.blocks[block] for block in used_blocks(surface.vertices, faces, manifest.blocks)]
    parts = [faces[block.first_face : block.first_face + block.face_count] for block in used]
    vertices, numbers = np.unique(np.concatenate(parts), return_inverse=True)
    starts = np.cumsum([0, *(block.face_count for block in used[:-1])]).tolist()
    remaining = replace(
        manifest,
        vertices=len(vertices),
        faces=tuple((a, b, c) for a, b, c in numbers.reshape(-1, 3).tolist()),
        blocks=tuple(replace(block, first_face=start) for block, start in zip(used, starts, strict=True)),
    )
    return Surface(surface.vertices[vertices], surface.normals[vertices]), remaining


def used_blocks(vertices: NDArray[np.floating], faces: NDArray[np.integer], blocks: Sequence[Block]) -> tuple[int, ...]:
    """The numbers of the blocks that show by LEAST_AREA at least, for a mesh of vertices [V, 3] and faces [F, 3].

    What shows least is left out first, and what it hid counts as shown from then on: of two blocks in one place one
    stays. One stays in any case.
    """
    if len(blocks) == 1:
        return (0,)
    surfaces = surfaces_of(vertices, faces, blocks)
    kept = set(range(len(blocks)))
    while len(kept) > 1:
        shown = {block: shown_area(surfaces, block, kept) for block in kept}
        least = min(kept, key=lambda block: (shown[block], -block))
        if shown[least] >= LEAST_AREA:
            break
        kept.remove(least)
    return tuple(sorted(kept))


def shown_area(surfaces: Surfaces, block: int, beside: Collection[int]) -> float:
    """How much of a block's surface lies outside of those `beside` it, square diagonals; itself does not count."""
    others = [other for other in beside if other != block]
    return float(surfaces.areas[block] * (1 - surfaces.inside[others, block].any(0).mean()))


def surfaces_of(vertices: NDArray[np.floating], faces: NDArray[np.integer], blocks: Sequence[Block]) -> Surfaces:
    """The surface of each block, and where it lies inside others."""
    corners = vertices.astype(np.float64)[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(across, axis=-1)
    normals = across / np.maximum(doubled, np.finfo(np.float64).tiny)[:, None]
    parts = [slice(block.first_face, block.first_face + block.face_count) for block in blocks]
    points = np.concatenate([_spread(corners[part], doubled[part]) for part in parts])
    above = normals @ points.T - (normals * corners[:, 0]).sum(-1)[:, None]
    # The highest above any face of a convex part tells whether it is outside.
    highest = np.maximum.reduceat(above, [part.start for part in parts], axis=0)
    areas = np.array([doubled[part].sum() / 2 for part in parts])
    return Surfaces(areas, (highest <= _TOUCHING).reshape(len(parts), len(parts), POINTS))


def _spread(corners: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points [POINTS, 3] evenly over triangles [F, 3, 3]: at equal steps along their areas, and by a sequence within
    each."""
    along = np.cumsum(weights)
    steps = (np.arange(POINTS) + 0.5) / POINTS * along[-1]
    first, second, third = corners[np.minimum(np.searchsorted(along, steps), len(weights) - 1)].transpose(1, 0, 2)
    # Inverse powers of the real root of x³ = x + 1: the evenest sequence of points in a square.
    u, v = np.modf(np.outer((0.7548776662466927, 0.5698402909980532), np.arange(1, POINTS + 1)))[0]
    u, v = np.where(u + v > 1, (1 - u, 1 - v), (u, v))
    points: NDArray[np.float64] = first + u[:, None] * (second - first) + v[:, None] * (third - first)
    return points
