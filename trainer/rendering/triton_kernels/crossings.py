"""Where two faces of a mesh that share no edge interpenetrate."""

from typing import NamedTuple

import torch
import triton
import triton.language as tl
from jaxtyping import Bool, Float, Int32, Int64
from torch import Tensor

from trainer import recording
from trainer.rendering import borders
from trainer.rendering.triton_kernels.geometry import Geometry, Records
from trainer.rendering.triton_kernels.lanes import lanes, tile
from trainer.rendering.triton_kernels.mesh import Mesh
from trainer.rendering.triton_kernels.nearest import BOX, DEPTH, RECORD

SHORTEST = tl.constexpr(borders.SHORTEST)


class Crossings(NamedTuple):
    """Lines in which the planes of two faces meet, as far as both faces reach; ordered by mesh."""

    mesh: Int32[Tensor, "X"]
    faces: Int32[Tensor, "X 2"]
    ends: Float[Tensor, "X 4"]
    """x and y of the start, then of the end."""
    ended_by: Int32[Tensor, "X 2"]
    """The edge of either face that ends it there."""
    long: Bool[Tensor, "X"]
    """Whether anything is left of it between those edges."""


def crossings(geometry: Geometry, records: Records, mesh: Mesh) -> Crossings:
    """The lines of all meshes; where there is more room than they need, the rest are of mesh 0, and not `long`."""
    faces = len(mesh.faces)
    counts = torch.zeros(records.sides.numel(), dtype=torch.int64, device=records.faces.device)
    _launch_pairs(geometry, records, mesh, counts, None)
    offsets = counts.cumsum(0)
    room = recording.length(offsets[-1])
    pairs = torch.zeros((room, 2), dtype=torch.int64, device=counts.device)
    _launch_pairs(geometry, records, mesh, offsets - counts, pairs)
    found = Crossings(
        (pairs[:, 0] // faces).int(),
        torch.stack((pairs[:, 0] % faces, pairs[:, 1]), 1).int(),
        pairs.new_zeros((room, 4), dtype=torch.float64),
        pairs.new_zeros((room, 2), dtype=torch.int32),
        pairs.new_zeros(room, dtype=torch.bool),
    )
    block = lanes(64)
    _clip[(triton.cdiv(room, block),)](
        *found, geometry.screen, records.faces, mesh.faces, mesh.edges, mesh.face_edges,
        offsets[-1], room, geometry.screen.shape[1], faces, BLOCK=block, num_warps=2, enable_fp_fusion=False,
    )  # fmt: skip
    return found


def no_crossings(geometry: Geometry) -> Crossings:
    """Of pictures in which contours alone are antialiased."""
    none = geometry.screen.new_empty(0)
    return Crossings(none.int(), none.int().reshape(0, 2), none.reshape(0, 4), none.int().reshape(0, 2), none.bool())


def _launch_pairs(
    geometry: Geometry, records: Records, mesh: Mesh, counts: Int64[Tensor, "N*F"], pairs: Int64[Tensor, "X 2"] | None
) -> None:
    screen, (meshes, faces) = geometry.screen, records.sides.shape
    margin = borders.SAME_DEPTH * screen[..., 2].amax(1)
    rows, others = tile(4, 32)
    _pairs[(triton.cdiv(faces, rows), meshes)](
        screen, records.faces, mesh.faces, margin, counts, counts if pairs is None else pairs,
        0 if pairs is None else len(pairs), screen.shape[1], faces,
        FILL=pairs is not None, FACES=rows, OTHERS=others, num_warps=4, enable_fp_fusion=False,
    )  # fmt: skip


@triton.jit(do_not_specialize=["room"])
def _pairs(
    screen, records, corners, margins, counts, pairs, room, vertices, faces,
    FILL: tl.constexpr, FACES: tl.constexpr, OTHERS: tl.constexpr,
):  # fmt: skip
    """Counts the later faces that each face pierces and is pierced by; with FILL, writes them from counts[face] on, as
    far as there is room."""
    mesh = tl.program_id(1).to(tl.int64)
    screen += mesh * vertices * 3
    records += mesh * faces * RECORD
    margin = tl.load(margins + mesh)
    face = tl.program_id(0) * FACES + tl.arange(0, FACES)[:, None]
    valid = face < faces
    mine = records + face * RECORD
    left, top = tl.load(mine + BOX, valid, 1.0), tl.load(mine + BOX + 1, valid, 1.0)
    right, bottom = tl.load(mine + BOX + 2, valid, 0.0), tl.load(mine + BOX + 3, valid, 0.0)
    row = mesh * faces + face
    found = tl.load(counts + row, valid, 0) if FILL else tl.zeros((FACES, 1), tl.int64)
    for start in range(tl.program_id(0) * FACES + 1, faces, OTHERS):
        other = start + tl.arange(0, OTHERS)[None, :]
        theirs, known = records + other * RECORD, other < faces
        near = (tl.load(theirs + BOX, known, 1.0) <= right) & (tl.load(theirs + BOX + 2, known, 0.0) >= left)
        near &= (tl.load(theirs + BOX + 1, known, 1.0) <= bottom) & (tl.load(theirs + BOX + 3, known, 0.0) >= top)
        near &= valid & known & (other > face)
        if tl.max(near.to(tl.int32)) > 0:
            shared = tl.zeros((FACES, OTHERS), tl.int32)
            for c in tl.static_range(3):
                for d in tl.static_range(3):
                    one, two = tl.load(corners + 3 * face + c, valid, -1), tl.load(corners + 3 * other + d, known, -1)
                    shared += tl.where(one == two, 1, 0)
            low, high = _range_above(screen, mine, corners + 3 * other, valid, known)
            pierced = near & (shared < 2) & (low < -margin) & (high > margin)
            low, high = _range_above(screen, theirs, corners + 3 * face, known, valid)
            pierced &= (low < -margin) & (high > margin)
            hits = pierced.to(tl.int64)
            if FILL:
                place = found + tl.cumsum(hits, 1) - hits
                written = pierced & (place < room)
                tl.store(pairs + 2 * place, row + 0 * hits, mask=written)
                tl.store(pairs + 2 * place + 1, other + 0 * hits, mask=written)
            found += tl.sum(hits, 1)[:, None]
    if not FILL:
        tl.store(counts + row, found, mask=valid)


@triton.jit
def _range_above(screen, record, corners, record_mask, corner_mask):
    """How far, at least and at most, a face's corners lie above the plane of a record."""
    p = tl.load(record + DEPTH, record_mask, 0.0)
    q = tl.load(record + DEPTH + 1, record_mask, 0.0)
    r = tl.load(record + DEPTH + 2, record_mask, 0.0)
    low = _above(screen, p, q, r, corners, corner_mask)
    high = low
    for c in tl.static_range(1, 3):
        above = _above(screen, p, q, r, corners + c, corner_mask)
        low, high = tl.minimum(low, above), tl.maximum(high, above)
    return low, high


@triton.jit
def _above(screen, p, q, r, corner, mask):
    point = screen + 3 * tl.load(corner, mask, 0)
    x, y, depth = tl.load(point, mask, 0.0), tl.load(point + 1, mask, 0.0), tl.load(point + 2, mask, 0.0)
    return depth - (p + q * x + r * y)


@triton.jit(do_not_specialize=["total", "room"])
def _clip(
    meshes, pairs, ends, ended_by, long, screen, records, corners, edges, face_edges,
    total, room, vertices, faces, BLOCK: tl.constexpr,
):  # fmt: skip
    """Cuts the line in which two planes meet down to what lies inside both faces on the screen."""
    index = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    valid = (index < tl.load(total)) & (index < room)
    mesh = tl.load(meshes + index, valid, 0).to(tl.int64)
    screen += mesh * vertices * 3
    one = records + (mesh * faces + tl.load(pairs + 2 * index, valid, 0)) * RECORD + DEPTH
    two = records + (mesh * faces + tl.load(pairs + 2 * index + 1, valid, 0)) * RECORD + DEPTH
    c = tl.load(one, valid, 0.0) - tl.load(two, valid, 0.0)
    a = tl.load(one + 1, valid, 1.0) - tl.load(two + 1, valid, 0.0)
    b = tl.load(one + 2, valid, 1.0) - tl.load(two + 2, valid, 0.0)
    square = a * a + b * b
    foot_x, foot_y = -c * a / square, -c * b / square
    along_x, along_y = -b / tl.sqrt(square), a / tl.sqrt(square)
    first, last = tl.full(a.shape, float("-inf"), tl.float64), tl.full(a.shape, float("inf"), tl.float64)
    first_edge, last_edge = tl.zeros(a.shape, tl.int32), tl.zeros(a.shape, tl.int32)
    for which in tl.static_range(2):
        face = tl.load(pairs + 2 * index + which, valid, 0)
        for side in tl.static_range(3):
            edge = tl.load(face_edges + 3 * face + side, valid, 0)
            start = screen + 3 * tl.load(edges + 2 * edge, valid, 0)
            end = screen + 3 * tl.load(edges + 2 * edge + 1, valid, 0)
            opposite = screen + 3 * tl.load(corners + 3 * face + side, valid, 0)
            x, y = tl.load(start, valid, 0.0), tl.load(start + 1, valid, 0.0)
            inward_x, inward_y = y - tl.load(end + 1, valid, 0.0), tl.load(end, valid, 0.0) - x
            inside = inward_x * (tl.load(opposite, valid, 0.0) - x) + inward_y * (tl.load(opposite + 1, valid, 0.0) - y)
            turn = tl.where(inside > 0, 1.0, tl.where(inside < 0, -1.0, 0.0))
            inward_x, inward_y = inward_x * turn, inward_y * turn
            rate = inward_x * along_x + inward_y * along_y
            at_foot = inward_x * (foot_x - x) + inward_y * (foot_y - y)
            stop = -at_foot / tl.where(rate == 0, 1.0, rate)
            starts, ends_here = (rate > 0) & (stop > first), (rate < 0) & (stop < last)
            first, first_edge = tl.where(starts, stop, first), tl.where(starts, edge, first_edge)
            last, last_edge = tl.where(ends_here, stop, last), tl.where(ends_here, edge, last_edge)
            last = tl.where((rate == 0) & (at_foot < 0), float("-inf"), last)
    tl.store(ends + 4 * index, foot_x + first * along_x, mask=valid)
    tl.store(ends + 4 * index + 1, foot_y + first * along_y, mask=valid)
    tl.store(ends + 4 * index + 2, foot_x + last * along_x, mask=valid)
    tl.store(ends + 4 * index + 3, foot_y + last * along_y, mask=valid)
    tl.store(ended_by + 2 * index, first_edge, mask=valid)
    tl.store(ended_by + 2 * index + 1, last_edge, mask=valid)
    tl.store(long + index, last - first > SHORTEST, mask=valid)
