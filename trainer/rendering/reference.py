"""The renderer written for reading: one mesh at a time, plain torch, any precision. The oracle of every fast backend.

It computes exactly the picture that `docs/renderer.md` defines. What is a decision (which face a point sees, which
lines bound what is seen, where they cross) is taken on detached numbers; what is a number is differentiable torch.
"""

from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor

from rasteriser.pictures import CREASE
from trainer.rendering.borders import THIN, Line, Piece, find_pieces, is_drawn, nearest_faces, thickness


def draw(
    screen: Float[Tensor, "V 3"],
    colours: Float[Tensor, "V C"],
    faces: Int64[Tensor, "F 3"],
    width: int,
    height: int,
    crease: float = CREASE,
) -> Float[Tensor, "C H W"]:
    """The antialiased picture of one mesh on black; differentiable in `screen` (x, y, inverse depth) and `colours`.

    Edges at which the colour's change per pixel jumps by `crease` or more are antialiased too, and where faces
    interpenetrate; if it is infinite, contours alone; if it is negative, nothing.
    """
    fixed, corners = screen.detach().double().cpu().numpy(), faces.cpu().numpy()
    thin = torch.as_tensor(thickness(fixed, corners) < THIN)
    painted = colours[faces]
    painted = torch.where(thin[:, None, None], painted.mean(1, keepdim=True), painted)
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    centres = np.stack((columns, rows), -1).reshape(-1, 2)
    visible = nearest_faces(fixed, corners, centres).reshape(height, width)

    # Black, and a function of the mesh all the same: where nothing is seen, there is a gradient of zero.
    picture = (0.0 * (screen.sum() + colours.sum())).expand(height, width, colours.shape[1])
    row, column = np.nonzero(visible >= 0)
    planes = _planes(screen, painted, faces, fixed, corners)
    if len(row):
        points = torch.as_tensor(np.stack((np.ones(len(row)), column + 0.5, row + 0.5), -1)).to(screen)
        seen = torch.as_tensor(visible[row, column])
        depth = (points * planes.depth[seen]).sum(1, keepdim=True)
        colour = (points[:, :, None] * planes.weighted[seen]).sum(1) / depth
        picture = picture.index_put((torch.as_tensor(row), torch.as_tensor(column)), colour)
    pieces = find_pieces(fixed, planes.linear.detach().cpu().numpy(), corners, width, height, crease)
    if pieces:
        here = torch.tensor([piece.pixel[1] for piece in pieces]), torch.tensor([piece.pixel[0] for piece in pieces])
        picture = picture.index_put(here, _changes(screen, planes, pieces), accumulate=True)
    return picture.permute(2, 0, 1)


def log_likelihood(
    picture: Float[Tensor, "C H W"], target: Float[Tensor, "C H W"], binarise: float = 0.0
) -> Float[Tensor, ""]:
    """Eqs. 1, 2 and 4 with ε = 1 and without constants: -1/2 Σ_l 4^l |K_l (I_0 - x)|².

    Where `binarise` is positive, it is the η of the silhouette loss (section 5.3): pixels p become p / (p + η) first.
    """
    if binarise > 0:
        picture, target = binarised(picture, binarise), binarised(target, binarise)
    level, total, weight = picture - target, picture.new_zeros(()), 1.0
    while True:
        total = total - 0.5 * weight * level.square().sum()
        if min(level.shape[1:]) == 1:
            return total
        level, weight = _halve(_halve(level, 1), 2), 4.0 * weight


def binarised(pixels: Tensor, eta: float) -> Tensor:
    """Pixels p become p / (p + η): all but 1 where anything is seen. Rounding may leave black a hair below zero."""
    seen = pixels.clamp(min=0)
    return seen / (seen + eta)


