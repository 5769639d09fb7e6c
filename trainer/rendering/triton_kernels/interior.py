"""The colour that each pixel's centre sees, and its adjoint."""

import torch
import triton
import triton.language as tl
from jaxtyping import Float, Int32
from torch import Tensor

from trainer.rendering.triton_kernels.geometry import Records
from trainer.rendering.triton_kernels.lanes import lanes, tile
from trainer.rendering.triton_kernels.nearest import BOX, RECORD


def interior(planes: Float[Tensor, "N F P 3"], visible: Int32[Tensor, "N H W"]) -> Float[Tensor, "N C H W"]:
    """Perspective-correct colours of the faces seen at the centres, on black, in float64."""
    meshes, faces, count, _ = planes.shape
    _, height, width = visible.shape
    picture = torch.empty((meshes, count // 2, height, width), dtype=torch.float64, device=visible.device)
    block = lanes(256)
    grid = (triton.cdiv(height * width, block), meshes)
    _interior[grid](planes, visible, picture, faces, count // 2, width, height, BLOCK=block)
    return picture


def interior_gradient(
    planes: Float[Tensor, "N F P 3"],
    records: Records,
    visible: Int32[Tensor, "N H W"],
    upstream: Float[Tensor, "N C H W"],
) -> Float[Tensor, "N F P 3"]:
    """Gradient of `interior` with respect to the planes. Each face gathers from the pixels of its box: no atomics."""
    meshes, faces, count, _ = planes.shape
    _, height, width = visible.shape
    gradient = torch.zeros_like(planes)
    rows, pixels = tile(4, 32)
    _interior_gradient[(triton.cdiv(faces, rows), meshes)](
        planes, records.faces, visible, upstream, gradient, faces, count // 2, width, height,
        FACES=rows, PIXELS=pixels, num_warps=4,
    )  # fmt: skip
    return gradient


@triton.jit
def _interior(planes, visible, picture, faces, channels, width, height, BLOCK: tl.constexpr):
    mesh = tl.program_id(1).to(tl.int64)
    pixel = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    within = pixel < width * height
    face = tl.load(visible + mesh * width * height + pixel, mask=within, other=-1)
    seen = face >= 0
    x, y = (pixel % width).to(tl.float64) + 0.5, (pixel // width).to(tl.float64) + 0.5
    plane = planes + (mesh * faces + face) * (1 + 2 * channels) * 3
    p, q, r = _plane(plane, seen)
    depth = tl.where(seen, p + q * x + r * y, 1.0)
    for c in range(channels):
        p, q, r = _plane(plane + 3 * (1 + c), seen)
        colour = (p + q * x + r * y) / depth
        tl.store(picture + (mesh * channels + c) * width * height + pixel, colour, mask=within)


@triton.jit
def _interior_gradient(
    planes, records, visible, upstream, gradient, faces, channels, width, height,
    FACES: tl.constexpr, PIXELS: tl.constexpr,
):  # fmt: skip
    mesh = tl.program_id(1).to(tl.int64)
    face = tl.program_id(0) * FACES + tl.arange(0, FACES)[:, None]
    valid = face < faces
    box = records + (mesh * faces + face) * RECORD + BOX
    left, columns = _pixels(tl.load(box, valid, 1.0), tl.load(box + 2, valid, 0.0), width)
    top, rows = _pixels(tl.load(box + 1, valid, 1.0), tl.load(box + 3, valid, 0.0), height)
    offset = (mesh * faces + face) * (1 + 2 * channels) * 3
    p, q, r = _plane(planes + offset, valid)
    depth_1 = tl.zeros((FACES, 1), tl.float64)
    depth_x, depth_y = depth_1, depth_1
    for c in range(channels):
        weighted_p, weighted_q, weighted_r = _plane(planes + offset + 3 * (1 + c), valid)
        to_1 = tl.zeros((FACES, PIXELS), tl.float64)
        to_x, to_y, to_depth_1, to_depth_x, to_depth_y = to_1, to_1, to_1, to_1, to_1
        for start in range(0, tl.max(columns * rows), PIXELS):
            index = start + tl.arange(0, PIXELS)[None, :]
            column, row = left + index % tl.maximum(columns, 1), top + index // tl.maximum(columns, 1)
            pixel, within = row * width + column, index < columns * rows
            seen = tl.load(visible + mesh * width * height + pixel, within, -1) == face
            x, y = column.to(tl.float64) + 0.5, row.to(tl.float64) + 0.5
            depth = tl.where(seen, p + q * x + r * y, 1.0)
            colour = (weighted_p + weighted_q * x + weighted_r * y) / depth
            at = upstream + (mesh * channels + c) * width * height + pixel
            to_weighted = tl.load(at, seen, 0.0).to(tl.float64) / depth
            to_depth = -to_weighted * colour
            to_1, to_x, to_y = to_1 + to_weighted, to_x + to_weighted * x, to_y + to_weighted * y
            to_depth_1, to_depth_x = to_depth_1 + to_depth, to_depth_x + to_depth * x
            to_depth_y += to_depth * y
        _store_sums(gradient + offset + 3 * (1 + c), to_1, to_x, to_y, valid)
        depth_1, depth_x = depth_1 + _sum(to_depth_1), depth_x + _sum(to_depth_x)
        depth_y += _sum(to_depth_y)
    _store_sums(gradient + offset, depth_1, depth_x, depth_y, valid)


@triton.jit
def _pixels(low, high, size):
    """The first pixel whose centre may lie between two coordinates, and how many there are."""
    first, last = tl.maximum(tl.floor(low - 0.5), 0.0), tl.minimum(tl.ceil(high - 0.5), size - 1)
    within = first <= last
    return tl.where(within, first, 0.0).to(tl.int32), tl.where(within, last - first + 1, 0.0).to(tl.int32)


@triton.jit
def _plane(plane, mask):
    return tl.load(plane, mask, 0.0), tl.load(plane + 1, mask, 0.0), tl.load(plane + 2, mask, 0.0)


@triton.jit
def _sum(values):
    return tl.sum(values, 1)[:, None]


@triton.jit
def _store_sums(gradient, to_1, to_x, to_y, mask):
    tl.store(gradient, _sum(to_1), mask=mask)
    tl.store(gradient + 1, _sum(to_x), mask=mask)
    tl.store(gradient + 2, _sum(to_y), mask=mask)
