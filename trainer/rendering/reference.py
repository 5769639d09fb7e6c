"""The renderer written for reading: one mesh at a time, plain torch, any precision. The oracle of every fast backend.

It computes exactly the picture that `docs/renderer.md` defines. What is a decision (which face a point sees, which
lines bound what is seen, where they cross) is taken on detached numbers; what is a number is differentiable torch.
"""

from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, Int64
from torch import Tensor

from rasteriser.likelihood import CREASE

SMALLEST_DOUBLED_AREA = 1e-12
TIE = 1 + 1e-12
ASIDE = 1e-6
INTERIOR = 1e-9
PARALLEL = 1e-6
SAME_DEPTH = 1e-9
SHORTEST = 1e-6
THIN = 5e-2


class Line(NamedTuple):
    """A straight line on the screen that moves with the mesh, or a pixel boundary that does not."""

    kind: str  # "edge" through two vertices; "crossing" of two faces' planes; "column" or "row" boundary
    first: int
    second: int = -1


class Segment(NamedTuple):
    """A stretch of a line along which what is seen may change abruptly."""

    line: Line
    start: np.ndarray  # [2]
    end: np.ndarray
    start_at: Line | int  # what ends it there: another line, or a vertex of the edge
    end_at: Line | int
    faces: tuple[int, ...]  # whose border this is