def _halve(level: Float[Tensor, "C H W"], axis: int) -> Tensor:
    """Convolution with [1 4 6 4 1]/16 at every second pixel, border by reflection."""
    size = level.shape[axis]
    period = max(2 * (size - 1), 1)
    centres, total = torch.arange(0, size, 2), 0.0 * level.index_select(axis, torch.arange(0, size, 2))
    for offset, weight in zip(range(-2, 3), (1, 4, 6, 4, 1), strict=True):
        wrapped = (centres + offset) % period
        total = total + weight / 16 * level.index_select(axis, torch.minimum(wrapped, period - wrapped) % size)
    return total


class Planes(NamedTuple):
    """Linear functions (p, q, r): p + q·x + r·y of the screen, one a face."""

    depth: Float[Tensor, "F 3"]  # inverse depth
    weighted: Float[Tensor, "F 3 C"]  # inverse depth times colour: their ratio is the true colour
    linear: Float[Tensor, "F 3 C"]  # colour, as if it were linear on the screen
    depths: Float[np.ndarray, "F 2"]  # the least and the greatest inverse depth on a face


def _planes(
    screen: Tensor, painted: Float[Tensor, "F 3 C"], faces: Tensor, fixed: np.ndarray, corners: np.ndarray
) -> Planes:
    drawn = torch.as_tensor(np.array([is_drawn(fixed, face) for face in corners], bool))
    at = screen[faces]
    points = torch.cat((torch.ones_like(at[..., :1]), at[..., :2]), -1)
    # Faces that are not drawn get planes that nobody asks for.
    points = torch.where(drawn[:, None, None], points, torch.eye(3, dtype=points.dtype))
    depth = at[..., 2:]
    values = torch.linalg.solve(points, torch.cat((depth, depth * painted, painted), -1))
    channels = painted.shape[2]
    depths = np.stack((fixed[corners, 2].min(1), fixed[corners, 2].max(1)), -1)
    return Planes(values[..., 0], values[..., 1 : 1 + channels], values[..., 1 + channels :], depths)


def _changes(screen: Tensor, planes: Planes, pieces: list[Piece]) -> Float[Tensor, "P C"]:
    """What each piece adds to the colour that its pixel's centre has: shadow's integral of (beyond - here)."""
    own = _coefficients(screen, planes, [piece.line for piece in pieces])
    centres = own.new_tensor([piece.pixel for piece in pieces]) + 0.5
    a, b = (_end_points(screen, planes, own, [piece.ends[which] for piece in pieces]) - centres for which in range(2))
    area, moment = _shadows(a, b)
    change = 0.0 * planes.linear.sum() + own.new_zeros(len(pieces), planes.linear.shape[2])
    for seen, sign in (([piece.here for piece in pieces], -1), ([piece.beyond for piece in pieces], 1)):
        which = torch.tensor([n for n, face in enumerate(seen) if face >= 0], dtype=torch.int64)
        if len(which):
            value, slope = _tangents(planes, torch.tensor(seen)[which], centres[which])
            part = area[which, None] * value + (moment[which, :, None] * slope).sum(1)
            change = change.index_add(0, which, sign * part)
    return change


def _coefficients(screen: Tensor, planes: Planes, lines: list[Line]) -> Float[Tensor, "N 3"]:
    """(a, b, c) of the lines a·x + b·y + c = 0."""
    points = torch.cat((screen[:, :2], torch.ones_like(screen[:, :1])), 1)
    result = screen.new_zeros(len(lines), 3)
    for kind in ("edge", "crossing", "column", "row"):
        at = torch.tensor([n for n, line in enumerate(lines) if line.kind == kind], dtype=torch.int64)
        first, second = (
            torch.tensor([getattr(lines[n], name) for n in at.tolist()], dtype=torch.int64)
            for name in ("first", "second")
        )
        match kind:
            case "edge":
                found = torch.linalg.cross(points[first], points[second])
            case "crossing":
                found = (planes.depth[first] - planes.depth[second])[:, [1, 2, 0]]
            case "column":
                found = torch.stack((torch.ones_like(first), torch.zeros_like(first), -first), 1).to(screen)
            case _:
                found = torch.stack((torch.zeros_like(first), torch.ones_like(first), -first), 1).to(screen)
        result = result.index_put((at,), found)
    return result


