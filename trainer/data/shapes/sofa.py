"""Sofas: straight, with a corner or a chaise, rolled, framed in wood, curved, without arms; one in seven is unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.sofa_parts import (
    ARM_KINDS,
    LEG_KINDS,
    ArmKind,
    BackKind,
    LegKind,
    Style,
    arm,
    legs,
    rounded_rectangle,
    run,
    soft,
)
from trainer.data.shapes.sofa_unusual import make_curved, make_daybed, make_tub
from trainer.data.shapes.solid import Mesh, both_sides, box, joined, loft, mirrored, moved, tube, turned


def make_sofa(rng: Generator) -> Mesh:
    """One sofa, metres, standing on y = 0, its back at -z."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.31, _straight),
        (0.17, _corner),
        (0.11, _chaise),
        (0.08, _chesterfield),
        (0.09, _framed),
        (0.08, _futon),
        (0.04, make_daybed),
        (0.05, make_curved),
        (0.03, make_tub),
        (0.04, _recamier),
    )
    shares = np.array([share for share, _ in builders])
    return builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)


def _style(rng: Generator, backs: tuple[BackKind, ...] = ("plain", "cushions", "cushions", "roll", "hump")) -> Style:
    seat, lift = rng.uniform(0.34, 0.5), rng.choice([0.0, 1.0, 1.0]) * rng.uniform(0.06, 0.18)
    pad = rng.uniform(0.09, min(0.22, seat - lift - 0.06))
    return Style(
        depth=rng.uniform(0.72, 1.1),
        seat=seat,
        top=rng.uniform(0.62, 1.15),
        back=rng.uniform(0.1, 0.26),
        lift=lift,
        pad=pad,
        soft=rng.uniform(0.015, 0.08),
        lean=rng.uniform(0.0, 0.2),
        back_kind=backs[rng.integers(len(backs))],
    )


def _pillows(rng: Generator, style: Style, reach: float) -> list[Mesh]:
    """At times a loose pillow leans at either end."""
    if rng.random() > 0.25:
        return []
    size = rng.uniform(0.34, 0.46)
    z = -style.depth / 2 + style.back + (0.2 if style.back_kind == "cushions" else 0.1)
    pillow = soft((size, size, 0.13), (reach - 0.55 * size, style.seat + 0.47 * size, z), 0.06)
    return [both_sides(turned(turned(pillow, 0, -0.35, (0.0, style.seat, z)), 1, -0.2, (reach, 0.0, z)))]


def _straight(rng: Generator) -> Mesh:
    """One broad seat or two to four between two arms."""
    style, seats = _style(rng), int(rng.choice([1, 2, 2, 3, 3, 3, 4]))
    length = max(seats * rng.uniform(0.52, 0.85), 0.9)
    kind, width = ARM_KINDS[rng.integers(len(ARM_KINDS))], rng.uniform(0.08, 0.36)
    height = rng.uniform(style.seat + 0.08, max(style.top - 0.05, style.seat + 0.12))
    sides = both_sides(arm(kind, style, length / 2 - 0.005, width, height))
    reach = length / 2 + (0.0 if kind == "frame" else 0.8 * width)
    parts = [*run(style, length, seats), sides, *_pillows(rng, style, length / 2)]
    if kind != "frame" or style.lift < 0.05:
        parts.append(legs(style, _feet(rng), reach, -style.front, style.front))
    return joined(*parts)


def _feet(rng: Generator) -> LegKind:
    return LEG_KINDS[rng.integers(len(LEG_KINDS))]


def _wing(style: Style, length: float, seats: int, side: float, feet: LegKind, end: Mesh | None) -> Mesh:
    """A run along the +x side that faces -x, before the corner of a run whose right end lies at x = `side`."""
    parts = [*run(style, length, seats), legs(style, feet, length / 2, -style.front, style.front)]
    facing = turned(joined(*parts, *([end] if end else [])), 1, -np.pi / 2)
    return moved(facing, (side - style.front, 0.0, style.front + length / 2))