class Piece(NamedTuple):
    """A part of a segment inside one pixel along which two faces meet in what is seen: both those of a crossing, or one
    of those at an edge."""

    line: Line
    ends: tuple[Line | int, Line | int]  # another line that cuts it there, or a vertex
    pixel: tuple[int, int]  # column, row
    here: int  # the face seen on the side of the pixel's centre; -1: the background
    beyond: int


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
    interpenetrate; if it is infinite, contours alone.
    """
    fixed, corners = screen.detach().double().cpu().numpy(), faces.cpu().numpy()
    thin = torch.as_tensor(_thickness(fixed, corners) < THIN)
    painted = colours[faces]
    painted = torch.where(thin[:, None, None], painted.mean(1, keepdim=True), painted)
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    centres = np.stack((columns, rows), -1).reshape(-1, 2)
    visible = _nearest_faces(fixed, corners, centres).reshape(height, width)

    picture = screen.new_zeros(height, width, colours.shape[1])
    row, column = np.nonzero(visible >= 0)
    planes = _planes(screen, painted, faces, fixed, corners)
    if len(row):
        points = torch.as_tensor(np.stack((np.ones(len(row)), column + 0.5, row + 0.5), -1)).to(screen)
        seen = torch.as_tensor(visible[row, column])
        depth = (points * planes.depth[seen]).sum(1, keepdim=True)
        colour = (points[:, :, None] * planes.weighted[seen]).sum(1) / depth
        picture = picture.index_put((torch.as_tensor(row), torch.as_tensor(column)), colour)
    pieces = _pieces(fixed, planes.linear.detach().cpu().numpy(), corners, width, height, crease)
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


def _side(a: np.ndarray, b: np.ndarray, point: np.ndarray) -> Bool[np.ndarray, "*P"]:
    """Whether points lie on the positive side of the line through a and b, the line itself included."""
    line_x, line_y = b[1] - a[1], a[0] - b[0]
    return np.asarray(line_x * point[..., 0] + line_y * point[..., 1] + (b[0] * a[1] - a[0] * b[1]) >= 0)


def _doubled_area(fixed: np.ndarray, face: np.ndarray) -> float:
    (ax, ay), (bx, by) = fixed[face[1], :2] - fixed[face[0], :2], fixed[face[2], :2] - fixed[face[0], :2]
    return float(ax * by - bx * ay)


def _is_drawn(fixed: np.ndarray, face: np.ndarray) -> bool:
    return abs(_doubled_area(fixed, face)) > SMALLEST_DOUBLED_AREA


def _thickness(fixed: np.ndarray, corners: np.ndarray) -> Float[np.ndarray, "F"]:
    """Height of each face on the screen, in pixels: what is too thin is painted in its mean colour."""
    longest = [max(np.hypot(*(fixed[face[c], :2] - fixed[face[c - 1], :2])) for c in range(3)) for face in corners]
    areas = [abs(_doubled_area(fixed, face)) for face in corners]
    return np.array(areas) / np.maximum(longest, np.sqrt(SMALLEST_DOUBLED_AREA))


def _sides(face: np.ndarray) -> list[tuple[int, int, int]]:
    """The edges of a face, the smaller index first, and the corner opposite each."""
    sides = []
    for c in range(3):
        i, j = int(face[(c + 1) % 3]), int(face[(c + 2) % 3])
        sides.append((min(i, j), max(i, j), int(face[c])))
    return sides


def _nearest_faces(fixed: np.ndarray, corners: np.ndarray, points: np.ndarray) -> Int64[np.ndarray, "P"]:
    """The face seen at each point, -1 for none; of faces at one depth, up to rounding, the first.

    A point on an edge belongs to the face on the edge's positive side.
    """
    nearest, visible = np.zeros(len(points)), np.full(len(points), -1)
    for index, face in enumerate(corners):
        if not _is_drawn(fixed, face):
            continue
        inside = np.ones(len(points), bool)
        for i, j, opposite in _sides(face):
            inside &= _side(fixed[i], fixed[j], points) == _side(fixed[i], fixed[j], fixed[opposite])
        covered = np.flatnonzero(inside)
        if len(covered):
            p, q, r = _depth_plane(fixed, face)
            depth = p + points[covered] @ [q, r]
            wins = depth > nearest[covered] * TIE
            nearest[covered[wins]], visible[covered[wins]] = depth[wins], index
    return visible


def _depth_plane(fixed: np.ndarray, face: np.ndarray) -> Float[np.ndarray, "3"]:
    """Inverse depth on a face as a function p + q·x + r·y of the screen."""
    origin, across = fixed[face[0]], fixed[face[1:]] - fixed[face[0]]
    slope = np.linalg.solve(across[:, :2], across[:, 2])
    return np.array([origin[2] - origin[:2] @ slope, *slope])


def _edges(fixed: np.ndarray, linear: np.ndarray, corners: np.ndarray, crease: float) -> list[Segment]:
    """Contours, edges whose faces all lie on one side of them on the screen, and creases, where colours bend sharply.

    Three faces or more at an edge: each has its own.
    """
    around: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for index, face in enumerate(corners):
        for i, j, opposite in _sides(face):
            around.setdefault((i, j), []).append((index, opposite))
    segments = []
    for (i, j), members in around.items():
        for group in [members] if len(members) < 3 else [[member] for member in members]:
            drawn = [one for one in group if _is_drawn(fixed, corners[one[0]])]
            sides = {bool(_side(fixed[i], fixed[j], fixed[opposite])) for _, opposite in drawn}
            bend = -1.0
            if len(sides) == 2:
                first, second = (linear[index, 1:] for index, _ in drawn)
                bend = np.hypot(*(first - second)).max(initial=0.0)
            if len(sides) == 1 or bend >= crease:
                faces = tuple(index for index, _ in drawn)
                segments.append(Segment(Line("edge", i, j), fixed[i, :2], fixed[j, :2], i, j, faces))
    return segments


def _crossings(fixed: np.ndarray, corners: np.ndarray) -> list[Segment]:
    """Where faces that share no edge interpenetrate."""
    drawn = np.array([_is_drawn(fixed, face) for face in corners], bool)
    planes = np.stack(
        [_depth_plane(fixed, face) if ok else np.zeros(3) for ok, face in zip(drawn, corners, strict=True)]
    )
    above = fixed[:, 2] - planes @ np.stack((np.ones(len(fixed)), fixed[:, 0], fixed[:, 1]))
    at_corners, margin = above[:, corners], SAME_DEPTH * fixed[:, 2].max()
    pierced = (at_corners.min(2) < -margin) & (at_corners.max(2) > margin)
    shared = (corners[:, None, :, None] == corners[None, :, None, :]).sum((2, 3))
    pairs = np.argwhere(np.triu(pierced & pierced.T & (shared < 2) & drawn[:, None] & drawn, 1))
    segments = []
    for f, g in pairs.tolist():
        c, a, b = planes[f] - planes[g]
        foot, along = -c * np.array([a, b]) / (a * a + b * b), np.array([-b, a]) / np.hypot(a, b)
        first, last = -np.inf, np.inf
        first_at = last_at = Line("edge", -1)
        for face in (f, g):
            for i, j, opposite in _sides(corners[face]):
                start, edge = fixed[i, :2], fixed[j, :2] - fixed[i, :2]
                inward = np.array([-edge[1], edge[0]])
                inward *= np.sign(inward @ (fixed[opposite, :2] - start))
                rate, at_foot = inward @ along, inward @ (foot - start)
                if rate == 0:
                    last = last if at_foot >= 0 else -np.inf
                elif rate > 0 and -at_foot / rate > first:
                    first, first_at = -at_foot / rate, Line("edge", i, j)
                elif rate < 0 and -at_foot / rate < last:
                    last, last_at = -at_foot / rate, Line("edge", i, j)
        if last - first > SHORTEST:
            ends = foot + first * along, foot + last * along
            segments.append(Segment(Line("crossing", f, g), *ends, first_at, last_at, (f, g)))
    return segments


def _cuts(
    index: int, segments: list[Segment], starts: np.ndarray, spans: np.ndarray, width: int, height: int
) -> list[tuple[float, Line | int]]:
    """Where pixel boundaries and other segments cut a segment: t from 0 to 1, in order, and the cutting line."""
    segment, along = segments[index], spans[index]
    cuts: list[tuple[float, Line | int]] = [(0.0, segment.start_at), (1.0, segment.end_at)]
    for axis, kind, size in ((0, "column", width), (1, "row", height)):
        low, high = sorted((segment.start[axis], segment.end[axis]))
        for boundary in range(max(0, int(np.ceil(low))), min(size, int(np.floor(high))) + 1):
            if low < boundary < high:
                cuts.append(((boundary - segment.start[axis]) / along[axis], Line(kind, boundary)))
    apart = starts - segment.start
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = along[0] * spans[:, 1] - along[1] * spans[:, 0]
        t = (apart[:, 0] * spans[:, 1] - apart[:, 1] * spans[:, 0]) / determinant
        u = (apart[:, 0] * along[1] - apart[:, 1] * along[0]) / determinant
    crosswise = np.abs(determinant) > PARALLEL * np.hypot(*along) * np.hypot(*spans.T)
    meets = crosswise & (t > INTERIOR) & (t < 1 - INTERIOR) & (u >= -INTERIOR) & (u <= 1 + INTERIOR)
    cuts += [(t[other], segments[other].line) for other in np.flatnonzero(meets)]
    return sorted(cuts, key=lambda cut: cut[0])


def _pieces(
    fixed: np.ndarray, linear: np.ndarray, corners: np.ndarray, width: int, height: int, crease: float
) -> list[Piece]:
    segments = [
        segment
        for segment in _edges(fixed, linear, corners, crease) + (_crossings(fixed, corners) if crease < np.inf else [])
        if (segment.start != segment.end).any()
    ]
    starts = np.array([segment.start for segment in segments]).reshape(-1, 2)
    spans = np.array([segment.end - segment.start for segment in segments]).reshape(-1, 2)
    candidates, beside = [], []
    for index, segment in enumerate(segments):
        along = spans[index]
        places, lines = zip(*_cuts(index, segments, starts, spans, width, height), strict=True)
        t = np.array(places)
        middles = segment.start + 0.5 * (t[:-1] + t[1:])[:, None] * along
        # Steps away from the pixels' centres, along the normal.
        steps = np.full_like(middles, ASIDE / np.hypot(*along)) * (-along[1], along[0])
        steps[((np.floor(middles) + 0.5 - middles) * steps).sum(1) > 0] *= -1
        inside = (t[:-1] < t[1:]) & (middles >= 0).all(1) & (middles < (width, height)).all(1)
        beside.append(np.stack((middles - steps, middles + steps), 1)[inside])
        for n in np.flatnonzero(inside).tolist():
            pixel = int(middles[n, 0]), int(middles[n, 1])
            candidates.append((pixel, segment, (lines[n], lines[n + 1])))
    if not candidates:
        return []
    seen = _nearest_faces(fixed, corners, np.concatenate(beside).reshape(-1, 2)).reshape(-1, 2)
    return [
        Piece(segment.line, ends, pixel, int(here), int(beyond))
        for (pixel, segment, ends), (here, beyond) in zip(candidates, seen, strict=True)
        if here != beyond
        and (here in segment.faces) + (beyond in segment.faces) >= (2 if segment.line.kind == "crossing" else 1)
    ]


class Planes(NamedTuple):
    """Linear functions (p, q, r): p + q·x + r·y of the screen, one a face."""

    depth: Float[Tensor, "F 3"]  # inverse depth
    weighted: Float[Tensor, "F 3 C"]  # inverse depth times colour: their ratio is the true colour
    linear: Float[Tensor, "F 3 C"]  # colour, as if it were linear on the screen
    depths: Float[np.ndarray, "F 2"]  # the least and the greatest inverse depth on a face


def _planes(
    screen: Tensor, painted: Float[Tensor, "F 3 C"], faces: Tensor, fixed: np.ndarray, corners: np.ndarray
) -> Planes:
    drawn = torch.as_tensor(np.array([_is_drawn(fixed, face) for face in corners], bool))
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
