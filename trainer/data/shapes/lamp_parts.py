"""The parts of a lamp: shades, feet and bodies of revolution.

A part stands on y = 0 around the y axis. A lamp with one arm reaches towards +Z.
"""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, box, cylinder, joined, lathe, moved, turned


class Shade(NamedTuple):
    """A shade that stands on y = 0."""

    mesh: Mesh
    radius: float
    height: float
    socket: float
    """A height at which it is solid around the y axis: there a stem ends."""


ShadeStyle = Literal["drum", "cone", "bell", "dome", "bowl", "globe", "square", "facets", "trumpet"]
STANDING: tuple[ShadeStyle, ...] = ("drum", "drum", "cone", "cone", "cone", "bell", "square", "facets", "dome", "globe")
HANGING: tuple[ShadeStyle, ...] = (
    "drum",
    "cone",
    "bell",
    "dome",
    "dome",
    "globe",
    "trumpet",
    "facets",
    "square",
    "bowl",
)


def shade(rng: Generator, style: ShadeStyle, radius: float, height: float, sides: int = 20) -> Shade:
    """A wall around the bulb, open below, above or both; a globe is closed.

    The wall is a twelfth of the radius thick, and a plate closes it inside, so that bulb and wires need not be shown.
    """
    ends, share = np.array([0.0, 1.0]), np.linspace(0.0, 1.0, 8)
    foot, head = rng.uniform(0.08, 0.45), rng.uniform(0.65, 0.92)
    match style:
        case "drum":
            outer = radius * (1 - rng.uniform(0.0, 0.12) * ends)
        case "cone":
            outer = radius * (1 - rng.uniform(0.25, 0.72) * ends)
        case "bell":
            outer = radius * (1 - rng.uniform(0.4, 0.65) * share ** rng.uniform(0.4, 0.6))
        case "trumpet":
            outer = radius * (0.12 + 0.88 * (1 - share) ** rng.uniform(1.6, 3.0))
        case "dome":
            outer, head = radius * np.sqrt(1 - (0.97 * share) ** rng.uniform(1.8, 3.0)), 1.0
        case "bowl":
            outer, foot = radius * np.sqrt(1 - (0.97 * (1 - share)) ** rng.uniform(1.8, 3.0)), 0.0
        case "globe":
            angle = np.linspace(-0.47, 0.47, 12) * np.pi
            ball = [
                (float(radius * np.cos(a)), float(height / 2 * (1 + np.sin(a) / np.sin(0.47 * np.pi)))) for a in angle
            ]
            return Shade(lathe(ball, sides), radius, height, 0.5 * height)
        case "square":
            outer, sides = radius * (1 - rng.uniform(0.0, 0.5) * ends), 4
        case "facets":
            outer, sides = radius * (1 - rng.uniform(0.1, 0.6) * ends), int(rng.choice([6, 8]))
    return Shade(_shell(outer, height, radius / 12, foot, head, sides), radius, height, (foot + head) / 2 * height)


def _shell(outer: Float64[ndarray, " L"], height: float, wall: float, foot: float, head: float, sides: int) -> Mesh:
    """A wall of outer radii from bottom to top, filled inside from `foot` to `head`, which are shares of the height."""
    levels = np.linspace(0.0, height, len(outer))

    def inside(y: float) -> float:
        return max(float(np.interp(y, levels, outer)) - wall, 0.3 * wall)

    profile = [(float(r), float(y)) for r, y in zip(outer, levels, strict=True)]
    below, above, least = foot * height, head * height, 0.2 * wall
    # The hollows follow the wall level by level, or the inside of a curved wall would break through it.
    if foot > 0:
        hollow = [below, *levels[levels < 0.99 * below][::-1].tolist()]
        profile = [(least, below), *((inside(y), y) for y in hollow), *profile]
    if head < 1:
        hollow = [*levels[levels > 1.01 * above][::-1].tolist(), above]
        profile = [*profile, *((inside(y), y) for y in hollow), (least, above)]
    return lathe(profile, sides)


BodyStyle = Literal["vase", "ball", "gourd", "urn", "column", "candlestick", "cone", "bottle", "block", "discs"]
_PROFILES: dict[BodyStyle, tuple[float, ...]] = {
    "vase": (0.5, 0.7, 0.9, 1.0, 0.95, 0.75, 0.45, 0.3, 0.34),
    "ball": (0.45, 0.78, 0.95, 1.0, 0.98, 0.88, 0.68, 0.35, 0.2),
    "gourd": (0.6, 0.9, 1.0, 0.88, 0.5, 0.52, 0.6, 0.45, 0.22),
    "urn": (0.7, 0.3, 0.28, 0.62, 0.9, 1.0, 0.95, 0.5, 0.3),
    "column": (1.0, 0.92, 0.5, 0.45, 0.44, 0.43, 0.42, 0.5, 0.4),
    "candlestick": (1.0, 0.85, 0.3, 0.25, 0.5, 0.28, 0.24, 0.4, 0.25),
    "cone": (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2),
    "bottle": (0.85, 0.97, 1.0, 1.0, 0.97, 0.7, 0.4, 0.3, 0.28),
    "block": (0.9, 0.9, 0.9, 0.9, 0.9, 0.9, 0.9, 0.9, 0.9),
    "discs": (1.0, 1.0, 0.5, 0.9, 0.9, 0.45, 0.75, 0.75, 0.3),
}
BODIES: tuple[BodyStyle, ...] = tuple(_PROFILES)


