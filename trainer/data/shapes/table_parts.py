"""What a table is built of: its measures, tops, single legs and drawers.

A table's long side lies along x, and whoever opens its drawers sits at +Z.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, box, joined, lathe, loft, moved, tube


class Top(NamedTuple):
    """The measures that all parts share, metres."""

    width: float
    depth: float
    height: float
    """Of the upper face."""
    thickness: float
    corner: float = 1.0
    """How far out a leg may stand, as a share of the half width and half depth: 1 under a rectangle."""

    @property
    def under(self) -> float:
        """A height inside the top, for what carries it."""
        return self.height - 0.6 * self.thickness

    def spot(self, bar: float, inset: float = 0.0) -> tuple[float, float]:
        """x and z of the leg at the front on the object's left."""
        reach = bar / 2 + inset
        return self.corner * self.width / 2 - reach, self.corner * self.depth / 2 - reach


Outline = Literal["rectangle", "rounded", "oval", "polygon", "boat"]
CORNERS: dict[Outline, float] = {"rectangle": 1.0, "rounded": 0.88, "oval": 0.69, "polygon": 0.66, "boat": 0.82}


def outline(rng: Generator, style: Outline, width: float, depth: float) -> Float64[ndarray, "N 2"]:
    """A convex polygon of (x, z) points that fills width by depth."""
    match style:
        case "rectangle":
            points = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        case "rounded":
            return rounded(width, depth, rng.uniform(0.05, 0.2) * min(width, depth))
        case "oval":
            points = _regular(28, 0.0)
        case "polygon":
            sides = int(rng.choice([6, 8, 8]))
            points = _regular(sides, np.pi / sides)
            points /= points.max(0)
        case "boat":
            x = np.linspace(-1, 1, 9)
            side = np.stack((x, 1 - rng.uniform(0.12, 0.3) * x**2), -1)
            points = np.concatenate((side, side[::-1] * (1, -1)))
    filling: Float64[ndarray, "N 2"] = points * np.array([width / 2, depth / 2])
    return filling


def _regular(sides: int, turn: float) -> Float64[ndarray, "N 2"]:
    angle = np.arange(sides) * 2 * np.pi / sides + turn
    return np.stack((np.cos(angle), np.sin(angle)), -1)


def rounded(width: float, depth: float, radius: float) -> Float64[ndarray, "20 2"]:
    """A rectangle of (x, z) points with its corners rounded by `radius` metres."""
    half, quarter = np.array([width / 2, depth / 2]), np.linspace(0, np.pi / 2, 5)
    arc = half - radius + radius * np.stack((np.cos(quarter), np.sin(quarter)), -1)
    return np.concatenate((arc, arc[::-1] * (-1, 1), -arc, arc[::-1] * (1, -1)))


def board(points: Float64[ndarray, "N 2"], levels: Sequence[tuple[float, float]]) -> Mesh:
    """A flat solid of an (x, z) outline about the origin, through (height, inset) levels from one face to the other."""
    half = np.abs(points).max(0)
    return loft(np.stack([np.insert(points * (1 - inset / half), 1, y, axis=1) for y, inset in levels]))


def table_top(rng: Generator, top: Top, style: Outline) -> Mesh:
    """The board, with a square, rounded, under-cut or stepped edge."""
    points, low, high, thick = (
        outline(rng, style, top.width, top.depth),
        top.height - top.thickness,
        top.height,
        top.thickness,
    )
    match int(rng.integers(4)):
        case 0:
            levels = [(low, 0.0), (high, 0.0)]
        case 1:
            bevel = 0.35 * thick
            levels = [(low, bevel), (low + bevel, 0.0), (high - bevel, 0.0), (high, bevel)]
        case 2:
            levels = [(low, rng.uniform(0.5, 1.3) * thick), (high - 0.3 * thick, 0.0), (high, 0.0)]
        case _:
            step = rng.uniform(0.2, 0.5) * thick
            levels = [(low, step), (low + 0.5 * thick, step), (low + 0.5 * thick, 0.0), (high, 0.0)]
    return board(points, levels)


def front_and_back(mesh: Mesh) -> Mesh:
    """The mesh and its mirror image in the plane z = 0."""
    return joined(mesh, Mesh(mesh.vertices * (1.0, 1.0, -1.0), mesh.faces[:, ::-1]))


Leg = Literal["straight", "tapered", "round", "turned", "cabriole", "plank"]
LEGS: tuple[Leg, ...] = ("straight", "straight", "tapered", "round", "round", "turned", "cabriole", "plank")


def leg(
    rng: Generator, style: Leg, foot: tuple[float, float], head: tuple[float, float], high: float, bar: float
) -> Mesh:
    """One leg of thickness `bar` from (x, z) on the floor to (x, z) at height `high`."""
    start, end = (foot[0], 0.0, foot[1]), (head[0], high, head[1])
    match style:
        case "straight":
            return tube((start, end), bar / 2, square=True)
        case "tapered":
            return tube((start, end), (bar * rng.uniform(0.22, 0.4), bar / 2), square=True)
        case "round":
            return tube((start, end), (bar * rng.uniform(0.25, 0.5), bar / 2), 10)
        case "turned":
            levels = np.array([0.0, 0.05, 0.1, 0.14, 0.2, 0.45, 0.6, 0.64, 0.7, 0.74, 0.78])
            radii = bar * np.array([0.3, 0.42, 0.4, 0.26, 0.3, 0.46, 0.5, 0.3, 0.5, 0.5, 0.34]) * rng.uniform(0.9, 1.15)
            block = tube(((head[0], 0.76 * high, head[1]), end), bar / 2, square=True)
            spindle = lathe([(float(r), float(y * high)) for r, y in zip(radii, levels, strict=True)], 10)
            return joined(moved(spindle, (head[0], 0.0, head[1])), block)
        case "cabriole":
            levels, bend = np.linspace(0.0, 1.0, 9), rng.uniform(0.4, 0.8) * bar
            shift = bend * np.array([1.0, 0.2, -0.5, -0.7, -0.3, 0.4, 0.9, 0.8, 0.0])
            radii = bar * np.array([0.5, 0.36, 0.3, 0.32, 0.4, 0.52, 0.66, 0.72, 0.6])
            path = np.stack((head[0] + shift * np.sign(head[0]), levels * high, head[1] + shift * np.sign(head[1])), -1)
            return tube(path, radii.tolist(), 8)
        case "plank":
            return loft(np.stack([rectangle(x, y, z, 2.2 * bar, 0.7 * bar) for x, y, z in (start, end)]))


def rectangle(x: float, y: float, z: float, width: float, depth: float) -> Float64[ndarray, "4 3"]:
    return np.array([(x + a * width / 2, y, z + b * depth / 2) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def drawers(
    low: tuple[float, float], high: tuple[float, float], face: float, rows: int, columns: int, knob: float
) -> Mesh:
    """Drawer fronts, each with a pull of breadth `knob`, on the plane z = `face` between (x, y) corners."""
    width, height = (high[0] - low[0]) / columns, (high[1] - low[1]) / rows
    front = joined(
        box((width - 0.025, height - 0.025, 0.04), (0.0, 0.0, 0.002)),
        box((knob, 0.025, 0.05), (0.0, 0.12 * height, 0.035)),
    )
    return joined(
        *(
            moved(front, (low[0] + (column + 0.5) * width, low[1] + (row + 0.5) * height, face))
            for row in range(rows)
            for column in range(columns)
        )
    )
