"""Which face is seen at a point."""

import torch
import triton
import triton.language as tl
from jaxtyping import Int32
from torch import Tensor

from trainer.rendering import borders
from trainer.rendering.triton_kernels.geometry import Records
from trainer.rendering.triton_kernels.lanes import lanes

RECORD = tl.constexpr(18)
BOX = tl.constexpr(12)
DEPTH = tl.constexpr(9)
TIE = tl.constexpr(borders.TIE)


def visible_faces(records: Records, width: int, height: int) -> Int32[Tensor, "N H W"]:
    """The face seen at each pixel's centre; -1 for none."""
    meshes, faces = records.sides.shape
    visible = torch.empty((meshes, height, width), dtype=torch.int32, device=records.faces.device)
    side = int(lanes(256) ** 0.5)
    grid = (triton.cdiv(width, side) * triton.cdiv(height, side), meshes)
    _visible[grid](records.faces, records.sides, visible, faces, width, height, TILE=side, enable_fp_fusion=False)
    return visible


@triton.jit
def _visible(records, sides, visible, faces, width, height, TILE: tl.constexpr):
    mesh = tl.program_id(1).to(tl.int64)
    across = tl.cdiv(width, TILE)
    left, top = tl.program_id(0) % across * TILE, tl.program_id(0) // across * TILE
    pixel = tl.arange(0, TILE * TILE)
    column, row = left + pixel % TILE, top + pixel // TILE
    x, y = column.to(tl.float64) + 0.5, row.to(tl.float64) + 0.5
    box = left.to(tl.float64), top.to(tl.float64), (left + TILE).to(tl.float64), (top + TILE).to(tl.float64)
    seen = nearest_faces(records + mesh * faces * RECORD, sides + mesh * faces, faces, x, y, box)
    tl.store(visible + (mesh * height + row) * width + column, seen, mask=(column < width) & (row < height))


@triton.jit
def nearest_faces(records, sides, faces, x, y, box):
    """The nearest face of one mesh at points that lie in a box; of faces at one depth, up to rounding, the first.

    A point on an edge belongs to the face on the edge's positive side.
    """
    left, top, right, bottom = box
    nearest = tl.zeros_like(x)
    seen = tl.zeros_like(x).to(tl.int32) - 1
    for face in range(faces):
        record = records + face * RECORD
        beside = (tl.load(record + BOX) > right) | (tl.load(record + BOX + 2) < left)
        beside = beside | (tl.load(record + BOX + 1) > bottom) | (tl.load(record + BOX + 3) < top)
        if not beside:
            side = tl.load(sides + face)
            inside = tl.full(x.shape, 1, tl.int1)
            for c in tl.static_range(3):
                a, b, constant = tl.load(record + 3 * c + 1), tl.load(record + 3 * c + 2), tl.load(record + 3 * c)
                inside = inside & ((a * x + b * y + constant >= 0) == ((side >> c) % 2 == 1))
            p, q, r = tl.load(record + DEPTH), tl.load(record + DEPTH + 1), tl.load(record + DEPTH + 2)
            depth = p + (q * x + r * y)
            wins = inside & (depth > nearest * TIE)
            nearest, seen = tl.where(wins, depth, nearest), tl.where(wins, face, seen)
    return seen
