"""The parts of a bench above its legs: seats, backs and arms.

A bench's long side lies along x and its back stands at -Z.
"""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, loft, moved, tube, turned
from trainer.data.shapes.table_parts import board, rounded


class Bench(NamedTuple):
    """The measures that all parts share, metres."""

    width: float
    depth: float
    height: float
    """Of the face to sit on, above the floor."""
    thickness: float
    """Of the seat."""

    @property
    def under(self) -> float:
        """A height inside the seat, for what carries it."""
        return self.height - 0.6 * self.thickness


SeatStyle = Literal["plank", "slats", "cross slats", "cushion", "pads"]
SEATS: tuple[SeatStyle, ...] = ("plank", "plank", "slats", "cross slats", "cushion", "pads")


def seat(rng: Generator, bench: Bench, style: SeatStyle) -> Mesh:
    """The surface to sit on: one board, boards along or across, a padded slab, or a board with cushions on it."""
    width, depth, high, thick = bench.width, bench.depth, bench.height, bench.thickness
    match style:
        case "plank":
            return box((width, thick, depth), (0.0, high - thick / 2, 0.0))
        case "slats":
            count, gap = int(rng.integers(3, 6)), rng.uniform(0.01, 0.025)
            slat = (depth + gap) / count - gap
            shift = np.arange(count) * (slat + gap) + (slat - depth) / 2
            bearer = box((0.05, 0.05, 0.96 * depth), (0.4 * width, high - thick - 0.01, 0.0))
            boards = [box((width, thick, slat), (0.0, high - thick / 2, float(z))) for z in shift]
            return joined(*boards, both_sides(bearer))
        case "cross slats":
            pitch = width / max(6, round(width / rng.uniform(0.09, 0.16)))
            slat = pitch * rng.uniform(0.6, 0.8)
            rail = box((width, 0.8 * thick, 0.05), (0.0, high - 0.9 * thick, 0.36 * depth))
            shift = np.arange((pitch - width) / 2, width / 2, pitch)
            boards = [box((slat, 0.9 * thick, depth), (float(x), high - 0.45 * thick, 0.0)) for x in shift]
            return joined(*boards, rail, moved(rail, (0.0, 0.0, -0.72 * depth)))
        case "cushion":
            deep = max(thick, rng.uniform(0.08, 0.16))
            return moved(pad(width, deep, depth, rng.uniform(0.15, 0.4) * deep), (0.0, high - deep / 2, 0.0))
        case "pads":
            count, soft = int(rng.integers(1, 4)), rng.uniform(0.05, 0.1)
            pitch = 0.98 * width / count
            lying = moved(pad(pitch - 0.01, soft, 0.94 * depth, 0.35 * soft), (0.0, high + soft / 2 - 0.01, 0.0))
            pads = [moved(lying, ((index - (count - 1) / 2) * pitch, 0.0, 0.0)) for index in range(count)]
            return joined(box((width, thick, depth), (0.0, high - thick / 2, 0.0)), *pads)


def pad(width: float, thickness: float, depth: float, bevel: float) -> Mesh:
    """An upholstered slab about the origin, its corners rounded and its edges bevelled by `bevel` metres."""
    y, corner = thickness / 2, min(2 * bevel, 0.3 * width, 0.3 * depth)
    levels = [(-y, bevel), (bevel - y, 0.0), (y - bevel, 0.0), (y - 0.3 * bevel, 0.3 * bevel), (y, bevel)]
    return board(rounded(width, depth, corner), levels)


BackStyle = Literal["slats", "uprights", "panel", "crosses", "padded", "rails"]
BACKS: tuple[BackStyle, ...] = ("slats", "slats", "uprights", "uprights", "panel", "crosses", "padded", "rails")


