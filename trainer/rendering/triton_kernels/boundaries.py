"""What pieces add to the colours that their pixels' centres see, and the adjoint."""

import torch
import triton
import triton.language as tl
from jaxtyping import Float
from torch import Tensor

from trainer.rendering.triton_kernels.colouring import (
    add_to_plane,
    colour_around,
    colour_around_gradient,
    depth_around,
)
from trainer.rendering.triton_kernels.cuts import Cuts
from trainer.rendering.triton_kernels.geometry import Records
from trainer.rendering.triton_kernels.lanes import lanes
from trainer.rendering.triton_kernels.pieces import Pieces
from trainer.rendering.triton_kernels.segments import Segments
from trainer.rendering.triton_kernels.shadow import shadow, shadow_gradient


def add_boundaries(
    screen: Float[Tensor, "N V 3"],
    lines: Float[Tensor, "L 3"],
    planes: Float[Tensor, "N F P 3"],
    records: Records,
    segments: Segments,
    cuts: Cuts,
    pieces: Pieces,
    picture: Float[Tensor, "N C H W"],
) -> None:
    """Adds the change at every piece to the picture."""
    total, (_, channels, height, width) = len(pieces.pixel), picture.shape
    block = lanes(128)
    _add[(triton.cdiv(total, block),)](
        *pieces, cuts.segment, cuts.line, segments.mesh, segments.line, screen, lines, planes, records.faces, picture,
        total, screen.shape[1], planes.shape[1], channels, width, height, BLOCK=block,
    )  # fmt: skip


def boundaries_gradient(
    screen: Float[Tensor, "N V 3"],
    lines: Float[Tensor, "L 3"],
    planes: Float[Tensor, "N F P 3"],
    records: Records,
    segments: Segments,
    cuts: Cuts,
    pieces: Pieces,
    upstream: Float[Tensor, "N C H W"],
    plane_gradient: Float[Tensor, "N F P 3"],
) -> tuple[Float[Tensor, "N V 3"], Float[Tensor, "L 3"]]:
    """Gradients of `add_boundaries` by `screen` and `lines`; those by `planes` are added to `plane_gradient`."""
    total, (_, channels, height, width) = len(pieces.pixel), upstream.shape
    to_screen, to_lines = torch.zeros_like(screen), torch.zeros_like(lines)
    block = lanes(128)
    _gradient[(triton.cdiv(total, block),)](
        *pieces, cuts.segment, cuts.line, segments.mesh, segments.line, screen, lines, planes, records.faces, upstream,
        to_screen, to_lines, plane_gradient,
        total, screen.shape[1], planes.shape[1], channels, width, height, BLOCK=block,
    )  # fmt: skip
    return to_screen, to_lines