def _corner(rng: Generator) -> Mesh:
    """Two runs at a right angle; in one case out of six, two wings."""
    style = _style(rng, ("plain", "cushions", "cushions"))._replace(lean=0.02, depth=rng.uniform(0.75, 1.0))
    seats, wing_seats = int(rng.integers(2, 4)), int(rng.integers(1, 4))
    pitch, height, width = rng.uniform(0.58, 0.75), rng.uniform(style.seat + 0.08, style.top), rng.uniform(0.1, 0.26)
    both, feet = rng.random() < 1 / 6, _feet(rng)
    half, wing = (seats * pitch + style.depth * (2 if both else 1)) / 2, wing_seats * pitch
    kind: ArmKind = "block" if rng.random() < 0.6 else "soft"
    end = arm(kind, style, wing / 2 - 0.005, width, height) if rng.random() < 0.5 else None
    # The corner's own side is closed by an arm as high as the back.
    closed = joined(
        _wing(style, wing, wing_seats, half, feet, end), arm("block", style, half - style.back, style.back, style.top)
    )
    main = joined(*run(style, 2 * half, seats + 1 + both), legs(style, feet, half, -style.front, style.front))
    if both:
        return joined(main, both_sides(closed))
    whole = joined(main, closed, mirrored(arm(kind, style, half - 0.005, width, height)))
    return mirrored(whole) if rng.random() < 0.5 else whole


def _chaise(rng: Generator) -> Mesh:
    """A row whose last seat reaches forward far enough to lie on."""
    style, seats = _style(rng, ("plain", "cushions", "cushions")), int(rng.integers(1, 4))
    pitch, front = rng.uniform(0.58, 0.78), rng.uniform(0.5, 0.85)
    half, kind = (seats + 1) * pitch / 2, (ARM_KINDS[:5])[rng.integers(5)]
    width, height = rng.uniform(0.1, 0.26), rng.uniform(style.seat + 0.08, style.top - 0.03)
    sides = both_sides(arm(kind, style, half - 0.005, width, height))
    row = moved(joined(*run(style, seats * pitch, seats)), (-pitch / 2, 0.0, 0.0))
    lounge = [*run(style, pitch, 1, front), legs(style, "blocks", 0.95 * pitch / 2, -style.front, style.front + front)]
    under = legs(style, "blocks", half + 0.7 * width, -style.front, style.front)
    whole = joined(row, moved(joined(*lounge), (half - pitch / 2, 0.0, 0.0)), sides, under)
    return mirrored(whole) if rng.random() < 0.5 else whole


def _chesterfield(rng: Generator) -> Mesh:
    """Arms as high as the back, one roll around all three sides."""
    style = _style(rng, ("plain",))._replace(depth=rng.uniform(0.8, 1.0), lean=0.0)
    seats, roll, wall = int(rng.integers(2, 4)), rng.uniform(0.08, 0.13), rng.uniform(0.1, 0.18)
    half, top = seats * rng.uniform(0.55, 0.75) / 2, rng.uniform(style.seat + 0.2, style.seat + 0.38)
    s = style._replace(back=wall, top=top - roll)
    side = both_sides(arm("block", s, half - 0.005, wall, top - roll))
    y, x, rear, tip = top - roll, half + 0.6 * wall, -s.front + 0.4 * wall, s.front + 0.01
    bend = 1.15 * roll
    arc = [(x - bend * (1 - np.cos(a)), y, rear + bend * (1 - np.sin(a))) for a in np.linspace(0.0, np.pi / 2, 5)]
    path = np.array([(x, y, tip), *arc, *((-px, py, pz) for px, py, pz in arc[::-1]), (-x, y, tip)])
    return joined(
        *run(s, 2 * half, seats), side, tube(path, roll, 14), legs(s, "round", half + wall, -s.front, s.front)
    )


def _framed(rng: Generator) -> Mesh:
    """Loose cushions in a wooden frame with open sides and a slatted back."""
    style = _style(rng)._replace(
        lift=rng.uniform(0.2, 0.28), back=0.05, depth=rng.uniform(0.7, 0.85), back_kind="cushions"
    )
    style = style._replace(
        seat=style.lift + rng.uniform(0.16, 0.22), pad=rng.uniform(0.1, 0.15), lean=rng.uniform(0.1, 0.25)
    )
    seats, bar = int(rng.integers(2, 4)), rng.uniform(0.022, 0.035)
    length, height = seats * rng.uniform(0.58, 0.72), style.seat + rng.uniform(0.14, 0.24)
    # The run's own frame becomes a thin seat board; its back panel gives way to slats.
    board, *soft_parts = run(style, length, seats)
    cushions, padding = soft_parts[:seats], soft_parts[seats + 1 :]
    rear, low, top = -style.front + 0.03, style.lift + 0.03, style.top
    rails = [box((length, 0.06, 0.03), (0.0, y, rear)) for y in (top - 0.03, style.seat + 0.05)]
    for x in np.linspace(-0.46, 0.46, 4 * seats + 1) * length:
        rails.append(box((0.035, top - style.seat - 0.03, 0.02), (x, (top + style.seat) / 2, rear)))
    posts = tube([(length / 2, low - 0.02, rear), (length / 2, top, rear)], bar, square=True)
    grid = turned(joined(*rails, both_sides(posts)), 0, -style.lean, (0.0, low, rear))
    sides = both_sides(arm("frame", style, length / 2 - bar, 0.1, height))
    return joined(board, *cushions, *padding, grid, sides)


