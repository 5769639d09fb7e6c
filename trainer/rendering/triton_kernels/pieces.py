"""The parts of segments inside one pixel along which two faces, one of them their own, meet in what is seen."""

from typing import NamedTuple

import torch
import triton
import triton.language as tl
from jaxtyping import Int32, Int64
from torch import Tensor

from trainer.rendering import borders
from trainer.rendering.triton_kernels.cuts import Cuts
from trainer.rendering.triton_kernels.geometry import Records
from trainer.rendering.triton_kernels.lanes import lanes
from trainer.rendering.triton_kernels.nearest import RECORD, nearest_faces
from trainer.rendering.triton_kernels.segments import Segments

ASIDE = tl.constexpr(borders.ASIDE)


class Pieces(NamedTuple):
    """Piece k begins at cut k; not every cut begins one."""

    pixel: Int32[Tensor, "K"]
    """row · width + column; -1: there is no such piece."""
    end: Int64[Tensor, "K"]
    """The cut at which it ends."""
    faces: Int32[Tensor, "K 2"]
    """Seen on the side of the pixel's centre, and beyond; -1: the background."""


def pieces_of(records: Records, segments: Segments, cuts: Cuts, edge_lines: int, width: int, height: int) -> Pieces:
    """For each cut, the piece that begins there. The first `edge_lines` lines are edges, the others crossings."""
    meshes, faces = records.sides.shape
    total = len(cuts.line)
    # What nothing is written to is no piece.
    pixel = cuts.line.new_full((total,), -1)
    pieces = Pieces(pixel, pixel.new_empty(total, dtype=torch.int64), pixel.new_empty((total, 2)))
    block = lanes(64)
    programs = max(1, triton.cdiv(total, block * max(meshes, 1)))
    _pieces[(programs, meshes)](
        *pieces, *cuts[:-1], segments.offsets, segments.line, segments.ends, segments.faces,
        records.faces, records.sides, edge_lines, faces, width, height,
        BLOCK=block, num_warps=2, enable_fp_fusion=False,
    )  # fmt: skip
    return pieces


@triton.jit(do_not_specialize=["edge_lines"])
def _pieces(
    pixels, piece_ends, piece_faces, cut_offsets, cut_segment, cut_position, segment_offsets, segment_lines,
    segment_ends, segment_faces, records, sides, edge_lines, faces, width, height, BLOCK: tl.constexpr,
):  # fmt: skip
    mesh = tl.program_id(1).to(tl.int64)
    records, sides = records + mesh * faces * RECORD, sides + mesh * faces
    first = tl.load(cut_offsets + tl.load(segment_offsets + mesh))
    last = tl.load(cut_offsets + tl.load(segment_offsets + mesh + 1))
    for start in range(first + tl.program_id(0) * BLOCK, last, BLOCK * tl.num_programs(0)):
        cut = start + tl.arange(0, BLOCK)
        valid = cut < last
        segment = tl.load(cut_segment + cut, valid, 0).to(tl.int64)
        t = tl.load(cut_position + cut, valid, 0.0)
        end, t_end = _next_cut(cut_offsets, cut_position, segment, cut, t, valid)
        at = segment_ends + 4 * segment
        along_x, along_y = tl.load(at + 2, valid, 1.0), tl.load(at + 3, valid, 1.0)
        x, y = tl.load(at, valid, 0.0), tl.load(at + 1, valid, 0.0)
        along_x, along_y = along_x - x, along_y - y
        middle_x, middle_y = x + 0.5 * (t + t_end) * along_x, y + 0.5 * (t + t_end) * along_y
        inside = valid & (end >= 0) & (middle_x >= 0) & (middle_y >= 0) & (middle_x < width) & (middle_y < height)
        middle_x, middle_y = tl.where(inside, middle_x, 0.0), tl.where(inside, middle_y, 0.0)
        column, row = tl.floor(middle_x), tl.floor(middle_y)
        # A step away from the centre, along the normal.
        length = tl.sqrt(along_x * along_x + along_y * along_y)
        scale = ASIDE / tl.where(length == 0, 1.0, length)
        step_x, step_y = -along_y * scale, along_x * scale
        inwards = step_x * (column + 0.5 - middle_x) + step_y * (row + 0.5 - middle_y) > 0
        step_x, step_y = tl.where(inwards, -step_x, step_x), tl.where(inwards, -step_y, step_y)
        beside_x = tl.join(middle_x - step_x, middle_x + step_x)
        beside_y = tl.join(middle_y - step_y, middle_y + step_y)
        left, right = _range(middle_x, inside)
        top, bottom = _range(middle_y, inside)
        here, beyond = tl.split(nearest_faces(records, sides, faces, beside_x, beside_y, (left, top, right, bottom)))
        own, other = tl.load(segment_faces + 2 * segment, valid, 0), tl.load(segment_faces + 2 * segment + 1, valid, 0)
        own_here, own_beyond = (here == own) | (here == other), (beyond == own) | (beyond == other)
        # Where two faces interpenetrate it is they that must be seen; an edge may be seen against anything.
        is_crossing = tl.load(segment_lines + segment, valid, 0) >= edge_lines
        counts = (here != beyond) & tl.where(is_crossing, own_here & own_beyond, own_here | own_beyond)
        pixel = row.to(tl.int32) * width + column.to(tl.int32)
        tl.store(pixels + cut, tl.where(inside & counts, pixel, -1), mask=valid)
        tl.store(piece_ends + cut, end, mask=valid)
        tl.store(piece_faces + 2 * cut, here, mask=valid)
        tl.store(piece_faces + 2 * cut + 1, beyond, mask=valid)


@triton.jit
def _next_cut(cut_offsets, cut_position, segment, cut, t, valid):
    """The nearest of a segment's cuts after position t, and its position; -1 if `cut` is not the last of those at t."""
    first = tl.load(cut_offsets + segment, valid, 0)
    last = tl.load(cut_offsets + segment + 1, valid, 0)
    end, t_end = tl.full(t.shape, -1, tl.int64), tl.full(t.shape, float("inf"), tl.float64)
    alone = valid
    for index in range(0, tl.max(last - first)):
        other = first + index
        t_other = tl.load(cut_position + other, other < last, -1.0)
        sooner = (t_other > t) & (t_other < t_end)
        end, t_end = tl.where(sooner, other, end), tl.where(sooner, t_other, t_end)
        alone = alone & ((t_other != t) | (other <= cut))
    return tl.where(alone, end, -1), tl.where(end >= 0, t_end, t)


@triton.jit
def _range(values, mask):
    """Least and greatest of the values where the mask is set, a little widened."""
    low = tl.min(tl.where(mask, values, float("inf")))
    high = tl.max(tl.where(mask, values, float("-inf")))
    return low - 2 * ASIDE, high + 2 * ASIDE
