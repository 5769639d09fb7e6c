"""What the reference decides about a mesh on the screen, in numpy: which face a point sees, which segments bound what
is seen, where they cut one another, and which pieces of them count. docs/renderer.md says why.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int64

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


def _side(a: np.ndarray, b: np.ndarray, point: np.ndarray) -> Bool[np.ndarray, "*P"]:
    """Whether points lie on the positive side of the line through a and b, the line itself included."""
    line_x, line_y = b[1] - a[1], a[0] - b[0]
    return np.asarray(line_x * point[..., 0] + line_y * point[..., 1] + (b[0] * a[1] - a[0] * b[1]) >= 0)


def _doubled_area(fixed: np.ndarray, face: np.ndarray) -> float:
    (ax, ay), (bx, by) = fixed[face[1], :2] - fixed[face[0], :2], fixed[face[2], :2] - fixed[face[0], :2]
    return float(ax * by - bx * ay)


def is_drawn(fixed: np.ndarray, face: np.ndarray) -> bool:
    return abs(_doubled_area(fixed, face)) > SMALLEST_DOUBLED_AREA


def thickness(fixed: np.ndarray, corners: np.ndarray) -> Float[np.ndarray, "F"]:
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


def nearest_faces(fixed: np.ndarray, corners: np.ndarray, points: np.ndarray) -> Int64[np.ndarray, "P"]:
    """The face seen at each point, -1 for none; of faces at one depth, up to rounding, the first.

    A point on an edge belongs to the face on the edge's positive side.
    """
    nearest, visible = np.zeros(len(points)), np.full(len(points), -1)
    for index, face in enumerate(corners):
        if not is_drawn(fixed, face):
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
            drawn = [one for one in group if is_drawn(fixed, corners[one[0]])]
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
    drawn = np.array([is_drawn(fixed, face) for face in corners], bool)
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


def find_pieces(
    fixed: np.ndarray, linear: np.ndarray, corners: np.ndarray, width: int, height: int, crease: float
) -> list[Piece]:
    if crease < 0 or not len(corners):
        return []
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
    seen = nearest_faces(fixed, corners, np.concatenate(beside).reshape(-1, 2)).reshape(-1, 2)
    return [
        Piece(segment.line, ends, pixel, int(here), int(beyond))
        for (pixel, segment, ends), (here, beyond) in zip(candidates, seen, strict=True)
        if here != beyond
        and (here in segment.faces) + (beyond in segment.faces) >= (2 if segment.line.kind == "crossing" else 1)
    ]