def _futon(rng: Generator) -> Mesh:
    """A thick mattress folded over a low base, without arms, or between thin rails."""
    length, depth, pad = rng.uniform(1.5, 2.2), rng.uniform(0.75, 1.0), rng.uniform(0.14, 0.24)
    seat, rise, lean = rng.uniform(0.34, 0.46), rng.uniform(0.4, 0.6), rng.uniform(0.15, 0.5)
    tilt, folds = rng.uniform(0.0, 0.12), int(rng.choice([1, 1, 2, 3]))
    width = length / folds
    parts = []
    for index in range(folds):
        x = (index + 0.5) * width - length / 2
        flat = soft((width - 0.006, pad, depth), (x, seat - pad / 2, 0.0), 0.4 * pad, 0.02)
        upright = soft((width - 0.006, rise + pad, pad), (x, seat + (rise - pad) / 2, (pad - depth) / 2), 0.4 * pad)
        parts += [turned(flat, 0, -tilt), turned(upright, 0, -lean, (0.0, seat - pad, pad / 2 - depth / 2))]
    low = seat - pad
    if rng.random() < 0.5:
        parts.append(box((0.94 * length, low + 0.05, 0.8 * depth), (0.0, (low + 0.05) / 2, 0.0)))
    else:
        parts.append(box((0.94 * length, 0.12, 0.85 * depth), (0.0, low - 0.01, 0.0)))
        x, z = 0.42 * length, 0.36 * depth
        parts.append(both_sides(joined(*(tube([(x, 0.0, end), (x, low, end)], 0.03, 8) for end in (-z, z)))))
    if rng.random() < 0.3:
        x, high, end = length / 2 + 0.03, seat + 0.18, 0.5 * depth
        loop = [(x, 0.0, -end), (x, high, -end), (x, high, end), (x, 0.0, end)]
        stretcher = box((0.03 * length + 0.12, 0.06, depth), (x - 0.015 * length - 0.04, low - 0.03, 0.0))
        parts.append(both_sides(joined(tube(loop, 0.025, square=True), stretcher)))
    return joined(*parts)


def _recamier(rng: Generator) -> Mesh:
    """A couch with one raised end and a back that falls away from it."""
    style = _style(rng, ("plain",))._replace(lift=rng.uniform(0.1, 0.18), depth=rng.uniform(0.65, 0.8))
    length, high, wall = rng.uniform(1.5, 1.9), rng.uniform(0.75, 0.95), 0.12
    under = style.seat - style.pad
    base = soft((length, under - style.lift, style.depth), (0.0, (under + style.lift) / 2, 0.0), 0.02)
    pad = soft((length, style.pad + 0.02, style.depth), (0.0, style.seat - style.pad / 2 - 0.01, 0.0), 0.05, 0.02)
    end = turned(
        arm("roll", style, length / 2 - 0.1, 0.2, high - 0.05),
        2,
        -rng.uniform(0.0, 0.15),
        (length / 2, style.seat, 0.0),
    )
    share, reach = np.linspace(0.0, 1.0, 9), rng.uniform(0.6, 0.95) * length
    tops = style.seat + 0.04 + (high - style.seat - 0.04) * (1 - np.cos(np.pi * share)) / 2
    rings = []
    for x, y in zip(length / 2 - reach * (1 - share), tops, strict=True):
        half = (y - under) / 2
        outline = rounded_rectangle(half, wall / 2, 0.02)
        rings.append(
            np.stack((np.full(12, x), outline[:, 0] + under + half, outline[:, 1] - style.front + wall / 2), -1)
        )
    whole = joined(base, pad, end, loft(np.stack(rings)), legs(style, "splayed", length / 2, -style.front, style.front))
    return mirrored(whole) if rng.random() < 0.5 else whole
