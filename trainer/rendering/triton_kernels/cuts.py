"""Where pixel boundaries and other segments cut a segment."""

from typing import NamedTuple

import torch
import triton
import triton.language as tl
from jaxtyping import Float, Int32, Int64
from torch import Tensor

from trainer import recording
from trainer.rendering import borders
from trainer.rendering.triton_kernels.lanes import tile
from trainer.rendering.triton_kernels.segments import Segments

INTERIOR = tl.constexpr(borders.INTERIOR)
PARALLEL = tl.constexpr(borders.PARALLEL)


class Cuts(NamedTuple):
    """Those of segment s, both its ends among them, are numbers offsets[s] to offsets[s + 1], in no order."""

    offsets: Int64[Tensor, "S+1"]
    segment: Int32[Tensor, "K"]
    position: Float[Tensor, "K"]
    """From 0 at the segment's start to 1 at its end."""
    line: Int32[Tensor, "K"]
    """What cuts there: a line; or -1 - 3v for vertex v, -2 - 3k for column boundary k, -3 - 3k for row boundary k."""


def cuts_of(segments: Segments, width: int, height: int) -> Cuts:
    """All cuts; where there is more room than they need, the rest are of no segment."""
    slots = len(segments.line)
    offsets = torch.zeros(slots + 1, dtype=torch.int64, device=segments.line.device)
    _launch(segments, offsets[1:], None, width, height)
    offsets = offsets.cumsum(0)
    room = recording.length(offsets[-1])
    zeros = segments.ends.new_zeros
    kinds = (torch.int32, torch.float64, torch.int32)
    cuts = Cuts(offsets.clamp(max=room), *(zeros(room, dtype=kind) for kind in kinds))
    _launch(segments, offsets, cuts, width, height)
    return cuts


def _launch(segments: Segments, counts: Int64[Tensor, "S"], cuts: Cuts | None, width: int, height: int) -> None:
    meshes, (rows, others) = len(segments.offsets) - 1, tile(4, 32)
    unused = segments.line, segments.ends, segments.line
    _cuts[(triton.cdiv(len(segments.line), rows * meshes), meshes)](
        segments.offsets, *segments[2:-1], counts, *(unused if cuts is None else cuts[1:]),
        0 if cuts is None else len(cuts.line), width, height,
        FILL=cuts is not None, SEGMENTS=rows, OTHERS=others, num_warps=1, enable_fp_fusion=False,
    )  # fmt: skip


@triton.jit(do_not_specialize=["room"])
def _cuts(
    offsets, lines, ends, ended_by, counts, cut_segment, cut_position, cut_line, room, width, height,
    FILL: tl.constexpr, SEGMENTS: tl.constexpr, OTHERS: tl.constexpr,
):  # fmt: skip
    """Counts the cuts of one mesh's segments; with FILL, writes those of a segment from counts[segment] on, as far as
    there is room."""
    first, last = tl.load(offsets + tl.program_id(1)), tl.load(offsets + tl.program_id(1) + 1)
    lane = tl.arange(0, OTHERS)[None, :]
    for start in range(first + tl.program_id(0) * SEGMENTS, last, SEGMENTS * tl.num_programs(0)):
        segment = start + tl.arange(0, SEGMENTS)[:, None]
        valid = segment < last
        x, y = tl.load(ends + 4 * segment, valid, 0.0), tl.load(ends + 4 * segment + 1, valid, 0.0)
        end_x, end_y = tl.load(ends + 4 * segment + 2, valid, 0.0), tl.load(ends + 4 * segment + 3, valid, 0.0)
        along_x, along_y = end_x - x, end_y - y
        left, columns = _boundaries(x, end_x, width)
        top, rows = _boundaries(y, end_y, height)
        found = tl.load(counts + segment, valid, 0) if FILL else tl.zeros((SEGMENTS, 1), tl.int64)
        if FILL:
            for skipped in range(0, 2 + tl.max(columns + rows), OTHERS):
                index = skipped + lane - 2
                place, within = found + 2 + index, valid & (index < columns + rows)
                is_end, is_column = index < 0, index < columns
                boundary = tl.where(is_column, left + index, top + index - columns)
                across = tl.where(is_column, along_x, along_y)
                t = (boundary.to(tl.float64) - tl.where(is_column, x, y)) / tl.where(across == 0, 1.0, across)
                code = -3 * boundary - tl.where(is_column, 2, 3)
                end_code = tl.load(ended_by + 2 * segment + index + 2, within & is_end, 0)
                written = within & (place < room)
                tl.store(cut_segment + place, segment + 0 * index, mask=written)
                tl.store(cut_position + place, tl.where(is_end, (index + 2).to(tl.float64), t), mask=written)
                tl.store(cut_line + place, tl.where(is_end, end_code, code), mask=written)
        found += 2 + columns + rows
        for other_start in range(first, last, OTHERS):
            other = other_start + lane
            known = other < last
            other_x, other_y = tl.load(ends + 4 * other, known, 0.0), tl.load(ends + 4 * other + 1, known, 0.0)
            across_x = tl.load(ends + 4 * other + 2, known, 0.0) - other_x
            across_y = tl.load(ends + 4 * other + 3, known, 0.0) - other_y
            apart_x, apart_y = other_x - x, other_y - y
            determinant = along_x * across_y - along_y * across_x
            divisor = tl.where(determinant == 0, 1.0, determinant)
            t = (apart_x * across_y - apart_y * across_x) / divisor
            u = (apart_x * along_y - apart_y * along_x) / divisor
            lengths = tl.sqrt(along_x * along_x + along_y * along_y) * tl.sqrt(
                across_x * across_x + across_y * across_y
            )
            cut = valid & known & (other != segment) & (tl.abs(determinant) > lengths * PARALLEL)
            # A literal is rounded to float32 where it is compared: 1 - INTERIOR would be 1.
            cut &= (t > INTERIOR) & (t - 1 < -INTERIOR) & (u >= -INTERIOR) & (u - 1 <= INTERIOR)
            hits = cut.to(tl.int64)
            if FILL:
                place = found + tl.cumsum(hits, 1) - hits
                written = cut & (place < room)
                tl.store(cut_segment + place, segment + 0 * other, mask=written)
                tl.store(cut_position + place, t, mask=written)
                tl.store(cut_line + place, tl.load(lines + other, known, 0) + 0 * segment, mask=written)
            found += tl.sum(hits, 1)[:, None]
        if not FILL:
            tl.store(counts + segment, found, mask=valid)


@triton.jit
def _boundaries(start, end, size):
    """The first pixel boundary of the picture strictly between two coordinates, and how many there are."""
    first = tl.maximum(tl.floor(tl.minimum(start, end)) + 1, 0.0)
    last = tl.minimum(tl.ceil(tl.maximum(start, end)) - 1, size)
    within = first <= last
    return tl.where(within, first, 0.0).to(tl.int32), tl.where(within, last - first + 1, 0.0).to(tl.int32)