def back(rng: Generator, bench: Bench, style: BackStyle, height: float, recline: float) -> Mesh:
    """A backrest of `height` metres above the seat that leans back by `recline` radians."""
    width, bar, low = bench.width * rng.uniform(0.94, 1.0), rng.uniform(0.045, 0.07), bench.height - bench.thickness
    top, inner = bench.height + height, width - bar
    foot = bench.height + rng.uniform(0.03, 0.1)
    middle, arch = (top + foot) / 2, rng.choice([0.0, 0.0, 1.0]) * rng.uniform(0.1, 0.4) * height
    post = box((bar, top - low, bar), (inner / 2, (low + top) / 2, 0.0))
    parts = [both_sides(post), rail(width, top - rng.uniform(0.07, 0.12), top, 0.8 * bar, arch)]
    match style:
        case "slats":
            count, share = int(rng.integers(2, 5)), rng.uniform(0.6, 0.88)
            pitch = (top - foot) / count
            levels = foot + (np.arange(count) + 0.5) * pitch
            stay = moved(post, (-rng.uniform(0.02, 0.2) * width, 0.0, 0.0))
            parts = [both_sides(stay), *(box((width, share * pitch, 0.04), (0.0, y, 0.5 * bar)) for y in levels)]
        case "uprights":
            count = max(4, round(width / rng.uniform(0.1, 0.22)))
            shift = ((np.arange(count) + 0.5) / count - 0.5) * inner
            slat = rng.uniform(0.3, 0.6) * inner / count
            parts.append(rail(width, foot, foot + 0.06, 0.7 * bar, 0.0))
            parts += [box((slat, top - foot - 0.04, 0.035), (x, middle - 0.02, 0.0)) for x in shift]
        case "panel":
            parts = [parts[0], rail(width, rng.choice([foot, low]), top, rng.uniform(0.035, 0.06), arch)]
        case "crosses":
            count = max(1, round(width / 0.65))
            bay, tall = inner / count, top - foot - 0.04
            brace = tube([(-bay / 2, -tall / 2, 0.0), (bay / 2, tall / 2, 0.0)], 0.022, square=True)
            cross = joined(brace, Mesh(brace.vertices * (-1.0, 1.0, 1.0), brace.faces[:, ::-1]))
            shift = ((np.arange(count) + 0.5) / count - 0.5) * inner
            parts = [parts[0], *(rail(width, y - 0.03, y + 0.03, bar, 0.0) for y in (foot + 0.02, top - 0.03))]
            parts += [moved(cross, (x, middle, 0.0)) for x in shift]
            parts += [box((0.05, tall, 0.04), (x - bay / 2, middle, 0.0)) for x in shift[1:]]
        case "padded":
            thick = rng.uniform(0.08, 0.16)
            upright = turned(pad(width, thick, top - low, 0.3 * thick), 0, np.pi / 2)
            parts = [moved(upright, (0.0, (low + top) / 2, (thick - bar) / 2))]
        case "rails":
            parts.append(rail(width, middle - 0.05, middle + 0.03, 0.6 * bar, 0.0))
    upright = moved(joined(*parts), (0.0, 0.0, (bar - bench.depth) / 2))
    return turned(upright, 0, -recline, (0.0, low, -bench.depth / 2))


def rail(width: float, low: float, high: float, thickness: float, arch: float) -> Mesh:
    """A board across the back whose upper edge rises by `arch` metres towards the middle."""
    share = np.linspace(-1.0, 1.0, 9 if arch else 2)
    side = thickness / 2 * np.array([-1, 1, 1, -1])
    rings = [
        np.stack((np.full(4, reach * width / 2), np.array([low, low, top, top]), side), -1)
        for reach, top in zip(share, high + arch * (1 - share**2), strict=True)
    ]
    return loft(np.stack(rings))


def arms(rng: Generator, bench: Bench, bar: float) -> Mesh:
    """Armrests on front posts, or closed down to the seat."""
    rise, reach = rng.uniform(0.17, 0.26), bench.depth * rng.uniform(0.9, 1.05)
    x, y, z = bench.width / 2 - 0.6 * bar, bench.height + rise, (reach - bench.depth) / 2
    rest, drop = box((1.5 * bar, 0.7 * bar, reach), (x, y, z)), rise + bench.thickness
    breadth, length = (bar, bar) if rng.random() < 0.7 else (0.9 * bar, 0.96 * reach)
    return both_sides(joined(rest, box((breadth, drop, length), (x, y - drop / 2, z + 0.48 * reach - length / 2))))


def arc(section: Float64[ndarray, "N 2"], radius: float, angles: Float64[ndarray, "S"]) -> Mesh:
    """A section of (outward, y) points swept about the y axis at `radius`, through `angles` in radians from -Z."""
    reach = radius + section[:, 0]
    sides = np.stack((np.outer(np.sin(angles), reach), np.outer(np.cos(angles), -reach)), -1)
    return loft(np.insert(sides, 1, section[:, 1], axis=2))