@triton.jit(do_not_specialize=["total"])
def _add(
    pixels, piece_ends, piece_faces, cut_segment, cut_line, segment_mesh, segment_line, screen, lines, planes, records,
    picture, total, vertices, faces, channels, width, height, BLOCK: tl.constexpr,
):  # fmt: skip
    cut = tl.program_id(0).to(tl.int64) * BLOCK + tl.arange(0, BLOCK)
    pixel = tl.load(pixels + cut, cut < total, -1)
    valid = pixel >= 0
    x, y = (pixel % width).to(tl.float64) + 0.5, (pixel // width).to(tl.float64) + 0.5
    segment = tl.load(cut_segment + cut, valid, 0)
    mesh = tl.load(segment_mesh + segment, valid, 0).to(tl.int64)
    own = lines + 3 * tl.load(segment_line + segment, valid, 0)
    vertex = screen + mesh * vertices * 3
    ax, ay = _end(tl.load(cut_line + cut, valid, -1), own, lines, vertex, valid)
    bx, by = _end(tl.load(cut_line + tl.load(piece_ends + cut, valid, 0), valid, -1), own, lines, vertex, valid)
    area, moment_x, moment_y = shadow(ax - x, ay - y, bx - x, by - y)
    for which in tl.static_range(2):
        face = tl.load(piece_faces + 2 * cut + which, valid, -1)
        seen, row = valid & (face >= 0), mesh * faces + face
        _, depth, depth_x, depth_y, first = depth_around(planes, records, row, channels, x, y, seen)
        plane = planes + row * (1 + 2 * channels) * 3 + first
        for c in range(channels):
            value, slope_x, slope_y = colour_around(plane + 3 * c, depth, depth_x, depth_y, x, y, seen)
            change = (2 * which - 1) * (area * value + moment_x * slope_x + moment_y * slope_y)
            at = picture + (mesh * channels + c) * width * height + pixel
            tl.atomic_add(at, change, mask=seen)


@triton.jit(do_not_specialize=["total"])
def _gradient(
    pixels, piece_ends, piece_faces, cut_segment, cut_line, segment_mesh, segment_line, screen, lines, planes, records,
    upstream, to_screen, to_lines, to_planes, total, vertices, faces, channels, width, height, BLOCK: tl.constexpr,
):  # fmt: skip
    cut = tl.program_id(0).to(tl.int64) * BLOCK + tl.arange(0, BLOCK)
    pixel = tl.load(pixels + cut, cut < total, -1)
    valid = pixel >= 0
    x, y = (pixel % width).to(tl.float64) + 0.5, (pixel // width).to(tl.float64) + 0.5
    segment = tl.load(cut_segment + cut, valid, 0)
    mesh = tl.load(segment_mesh + segment, valid, 0).to(tl.int64)
    line = 3 * tl.load(segment_line + segment, valid, 0)
    vertex = mesh * vertices * 3
    start = tl.load(cut_line + cut, valid, -1)
    end = tl.load(cut_line + tl.load(piece_ends + cut, valid, 0), valid, -1)
    ax, ay = _end(start, lines + line, lines, screen + vertex, valid)
    bx, by = _end(end, lines + line, lines, screen + vertex, valid)
    area, moment_x, moment_y = shadow(ax - x, ay - y, bx - x, by - y)
    to_area, to_moment_x, to_moment_y = 0.0 * area, 0.0 * area, 0.0 * area
    for which in tl.static_range(2):
        face = tl.load(piece_faces + 2 * cut + which, valid, -1)
        seen, row = valid & (face >= 0), mesh * faces + face
        tangent, depth, depth_x, depth_y, first = depth_around(planes, records, row, channels, x, y, seen)
        offset = row * (1 + 2 * channels) * 3
        to_depth, to_depth_x, to_depth_y = 0.0 * area, 0.0 * area, 0.0 * area
        for c in range(channels):
            plane = offset + first + 3 * c
            value, slope_x, slope_y = colour_around(planes + plane, depth, depth_x, depth_y, x, y, seen)
            at = upstream + (mesh * channels + c) * width * height + pixel
            to_change = (2 * which - 1) * tl.load(at, seen, 0.0).to(tl.float64)
            to_area += to_change * value
            to_moment_x += to_change * slope_x
            to_moment_y += to_change * slope_y
            one, two, three = colour_around_gradient(
                to_planes + plane, value, slope_x, slope_y, depth, depth_x, depth_y,
                to_change * area, to_change * moment_x, to_change * moment_y, x, y, seen,
            )  # fmt: skip
            to_depth, to_depth_x, to_depth_y = to_depth + one, to_depth_x + two, to_depth_y + three
        add_to_plane(to_planes + offset, to_depth, to_depth_x, to_depth_y, x, y, tangent)
    to_ax, to_ay, to_bx, to_by = shadow_gradient(ax - x, ay - y, bx - x, by - y, to_area, to_moment_x, to_moment_y)
    _end_gradient(start, ax, ay, to_ax, to_ay, line, lines, to_lines, to_screen + vertex, valid)
    _end_gradient(end, bx, by, to_bx, to_by, line, lines, to_lines, to_screen + vertex, valid)


@triton.jit
def _line(code, lines, mask):
    """Coefficients of a cutting line: one of the mesh's, or a pixel boundary."""
    line, boundary = lines + 3 * code, ((-1 - code) // 3).to(tl.float64)
    drawn, kind = mask & (code >= 0), (-1 - code) % 3
    is_column, is_row = (code < 0) & (kind == 1), (code < 0) & (kind == 2)
    a = tl.load(line, drawn, 0.0) - tl.where(is_column | is_row, boundary, 0.0)
    b = tl.load(line + 1, drawn, 0.0) + tl.where(is_column, 1.0, 0.0)
    c = tl.load(line + 2, drawn, 0.0) + tl.where(is_row, 1.0, 0.0)
    return a, b, c


@triton.jit
def _end(code, own, lines, vertices, mask):
    """Where a line is cut: at a vertex, or by another line."""
    vertex = mask & (code < 0) & ((-1 - code) % 3 == 0)
    at = vertices + 3 * ((-1 - code) // 3)
    a, b, c = tl.load(own, mask, 0.0), tl.load(own + 1, mask, 0.0), tl.load(own + 2, mask, 0.0)
    a2, b2, c2 = _line(code, lines, mask)
    scale = b * c2 - c * b2
    scale = tl.where(scale == 0, 1.0, scale)
    x, y = (c * a2 - a * c2) / scale, (a * b2 - b * a2) / scale
    return tl.where(vertex, tl.load(at, vertex, 0.0), x), tl.where(vertex, tl.load(at + 1, vertex, 0.0), y)


@triton.jit
def _end_gradient(code, x, y, to_x, to_y, own, lines, to_lines, to_vertices, mask):
    """Hands the gradient of an end on to its vertex or to both lines."""
    vertex = mask & (code < 0) & ((-1 - code) % 3 == 0)
    at = to_vertices + 3 * ((-1 - code) // 3)
    tl.atomic_add(at, to_x, mask=vertex)
    tl.atomic_add(at + 1, to_y, mask=vertex)
    a, b, c = tl.load(lines + own, mask, 0.0), tl.load(lines + own + 1, mask, 0.0), tl.load(lines + own + 2, mask, 0.0)
    a2, b2, c2 = _line(code, lines, mask)
    scale = b * c2 - c * b2
    scale = tl.where(scale == 0, 1.0, scale)
    to_x, to_y, to_scale = to_x / scale, to_y / scale, -(to_x * x + to_y * y) / scale
    crossed = mask & (vertex == 0)
    tl.atomic_add(to_lines + own, b2 * to_y - c2 * to_x, mask=crossed)
    tl.atomic_add(to_lines + own + 1, c2 * to_scale - a2 * to_y, mask=crossed)
    tl.atomic_add(to_lines + own + 2, a2 * to_x - b2 * to_scale, mask=crossed)
    moving = mask & (code >= 0)
    tl.atomic_add(to_lines + 3 * code, c * to_x - b * to_y, mask=moving)
    tl.atomic_add(to_lines + 3 * code + 1, a * to_y - c * to_scale, mask=moving)
    tl.atomic_add(to_lines + 3 * code + 2, b * to_scale - a * to_x, mask=moving)