def _end_points(
    screen: Tensor, planes: Planes, own: Float[Tensor, "N 3"], ends: list[Line | int]
) -> Float[Tensor, "N 2"]:
    """Where each line is cut by another, or the vertex at which it ends."""
    result = screen.new_zeros(len(ends), 2)
    at = torch.tensor([n for n, end in enumerate(ends) if isinstance(end, int)], dtype=torch.int64)
    result = result.index_put((at,), screen[[end for end in ends if isinstance(end, int)], :2])
    at = torch.tensor([n for n, end in enumerate(ends) if isinstance(end, Line)], dtype=torch.int64)
    others = _coefficients(screen, planes, [end for end in ends if isinstance(end, Line)])
    meeting = torch.linalg.cross(own[at], others)
    return result.index_put((at,), meeting[:, :2] / meeting[:, 2:])


def _tangents(
    planes: Planes, faces: Int64[Tensor, "N"], centres: Float[Tensor, "N 2"]
) -> tuple[Float[Tensor, "N C"], Float[Tensor, "N 2 C"]]:
    """Faces' colours around points as (value there, slope): tangent to the true one, if the face's plane has a depth
    there that occurs on the face; beyond that, linear between the corners."""
    here = torch.cat((torch.ones_like(centres[:, :1]), centres), 1)[:, :, None]
    depth, weighted, linear = planes.depth[faces], planes.weighted[faces], planes.linear[faces]
    at = (here[..., 0] * depth).sum(1)
    least, most = torch.as_tensor(planes.depths[faces.numpy()]).unbind(1)
    occurs = (least <= at) & (at <= most)
    divisor = torch.where(occurs, at, 1.0)[:, None]
    value = (here * weighted).sum(1) / divisor
    slope = (weighted[:, 1:] - depth[:, 1:, None] * value[:, None]) / divisor[:, None]
    value = torch.where(occurs[:, None], value, (here * linear).sum(1))
    return value, torch.where(occurs[:, None, None], slope, linear[:, 1:])


def _shadows(a: Float[Tensor, "N 2"], b: Float[Tensor, "N 2"]) -> tuple[Float[Tensor, "N"], Float[Tensor, "N 2"]]:
    """Area and first moments of the part of the unit square around the origin that a segment hides from the origin."""
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    start, end = _perimeter_positions(a), _perimeter_positions(b)
    turn = (end - start).abs()
    sector = torch.minimum(turn, 4 - turn) / 4
    swept = (_swept_moments(end) - _swept_moments(start)) * torch.sign(cross)[:, None]
    return sector - cross.abs() / 2, swept - cross.abs()[:, None] / 6 * (a + b)


def _perimeter_positions(points: Float[Tensor, "N 2"]) -> Float[Tensor, "N"]:
    """Where rays leave the square: side k has the positions k ± 1/2, counter-clockwise from the right."""
    x, y = points.unbind(1)
    flat = (x.abs() >= y.abs()) & (x != 0)
    steep = x.abs() < y.abs()
    across = 0.5 * y / torch.where(flat, x, 1.0) + torch.where(x > 0, 0.0, 2.0)
    upward = -0.5 * x / torch.where(steep, y, 1.0) + torch.where(y > 0, 1.0, 3.0)
    return torch.where(flat, across, torch.where(steep, upward, 0.0 * x))


def _swept_moments(positions: Float[Tensor, "N"]) -> Float[Tensor, "N 2"]:
    """First moments of the part of the square that a ray sweeps from the lower right corner up to a position."""
    normals = positions.new_tensor([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    before = normals.cumsum(0) - normals
    side = torch.floor(positions.detach() + 0.5).long() % 4
    along = torch.where(positions < 3.5, positions - side, positions - 4)[:, None]
    tangents = normals[(side + 1) % 4]
    return (before[side] + normals[side] * (along + 0.5) + tangents * (along * along - 0.25)) / 12
