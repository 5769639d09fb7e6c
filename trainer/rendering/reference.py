"""The renderer written for reading: one mesh at a time, plain torch, any precision. The oracle of every fast backend.

It computes exactly the picture that `docs/renderer.md` defines. What is a decision (which face a pixel sees, which
edges are contours, which pieces of them are visible) is taken on detached numbers; what is a number is differentiable
torch.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, Int64
from torch import Tensor

DEPTH_MARGIN = 1e-6
SMALLEST_DOUBLED_AREA = 1e-12
BORDER = 1e-6
TIE = 1 + 1e-9


class Piece(NamedTuple):
    """A straight piece of contour inside one pixel."""

    ends: tuple[int, int]  # the edge's vertices, the smaller index first
    pixel: tuple[int, int]  # column, row
    cuts: tuple[tuple[int, float] | None, tuple[int, float] | None]  # (axis, boundary); None: the edge's own end
    near_at_centre: bool
    far_face: int  # -1: the background
    far_at_middle: bool
    far_pixel: tuple[int, int]


def draw(
    screen: Float[Tensor, "V 3"], colours: Float[Tensor, "V C"], faces: Int64[Tensor, "F 3"], width: int, height: int
) -> Float[Tensor, "C H W"]:
    """The antialiased picture of one mesh on black; differentiable in `screen` (x, y, inverse depth) and `colours`."""
    fixed, corners = screen.detach().double().cpu().numpy(), faces.cpu().numpy()
    columns, rows = np.meshgrid(np.arange(-1, width + 1) + 0.5, np.arange(-1, height + 1) + 0.5)
    visible = _visible_faces(fixed, corners, np.stack((columns, rows), -1).reshape(-1, 2)).reshape(columns.shape)

    picture = screen.new_zeros(height, width, colours.shape[1])
    row, column = np.nonzero(visible[1:-1, 1:-1] >= 0)
    if len(row):
        points = torch.as_tensor(np.stack((column, row), -1) + 0.5).to(screen)
        pixels = torch.as_tensor(row), torch.as_tensor(column)
        seen = faces[torch.as_tensor(visible[1:-1, 1:-1][row, column])]
        picture = picture.index_put(pixels, _colour(screen, colours, seen, points))
    for piece in _contour_pieces(fixed, corners, visible):
        here = torch.tensor(piece.pixel[1]), torch.tensor(piece.pixel[0])
        picture = picture.index_put(here, _change_at_piece(screen, colours, faces, piece), accumulate=True)
    return picture.permute(2, 0, 1)


def log_likelihood(picture: Float[Tensor, "C H W"], target: Float[Tensor, "C H W"]) -> Float[Tensor, ""]:
    """Eqs. 1, 2 and 4 with ε = 1 and without constants: -1/2 Σ_l 4^l |K_l (I_0 - x)|²."""
    level, total, weight = picture - target, picture.new_zeros(()), 1.0
    while True:
        total = total - 0.5 * weight * level.square().sum()
        if min(level.shape[1:]) == 1:
            return total
        level, weight = _halve(_halve(level, 1), 2), 4.0 * weight


def _halve(level: Float[Tensor, "C H W"], axis: int) -> Tensor:
    """Convolution with [1 4 6 4 1]/16 at every second pixel, border by reflection."""
    size = level.shape[axis]
    period = max(2 * (size - 1), 1)
    centres, total = torch.arange(0, size, 2), 0.0 * level.index_select(axis, torch.arange(0, size, 2))
    for offset, weight in zip(range(-2, 3), (1, 4, 6, 4, 1), strict=True):
        wrapped = (centres + offset) % period
        total = total + weight / 16 * level.index_select(axis, torch.minimum(wrapped, period - wrapped) % size)
    return total


def _line(a: np.ndarray, b: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The linear function that vanishes on the line through a and b: distance times length."""
    line_x, line_y = b[1] - a[1], a[0] - b[0]
    return np.asarray(line_x * point[..., 0] + line_y * point[..., 1] + (b[0] * a[1] - a[0] * b[1]))


