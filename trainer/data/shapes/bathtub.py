"""Bathtubs: built-in, free-standing, on claw feet, with a raised end, in a corner, round, deep; all are hollow.

The builders lay a tub along z, its taps towards +z; `make_bathtub` turns its long side to the front.
"""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.bathtub_parts import Level, basin, cast_bowl, claws, corner_outline, shell, steps, tap
from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, joined, loft, moved, ring, tube, turned


def make_bathtub(rng: Generator) -> Mesh:
    """One bathtub, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.24, _built_in),
        (0.19, _free_standing),
        (0.15, _claw_foot),
        (0.10, _slipper),
        (0.10, _corner_tub),
        (0.08, _round_tub),
        (0.05, _barrel),
        (0.06, _deep_box),
        (0.03, _walk_in),
    )
    shares = np.array([share for share, _ in builders])
    return turned(builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng), 1, np.pi / 2)


def _built_in(rng: Generator) -> Mesh:
    """A box with a flat rim around a rectangular, rounded or oval basin; at times on a step."""
    half_x, half_z, rim = rng.uniform(0.33, 0.48), rng.uniform(0.7, 0.95), rng.uniform(0.42, 0.62)
    side, deck, back = rng.uniform(0.06, 0.11), rng.uniform(0.08, 0.22), rng.uniform(0.06, 0.12)
    roundness, corners = rng.choice([2.2, 4.0, 8.0, 14.0]), rng.choice([60.0, 60.0, 12.0])
    floor, slope = rng.uniform(0.06, 0.12), rng.uniform(0.1, 0.4)
    apron = [
        Level(half_x - 0.01, half_z - 0.01, 0.0, 0.0, corners),
        Level(half_x - 0.01, half_z - 0.01, rim - 0.05, 0.0, corners),
        Level(half_x, half_z, rim - 0.05 + 0.005, 0.0, corners),
        Level(half_x, half_z, rim - 0.01, 0.0, corners),
        Level(half_x - 0.012, half_z - 0.012, rim, 0.0, corners),
    ]
    shift = (back - deck) / 2
    inside = basin(half_x - side, half_z - (deck + back) / 2, rim, floor, slope, rng.uniform(0.02, 0.07), roundness)
    parts = [shell([*apron, *(level._replace(shift=level.shift + shift) for level in inside)])]
    if rng.random() < 0.65:
        parts.append(tap(rim, half_z - 0.5 * deck, rng.uniform(0.13, 0.2)))
    if rng.random() < 0.25:
        x, z = half_x - 0.5 * side, rng.uniform(0.0, 0.3)
        grip = [
            (x, rim - 0.02, z - 0.14),
            (x, rim + 0.09, z - 0.12),
            (x, rim + 0.09, z + 0.12),
            (x, rim - 0.02, z + 0.14),
        ]
        parts.append(both_sides(tube(grip, 0.018, 8)))
    if rng.random() < 0.15:
        edge, height = rng.uniform(0.08, 0.2), rng.uniform(0.06, 0.14)
        parts.append(box((2 * (half_x + edge), height, 2 * (half_z + edge)), (0.0, height / 2, 0.0)))
    return joined(*parts)


def _free_standing(rng: Generator) -> Mesh:
    """A wall that widens towards a narrow rim, on the floor or on a plinth; oval to nearly rectangular."""
    half_x, half_z, rim = rng.uniform(0.36, 0.48), rng.uniform(0.75, 0.95), rng.uniform(0.5, 0.66)
    roundness, wall = rng.choice([2.0, 2.5, 3.5, 8.0, 40.0]), rng.uniform(0.05, 0.085)
    foot, lip = rng.uniform(0.62, 0.98), rng.choice([0.0, 0.03])
    belly = foot + (1 - foot) * rng.uniform(0.36, 0.71)
    outside = [
        Level(foot * half_x, half_z * (1 - 0.8 * (1 - foot)), 0.0, 0.0, roundness),
        Level(belly * half_x, half_z * (1 - 0.8 * (1 - belly)), 0.5 * rim, 0.0, roundness),
        Level(half_x, half_z, rim - 0.045, 0.0, roundness),
        Level(half_x + lip, half_z + lip, rim - 0.04, 0.0, roundness),
        Level(half_x + lip, half_z + lip, rim - 0.01, 0.0, roundness),
        Level(half_x + lip - 0.012, half_z + lip - 0.012, rim, 0.0, roundness),
    ]
    narrowing = (1 - foot) * half_x
    both = rng.random() < 0.4
    slope = narrowing + 0.08 if both else rng.uniform(0.15, 0.4)
    inside = basin(
        half_x - wall,
        half_z - wall,
        rim,
        rng.uniform(0.08, 0.14),
        slope,
        max(narrowing, 0.04) + (0.08 if both else 0.0),
        roundness,
    )
    rise = rng.choice([0.0, 0.0, 1.0]) * rng.uniform(0.05, 0.12)
    return joined(shell([*outside, *inside], rise, both_ends=True))


def _claw_foot(rng: Generator) -> Mesh:
    """A cast bowl on four curved feet; one end may be raised."""
    half_x, half_z = rng.uniform(0.34, 0.42), rng.uniform(0.65, 0.88)
    low, rise = rng.uniform(0.12, 0.2), rng.choice([0.0, 1.0]) * rng.uniform(0.1, 0.25)
    rim = low + rng.uniform(0.4, 0.48)
    parts = [cast_bowl(rng, low, rim, half_x, half_z, rise, False)]
    parts.append(claws(0.68 * half_x, 0.62 * half_z, low, rng.uniform(0.035, 0.05)))
    if rng.random() < 0.6:
        parts.append(tap(rim, half_z - 0.01, rng.uniform(0.14, 0.22)))
    return joined(*parts)


def _slipper(rng: Generator) -> Mesh:
    """A high back, or two, over a skirt or a plinth."""
    half_x, half_z = rng.uniform(0.34, 0.42), rng.uniform(0.7, 0.9)
    low, rise, both = rng.uniform(0.05, 0.1), rng.uniform(0.16, 0.34), rng.random() < 0.3
    bowl = cast_bowl(rng, low, low + rng.uniform(0.42, 0.52), half_x, half_z, 0.7 * rise if both else rise, both)
    x, z = 0.72 * half_x, 0.78 * half_z
    plinth = shell([Level(1.1 * x, 1.06 * z, 0.0), Level(1.1 * x, 1.06 * z, 0.4 * low), Level(x, z, low + 0.08)])
    return joined(bowl, plinth)


def _corner_tub(rng: Generator) -> Mesh:
    """Two straight sides that meet at -z, a bowed or straight front, and a basin that follows them or is oval."""
    size, rim, width = rng.uniform(1.15, 1.5), rng.uniform(0.48, 0.65), rng.uniform(0.09, 0.14)
    front, bowed = size * rng.uniform(1.0, 1.2), rng.random() < 0.65
    floor, bench, oval = rng.uniform(0.08, 0.14), rng.uniform(0.3, 0.4), rng.random() < 0.5
    outside = [(0.0, 0.015), (rim - 0.06, 0.015), (rim - 0.055, 0.0), (rim - 0.01, 0.0), (rim, 0.012)]
    inside = [(rim, width), (rim - 0.03, width + 0.02)]
    if rng.random() < 0.5:
        inside += [(bench + 0.01, width + 0.05), (bench, width + 0.16)]
    inside += [(floor + 0.06, width + 0.19), (floor, width + 0.25)]
    rings = [corner_outline(size, front, inset, y, bowed) for y, inset in outside]
    for y, inset in inside:
        around = 0.44 * size - inset
        circle = corner_outline(size, front, inset, y, bowed) if not oval else ring(1.25 * around, around, y, 32)
        rings.append(circle)
    parts = [loft(np.stack(rings))]
    if rng.random() < 0.6:
        parts.append(
            moved(turned(tap(rim, 0.0, rng.uniform(0.14, 0.2)), 1, np.pi), (0.0, 0.0, 0.4 * width - 0.62 * size + 0.2))
        )
    return joined(*parts)


def _round_tub(rng: Generator) -> Mesh:
    """A whirlpool for several: round, eight-sided or square with a bench inside, often with steps in front."""
    half, rim, wall = rng.uniform(0.75, 1.1), rng.uniform(0.65, 0.95), rng.uniform(0.12, 0.17)
    roundness, stretch = rng.choice([2.0, 2.0, 5.0, 12.0]), rng.choice([1.0, 1.0, 1.2])
    bench, floor, foot = 0.5 * rim, 0.12, rng.uniform(0.95, 1.0)
    profile = [
        (foot * half - 0.03, 0.0),
        (half - 0.03, rim - 0.1),
        (half, rim - 0.09),
        (half, rim - 0.015),
        (half - 0.02, rim),
    ]
    profile += [(half - wall, rim), (half - wall - 0.03, rim - 0.04), (half - wall - 0.04, bench + 0.01)]
    profile += [(0.58 * half, bench), (0.54 * half, floor + 0.02), (0.5 * half, floor)]
    levels = [Level(r, r + (stretch - 1) * half, y, 0.0, roundness) for r, y in profile]
    parts = [shell(levels)]
    if rng.random() < 0.6:
        parts.append(
            steps(rng.uniform(0.5, 0.9), (foot + stretch - 1) * half - 0.03, 0.9 * rim, int(rng.integers(1, 4)))
        )
    if rng.random() < 0.4:
        rest = cushion((0.34, 0.1, 0.16), (0.0, rim, half * stretch - 0.5 * wall), 0.03, 4.0)
        parts += [turned(rest, 1, azimuth) for azimuth in (np.pi / 2, np.pi, -np.pi / 2)] if stretch == 1.0 else []
    return joined(*parts)


def _barrel(rng: Generator) -> Mesh:
    """A deep wooden tub with hoops, round or oval, with a bench inside."""
    half_x, rim, wall = rng.uniform(0.4, 0.6), rng.uniform(0.55, 0.9), rng.uniform(0.045, 0.07)
    half_z, foot = half_x * rng.choice([1.0, rng.uniform(1.2, 1.9)]), rng.uniform(0.8, 1.0)
    bench, floor = 0.45 * rim, 0.1
    outside = [Level(foot * half_x, foot * half_z, 0.0)]
    for y, out in (
        (0.12, 0.0),
        (0.125, 0.02),
        (0.2, 0.02),
        (0.205, 0.0),
        (0.7, 0.0),
        (0.705, 0.02),
        (0.78, 0.02),
        (0.785, 0.0),
    ):
        share = foot + (1 - foot) * y
        outside.append(Level(share * half_x + out, share * half_z + out, y * rim))
    outside.append(Level(half_x, half_z, rim))
    low, middle = foot + (1 - foot) * floor / rim, 0.5 * (1 + foot)
    # The well for the feet reaches from behind the middle to the wall in front.
    front, rear = low * half_z - 1.2 * wall, -0.3 * half_z
    well = ((front - rear) / 2, (front + rear) / 2)
    inside = [
        Level(half_x - wall, half_z - wall, rim),
        Level(middle * half_x - wall, middle * half_z - wall, bench + 0.01),
        Level(low * half_x - 1.1 * wall, well[0], bench, well[1]),
        Level(low * half_x - 1.5 * wall, well[0] - 0.01, floor, well[1]),
    ]
    parts = [shell([*outside, *inside])]
    if foot > 0.93:
        parts.append(steps(0.5, foot * half_z, 0.85 * rim, 2))
    return joined(*parts)


def _deep_box(rng: Generator) -> Mesh:
    """A short, deep tub of boards whose ends stand out at the corners, with a seat inside."""
    half_x, half_z, rim = rng.uniform(0.33, 0.45), rng.uniform(0.42, 0.75), rng.uniform(0.55, 0.8)
    wall, floor, seat = rng.uniform(0.05, 0.075), 0.08, rng.uniform(0.28, 0.36)
    levels = [Level(half_x, half_z, y, 0.0, 60.0) for y in (0.0, rim)]
    levels += [Level(half_x - wall, half_z - wall, y, 0.0, 60.0) for y in (rim, floor)]
    parts = [shell(levels)]
    bench = rng.uniform(0.22, 0.32)
    parts.append(box((2 * half_x - wall, seat, bench), (0.0, seat / 2, bench / 2 - half_z + 0.5 * wall)))
    reach, edge = half_x + rng.uniform(0.03, 0.08), rng.uniform(0.08, 0.12)
    for z in (-half_z + 0.5 * wall, half_z - 0.5 * wall):
        parts.append(box((2 * reach, edge, 1.1 * wall), (0.0, rim - 0.4 * edge, z)))
    if rng.random() < 0.5:
        parts += [box((2 * half_x + 0.04, 0.08, 0.1), (0.0, 0.01, z)) for z in (-0.6 * half_z, 0.6 * half_z)]
    if rng.random() < 0.4:
        parts.append(steps(2 * half_x, half_z, 0.5 * rim, 1))
    whole = joined(*parts)
    return moved(whole, (0.0, -whole.vertices[:, 1].min(), 0.0))


def _walk_in(rng: Generator) -> Mesh:
    """As high as a chest, with a seat behind and a well for the feet in front."""
    half_x, half_z, rim = rng.uniform(0.36, 0.42), rng.uniform(0.5, 0.7), rng.uniform(0.85, 1.0)
    wall, seat, floor, corners = rng.uniform(0.05, 0.07), rng.uniform(0.38, 0.46), 0.1, rng.choice([60.0, 10.0])
    x, z, well = half_x - wall, half_z - wall, rng.uniform(0.5, 0.6)
    levels = [Level(half_x, half_z, y, 0.0, corners) for y in (0.0, rim)]
    levels += [Level(x, z, rim, 0.0, 8.0), Level(0.98 * x, 0.98 * z, seat + 0.01, 0.0, 8.0)]
    levels += [
        Level(0.94 * x, well * z, seat, (0.96 - well) * z, 8.0),
        Level(0.9 * x, 0.96 * well * z, floor, (0.96 - well) * z, 8.0),
    ]
    door = box((0.03, rim - 0.2, 0.5 * half_z), (half_x, rim / 2 + 0.06, 0.4 * half_z))
    grip = tube(
        [
            (half_x, 0.7 * rim, 0.3 * half_z),
            (half_x + 0.07, 0.7 * rim, 0.3 * half_z),
            (half_x + 0.07, 0.5 * rim, 0.3 * half_z),
        ],
        0.02,
        8,
    )
    return joined(shell(levels, 0.12), door, grip, tap(rim, half_z - 0.5 * wall, 0.15, knobs=False))