def body(rng: Generator, style: BodyStyle, radius: float, height: float) -> Mesh:
    """A turned, cast or thrown body, round or with a few flat sides."""
    radii = radius * np.array(_PROFILES[style]) * rng.uniform(0.88, 1.12, 9)
    sides = 4 if style == "block" and rng.random() < 0.7 else int(rng.choice([16, 16, 16, 6, 4]))
    return lathe([(float(r), float(y)) for r, y in zip(radii, np.linspace(0.0, height, 9), strict=True)], sides)


def foot(rng: Generator, radius: float, height: float) -> Mesh:
    """A disc, a dome, a step or a square plate to stand on."""
    match int(rng.integers(4)):
        case 0:
            return lathe([(radius, 0.0), (radius, 0.7 * height), (0.9 * radius, height)], 20)
        case 1:
            return lathe(
                [(radius, 0.0), (0.95 * radius, 0.5 * height), (0.6 * radius, height), (0.2 * radius, 1.6 * height)], 20
            )
        case 2:
            return lathe(
                [(radius, 0.0), (radius, 0.5 * height), (0.6 * radius, 0.55 * height), (0.55 * radius, height)], 20
            )
        case _:
            return box((1.7 * radius, height, 1.7 * radius), (0.0, height / 2, 0.0), (rng.uniform(0.85, 1.0),) * 2)


def rotated(mesh: Mesh, count: int, start: float = 0.0) -> Mesh:
    """`count` copies of the mesh, evenly spread around the y axis, the first turned by `start` radians."""
    return joined(*(turned(mesh, 1, start + index * 2 * np.pi / count) for index in range(count)))


def tripod(rng: Generator, height: float, spread: float, bar: float) -> Mesh:
    """Three or four legs that meet near the y axis at `height`, with a hub there and perhaps braces."""
    count, top = int(rng.choice([3, 3, 3, 4])), rng.uniform(0.02, 0.2) * spread
    leg = cylinder((0.0, 0.0, spread), (0.0, height, top), bar, 8)
    parts = [rotated(leg, count), lathe([(top + 1.6 * bar, height - 2.5 * bar), (top + 1.6 * bar, height + bar)], 14)]
    if rng.random() < 0.4:
        level = rng.uniform(0.25, 0.5)
        reach = spread + (top - spread) * level
        parts.append(rotated(cylinder((0.0, level * height, 0.0), (0.0, level * height, reach), 0.7 * bar, 6), count))
    return joined(*parts)


def lantern(rng: Generator, radius: float, height: float) -> Mesh:
    """A glazed case: panes on a floor, a roof, and often ribs at the corners."""
    sides, flare = int(rng.choice([4, 4, 6, 8])), rng.uniform(1.0, 1.45)
    base, roof = 0.1 * height, rng.uniform(0.65, 0.75) * height
    low, eaves = 0.72 * radius / flare, 0.8 * radius
    panes = lathe([(0.92 * low, 0.5 * base), (0.92 * eaves, roof + 0.02 * height)], sides)
    floor = lathe([(0.6 * low, 0.0), (1.1 * low, 0.5 * base), (1.1 * low, base)], sides)
    lid = [(radius, roof), (radius, roof + 0.04 * height), (0.35 * radius, 0.9 * height)]
    top = lathe([*lid, (0.2 * radius, 0.92 * height), (0.2 * radius, 0.97 * height), (0.05 * radius, height)], sides)
    parts = [panes, floor, top]
    if rng.random() < 0.7:
        # The corners of a section lie half a side off the z axis.
        turn, rib = np.pi / sides, 0.06 * radius
        post = cylinder((0.0, 0.5 * base, 0.97 * low), (0.0, roof + 0.02 * height, 0.97 * eaves), rib, 6)
        parts.append(rotated(post, sides, turn))
    return joined(*parts)


def at_top(part: Shade, height: float) -> Mesh:
    """The shade, moved so that a stem of `height` metres along the y axis ends in it."""
    return moved(part.mesh, (0.0, height - part.socket, 0.0))


def hanging(part: Shade, cord: float, thickness: float) -> Mesh:
    """The shade on a stem whose upper end, at y = 0, lies `cord` metres above the shade's upper edge."""
    stem = cylinder((0.0, 0.0, 0.0), (0.0, part.socket - part.height - cord, 0.0), thickness, 8)
    return joined(stem, moved(part.mesh, (0.0, -cord - part.height, 0.0)))
