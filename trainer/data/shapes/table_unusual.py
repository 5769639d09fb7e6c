"""Tables that one meets less often: for games, drawing and work, against a wall, over a bed, and as sculpture."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, moved, tube, turned
from trainer.data.shapes.table_parts import CORNERS, Leg, Outline, Top, board, drawers, front_and_back, leg, table_top
from trainer.data.shapes.table_supports import frames, legs, panels


def make_half_round(rng: Generator) -> Mesh:
    """A half-moon that stands with its straight side against a wall."""
    width, high, bar = rng.uniform(0.8, 1.4), rng.uniform(0.72, 0.85), rng.uniform(0.045, 0.08)
    depth, thick = width * rng.uniform(0.38, 0.55), rng.uniform(0.03, 0.05)
    angle = np.linspace(0.0, np.pi, 15)
    half = np.stack((width / 2 * np.cos(angle), depth * np.sin(angle) - depth / 2), -1)
    under, drop = high - thick / 2, rng.uniform(0.08, 0.14)
    parts = [board(half, [(high - thick, 0.0), (high, 0.0)]), board(half * 0.9, [(under - drop, 0.0), (under, 0.0)])]
    styles: tuple[Leg, ...] = ("straight", "tapered", "turned", "cabriole")
    style = styles[rng.integers(4)]
    for share in (0.06, 0.36):
        x, z = 0.45 * width * np.cos(share * np.pi), 0.86 * depth * np.sin(share * np.pi) - 0.45 * depth
        parts.append(both_sides(leg(rng, style, (x, z), (x, z), under, bar)))
    if rng.random() < 0.4:
        parts.append(board(half * 0.75, [(0.18 * high, 0.0), (0.18 * high + 0.03, 0.0)]))
    return joined(*parts)


def make_drop_leaf(rng: Generator) -> Mesh:
    """A narrow top whose leaves hang down, or stand out on one side."""
    width, depth, high = rng.uniform(0.8, 1.2), rng.uniform(0.35, 0.6), rng.uniform(0.7, 0.76)
    leaf, thick = min(rng.uniform(0.3, 0.5), high - 0.15), rng.uniform(0.03, 0.045)
    top = Top(width, depth, high, thick)
    hanging = box((width, thick, leaf), (0.0, high - thick / 2, depth / 2 + leaf / 2 + 0.005))
    raised = rng.random() < 0.4
    hinge = (0.0, high - thick / 2, depth / 2 - 0.005)
    down = turned(hanging, 0, rng.uniform(1.42, 1.52), hinge)
    behind = Mesh(down.vertices * (1.0, 1.0, -1.0), down.faces[:, ::-1])
    gate = leg(rng, "straight", (0.0, depth / 2 + 0.7 * leaf), (0.0, depth / 2 + 0.7 * leaf), top.under, 0.05)
    front = (
        [hanging, gate, box((0.04, 0.06, leaf + depth / 2), (0.0, top.under - 0.05, leaf / 2 + depth / 4))]
        if raised
        else [down]
    )
    return joined(table_top(rng, top, "rectangle"), legs(rng, top, rng.uniform(0.05, 0.07)), behind, *front)


def make_games(rng: Generator) -> Mesh:
    """A billiard table with its raised cushions, or a table-tennis table with its net."""
    if rng.random() < 0.6:
        width, high, rim = rng.uniform(1.9, 2.8), rng.uniform(0.78, 0.86), rng.uniform(0.09, 0.15)
        depth, drop, bar = width * rng.uniform(0.5, 0.58), rng.uniform(0.12, 0.28), rng.uniform(0.12, 0.2)
        x, z, rail = width / 2 - rim / 2, depth / 2 - rim / 2, 0.12
        bed = box((width - rim, drop, depth - rim), (0.0, high - rail / 2 - drop / 2, 0.0))
        edge = joined(both_sides(box((rim, rail, depth), (x, high - rail / 2 + 0.03, 0.0))))
        side = front_and_back(box((2 * x, rail, rim), (0.0, high - rail / 2 + 0.03, z)))
        styles: tuple[Leg, ...] = ("turned", "turned", "straight", "tapered")
        foot = (x - bar, z - bar / 2)
        return joined(
            bed, edge, side, front_and_back(both_sides(leg(rng, styles[rng.integers(4)], foot, foot, high - rail, bar)))
        )
    top = Top(2.74, 1.525, 0.76, rng.uniform(0.04, 0.06))
    net = box((0.03, 0.16, 1.7), (0.0, 0.83, 0.0))
    supports = panels(rng, top) if rng.random() < 0.3 else frames(rng, top, rng.uniform(0.05, 0.08))
    return joined(table_top(rng, top, "rectangle"), net, supports)


def make_drafting(rng: Generator) -> Mesh:
    """A board tilted towards the person who draws."""
    width, depth, high = rng.uniform(0.8, 1.4), rng.uniform(0.6, 0.9), rng.uniform(0.75, 0.95)
    tilt, bar = rng.uniform(0.15, 0.7), rng.uniform(0.045, 0.08)
    plate = box((width, rng.uniform(0.03, 0.06), depth), (0.0, 0.0, 0.0))
    ledge = box((0.9 * width, 0.06, 0.03), (0.0, 0.02, depth / 2 - 0.02))
    tilted = moved(turned(joined(plate, ledge), 0, tilt), (0.0, high, 0.0))
    x, foot = width * rng.uniform(0.3, 0.42), 0.42 * depth
    sole = box((1.2 * bar, bar, 2 * foot), (x, bar / 2, 0.0))
    post = box((bar, high, 1.6 * bar), (x, high / 2, 0.0))
    beam = box((2 * x, 1.6 * bar, 0.6 * bar), (0.0, high * rng.uniform(0.2, 0.5), 0.0))
    return joined(tilted, both_sides(joined(sole, post)), beam)


def make_sculptural(rng: Generator) -> Mesh:
    """A slab on crossed boards, leaning rods, a tree's stump or a bowl."""
    width, high = rng.uniform(0.7, 1.3), rng.uniform(0.36, 0.74)
    style: Outline = ("oval", "oval", "rounded", "rectangle")[rng.integers(4)]
    top = Top(width, width * rng.uniform(0.7, 1.0), high, rng.uniform(0.025, 0.05), CORNERS[style])
    reach = 0.45 * top.depth
    match int(rng.integers(4)):
        case 0:
            wall = box((0.06, top.under, 2 * reach), (0.0, top.under / 2, 0.0), (1.0, rng.uniform(0.4, 1.0)))
            angle = rng.uniform(0.5, 0.8)
            base = joined(turned(wall, 1, angle), turned(wall, 1, -angle))
        case 1:
            count, twist = int(rng.integers(3, 8)), rng.uniform(1.2, 2.6)
            end = (0.9 * reach * np.sin(twist), top.under, 0.9 * reach * np.cos(twist))
            rod = tube([(0.0, 0.0, 0.9 * reach), end], rng.uniform(0.018, 0.03), 8)
            base = joined(*(turned(rod, 1, angle) for angle in np.arange(count) * 2 * np.pi / count))
        case 2:
            levels = np.linspace(0.0, top.under, 6)
            radii = reach * rng.uniform(0.4, 0.6) * np.array([1.5, 1.1, 1.0, 0.95, 1.0, 1.2])
            base = lathe([(float(r), float(y)) for r, y in zip(radii, levels, strict=True)], 11)
        case _:
            levels = np.linspace(0.0, 1.0, 8)
            radii = reach * (0.35 + 0.65 * np.sqrt(1 - (1 - levels) ** 2 * 0.95))
            base = lathe([(float(r), float(y * top.under)) for r, y in zip(radii, levels, strict=True)], 20)
    return joined(table_top(rng, top, style), base)