def _side(a: np.ndarray, b: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Whether points lie on the positive side of the line through a and b, the line itself included."""
    return _line(a, b, point) >= 0


def _covers(fixed: np.ndarray, face: np.ndarray, points: np.ndarray) -> Bool[np.ndarray, "*P"]:
    """Whether a face covers points; a point on an edge belongs to the face on the edge's positive side."""
    (ax, ay), (bx, by) = fixed[face[1], :2] - fixed[face[0], :2], fixed[face[2], :2] - fixed[face[0], :2]
    inside = np.full(points.shape[:-1], abs(ax * by - bx * ay) > SMALLEST_DOUBLED_AREA)
    for corner in range(3):
        first, second = sorted((face[(corner + 1) % 3], face[(corner + 2) % 3]))
        own = _side(fixed[first], fixed[second], fixed[face[corner]])
        inside &= _side(fixed[first], fixed[second], points) == own
    return inside


def _touches(fixed: np.ndarray, face: np.ndarray, point: np.ndarray) -> bool:
    """Whether a face, its border and a hair more included, covers a point."""
    for corner in range(3):
        first, second = sorted((face[(corner + 1) % 3], face[(corner + 2) % 3]))
        own = 1 if _side(fixed[first], fixed[second], fixed[face[corner]]) else -1
        if _line(fixed[first], fixed[second], point) * own < -BORDER:
            return False
    return True


def _inverse_depth(fixed: np.ndarray, face: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The plane of inverse depth through a face's corners, at points."""
    origin, across = fixed[face[0]], fixed[face[1:]] - fixed[face[0]]
    slope = np.linalg.solve(across[:, :2], across[:, 2])
    return np.asarray(origin[2] + (points - origin[:2]) @ slope)


def _visible_faces(fixed: np.ndarray, corners: np.ndarray, points: np.ndarray) -> Int64[np.ndarray, "P"]:
    nearest, visible = np.zeros(len(points)), np.full(len(points), -1)
    for index, face in enumerate(corners):
        inside = np.flatnonzero(_covers(fixed, face, points))
        if len(inside):
            depth = _inverse_depth(fixed, face, points[inside])
            wins = depth > nearest[inside] * TIE
            nearest[inside[wins]], visible[inside[wins]] = depth[wins], index
    return visible


def _contour_pieces(fixed: np.ndarray, corners: np.ndarray, visible: np.ndarray) -> list[Piece]:
    height, width = visible.shape[0] - 2, visible.shape[1] - 2
    around: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for index, face in enumerate(corners):
        (ax, ay), (bx, by) = fixed[face[1], :2] - fixed[face[0], :2], fixed[face[2], :2] - fixed[face[0], :2]
        if abs(ax * by - bx * ay) > SMALLEST_DOUBLED_AREA:
            for corner in range(3):
                first, second = sorted((int(face[(corner + 1) % 3]), int(face[(corner + 2) % 3])))
                around.setdefault((first, second), []).append((index, int(face[corner])))
    pieces = []
    for (i, j), members in around.items():
        start, end = fixed[i], fixed[j]
        sides = {bool(_side(start, end, fixed[opposite])) for _, opposite in members}
        if len(sides) == 2:
            continue
        crossings: list[tuple[float, tuple[int, float] | None]] = [(0.0, None), (1.0, None)]
        for axis, size in enumerate((width, height)):
            low, high = sorted((start[axis], end[axis]))
            for boundary in range(max(0, int(np.ceil(low))), min(size, int(np.floor(high))) + 1):
                if low < boundary < high:
                    at = (boundary - start[axis]) / (end[axis] - start[axis])
                    crossings.append((at, (axis, float(boundary))))
        crossings.sort(key=lambda crossing: crossing[0])
        for (t0, cut0), (t1, cut1) in pairwise(crossings):
            x, y, w = start + 0.5 * (t0 + t1) * (end - start)
            if not (t0 < t1 and 0 <= x < width and 0 <= y < height):
                continue
            column, row = int(x), int(y)
            positive = bool(_side(start, end, np.array([column + 0.5, row + 0.5])))
            normal = np.array([end[1] - start[1], start[0] - end[0]]) * (1 if positive else -1)
            step = (-int(np.sign(normal[0])), 0) if abs(normal[0]) > abs(normal[1]) else (0, -int(np.sign(normal[1])))
            near_at_centre = positive in sides
            across = (column + step[0], row + step[1])
            far_pixel = across if near_at_centre else (column, row)
            adjacent = {index for index, _ in members}
            middle = np.array([x, y])
            hidden = False
            for px, py in ((column, row), across):
                face = int(visible[py + 1, px + 1])
                if face >= 0 and face not in adjacent and _touches(fixed, corners[face], middle):
                    hidden |= bool(_inverse_depth(fixed, corners[face], middle) > w * (1 + DEPTH_MARGIN))
            if not hidden:
                far_face = int(visible[far_pixel[1] + 1, far_pixel[0] + 1])
                at_middle = far_face >= 0 and _touches(fixed, corners[far_face], middle)
                pieces.append(
                    Piece((i, j), (column, row), (cut0, cut1), near_at_centre, far_face, at_middle, far_pixel)
                )
    return pieces


def _colour(screen: Tensor, colours: Tensor, seen: Int64[Tensor, "N 3"], points: Float[Tensor, "N 2"]) -> Tensor:
    """Perspective-correct Gouraud colours [N, C] of faces at points."""
    a, b, c = screen[seen].unbind(1)

    def doubled_area(u: Tensor, v: Tensor, w: Tensor) -> Tensor:
        return (v[:, 0] - u[:, 0]) * (w[:, 1] - u[:, 1]) - (w[:, 0] - u[:, 0]) * (v[:, 1] - u[:, 1])

    shares = torch.stack((doubled_area(points, b, c), doubled_area(a, points, c), doubled_area(a, b, points)), 1)
    weights = shares * screen[seen][..., 2]
    return (weights[..., None] * colours[seen]).sum(1) / weights.sum(1, keepdim=True)


def _change_at_piece(screen: Tensor, colours: Tensor, faces: Tensor, piece: Piece) -> Float[Tensor, "C"]:
    start, end = screen[piece.ends[0]], screen[piece.ends[1]]
    at = [
        start.new_tensor(float(which)) if cut is None else (cut[1] - start[cut[0]]) / (end[cut[0]] - start[cut[0]])
        for which, cut in enumerate(piece.cuts)
    ]
    centre = start.new_tensor(piece.pixel) + 0.5
    a, b = ((start + t * (end - start))[:2] - centre for t in at)
    area = _sector(a, b) - 0.5 * (a[0] * b[1] - a[1] * b[0]).abs()

    t = 0.5 * (at[0] + at[1])
    middle = start + t * (end - start)
    share = t * end[2] / middle[2]
    near = colours[piece.ends[0]] * (1 - share) + colours[piece.ends[1]] * share
    far = torch.zeros_like(near)
    if piece.far_face >= 0:
        point = middle[:2] if piece.far_at_middle else start.new_tensor(piece.far_pixel) + 0.5
        far = _colour(screen, colours, faces[piece.far_face][None], point[None])[0]
    return area * (far - near) * (1 if piece.near_at_centre else -1)


def _sector(a: Float[Tensor, "2"], b: Float[Tensor, "2"]) -> Float[Tensor, ""]:
    """Area of the unit square around the origin between the rays through a and b: a quarter of the perimeter there."""

    def perimeter_position(p: Tensor) -> Tensor:
        x, y = p
        position: Tensor = 0.0 * x
        if x.abs() < y.abs():
            position = -0.5 * x / y + (1.0 if y > 0 else 3.0)
        elif x != 0:
            position = 0.5 * y / x + (0.0 if x > 0 else 2.0)
        return position

    turn = (perimeter_position(b) - perimeter_position(a)).abs()
    return torch.minimum(turn, 4 - turn) / 4