def make_workbench(rng: Generator) -> Mesh:
    """A heavy top on heavy legs, with a shelf, a vice, and perhaps a board for tools behind."""
    width, depth, high = rng.uniform(1.2, 2.0), rng.uniform(0.55, 0.75), rng.uniform(0.8, 0.95)
    thick, bar = rng.uniform(0.06, 0.12), rng.uniform(0.08, 0.12)
    top = Top(width, depth, high, thick)
    x, z = top.spot(bar, 0.03)
    parts = [
        box((width, thick, depth), (0.0, high - thick / 2, 0.0)),
        front_and_back(both_sides(box((bar, top.under, bar), (x, top.under / 2, z)))),
        box((2 * x, 0.05, 2 * z), (0.0, rng.uniform(0.15, 0.3), 0.0)),
    ]
    if rng.random() < 0.6:
        vice = rng.uniform(0.25, 0.4) * width
        jaw = box((0.22, 0.16, 0.08), (vice, high - 0.08, depth / 2 + 0.1))
        parts += [jaw, tube([(vice, high - 0.1, depth / 2 - 0.1), (vice, high - 0.1, depth / 2 + 0.24)], 0.025, 8)]
    if rng.random() < 0.5:
        rise = rng.uniform(0.3, 0.7)
        parts.append(box((width, rise, 0.04), (0.0, high + rise / 2 - 0.02, -depth / 2 + 0.02)))
        parts.append(box((width, 0.03, 0.22), (0.0, high + 0.7 * rise, -depth / 2 + 0.13)))
    if rng.random() < 0.5:
        parts.append(box((2 * x, 0.18, 2 * z), (0.0, top.under - 0.1, 0.0)))
        parts.append(drawers((-x + bar / 2, top.under - 0.2), (x - bar / 2, top.under - 0.02), z, 1, 3, 0.1))
    return joined(*parts)


def make_cantilever(rng: Generator) -> Mesh:
    """A top that reaches forward over its foot, to be pushed over a bed or a sofa."""
    width, depth, high = rng.uniform(0.45, 0.8), rng.uniform(0.3, 0.5), rng.uniform(0.52, 0.85)
    thick, bar = rng.uniform(0.025, 0.05), rng.uniform(0.035, 0.06)
    spread = width * rng.uniform(0.2, 0.45)
    parts = [box((width, thick, depth), (0.0, high - thick / 2, 0.0))]
    if rng.random() < 0.4:
        parts.append(box((width, high - thick, thick), (0.0, high / 2, (thick - depth) / 2)))
        parts.append(box((width, thick, 0.9 * depth), (0.0, thick / 2, -0.05 * depth)))
    else:
        z = -depth / 2 + bar
        parts.append(both_sides(box((bar, high - thick, bar), (spread, high / 2, z))))
        parts.append(both_sides(box((bar, bar, 0.9 * depth), (spread, bar / 2, -0.05 * depth))))
        parts.append(box((2 * spread, bar, bar), (0.0, bar / 2, z)))
    return joined(*parts)
