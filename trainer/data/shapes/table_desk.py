"""Tables with drawers and compartments: desks, corner desks, secretaries, and low cabinets."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, moved, prism
from trainer.data.shapes.table_parts import Leg, Top, drawers, front_and_back, leg


def make_desk(rng: Generator) -> Mesh:
    """A desk with drawers under one end, both ends or the top, and perhaps shelves on it; the sitter's side is +Z."""
    top = Top(rng.uniform(1.0, 1.9), rng.uniform(0.5, 0.9), rng.uniform(0.71, 0.79), rng.uniform(0.03, 0.07))
    parts = [_board(top), *_under(rng, top)]
    if rng.random() < 0.25:
        parts.append(_hutch(rng, top))
    return joined(*parts)


def _board(top: Top) -> Mesh:
    return box((top.width, top.thickness, top.depth), (0.0, top.height - top.thickness / 2, 0.0))


def _under(rng: Generator, top: Top) -> list[Mesh]:
    """What stands between the floor and the top of a desk."""
    overhang = rng.uniform(0.01, 0.06)
    case = rng.uniform(0.24, 0.34) * min(top.width, 1.5)
    x, z = top.width / 2 - overhang, top.depth / 2 - overhang
    lift = rng.choice([0.0, rng.uniform(0.08, 0.2)])
    chest = _chest(rng, case, lift, top.under, z)
    side = float(rng.choice([-1.0, 1.0]))
    parts = []
    match int(rng.choice(3, p=(0.45, 0.35, 0.2))):
        case 0:
            parts.append(both_sides(moved(chest, (x - case / 2, 0.0, 0.0))))
            if rng.random() < 0.4:
                drop = 0.11
                parts.append(box((2 * x - case, drop, 1.6 * z), (0.0, top.under - drop / 2, -0.2 * z)))
        case 1:
            parts.append(moved(chest, (side * (x - case / 2), 0.0, 0.0)))
            if rng.random() < 0.6:
                parts.append(box((0.04, top.under, 2 * z), (-side * (x - 0.02), top.under / 2, 0.0)))
            else:
                bar = rng.uniform(0.04, 0.06)
                post = box((bar, top.under, bar), (-side * (x - bar / 2), top.under / 2, z - bar / 2))
                parts.append(front_and_back(post))
        case _:
            bar, drop = rng.uniform(0.045, 0.08), rng.uniform(0.1, 0.16)
            styles: tuple[Leg, ...] = ("straight", "tapered", "turned", "cabriole", "round")
            spot = (x - bar / 2, z - bar / 2)
            parts.append(front_and_back(both_sides(leg(rng, styles[rng.integers(5)], spot, spot, top.under, bar))))
            parts.append(box((2 * x - bar, drop, 2 * z - bar), (0.0, top.under - drop / 2, 0.0)))
            low, high = top.under - drop, top.height - top.thickness
            parts.append(drawers((-x + bar, low), (x - bar, high), z - bar / 2, 1, int(rng.integers(1, 4)), 0.1))
    if rng.random() < 0.65:
        low = rng.choice([0.02, 0.3]) * top.height
        parts.append(box((2 * x - 0.02, top.under - low, 0.03), (0.0, (top.under + low) / 2, -z + 0.02)))
    return parts


def _chest(rng: Generator, width: float, low: float, high: float, z: float) -> Mesh:
    """Drawers one above the other between z and -z, on the floor or on short legs."""
    rows, top = int(rng.integers(1, 5)), high - 0.03
    parts = [
        box((width, high - low, 2 * z), (0.0, (low + high) / 2, 0.0)),
        drawers((-width / 2, low), (width / 2, top), z, rows, 1, rng.uniform(0.05, 0.4) * width),
    ]
    if low:
        parts.append(
            front_and_back(both_sides(box((0.04, low + 0.02, 0.04), (width / 2 - 0.03, low / 2 + 0.01, z - 0.03))))
        )
    return joined(*parts)


def _hutch(rng: Generator, top: Top) -> Mesh:
    """Open shelves along the rear edge of the top."""
    rise, depth, wall = rng.uniform(0.25, 0.6), rng.uniform(0.18, 0.3), 0.03
    width, z = top.width * rng.uniform(0.85, 1.0), (depth - top.depth) / 2 + 0.005
    low = top.under
    high = top.height + rise
    parts = [
        both_sides(box((wall, high - low, depth), ((width - wall) / 2, (low + high) / 2, z))),
        box((width, wall, depth), (0.0, high - wall / 2, z)),
        box((width - wall, high - low - wall, wall), (0.0, (low + high) / 2, z - (depth - wall) / 2)),
    ]
    for share in np.linspace(-0.5, 0.5, int(rng.integers(2, 5)))[1:-1]:
        parts.append(box((wall, high - low - wall, 0.95 * depth), (share * width, (low + high) / 2, z)))
    return joined(*parts)


def make_l_desk(rng: Generator) -> Mesh:
    """A desk with a second top that runs forward along one side."""
    width, depth, high = rng.uniform(1.4, 2.0), rng.uniform(0.5, 0.75), rng.uniform(0.71, 0.78)
    wing, reach, thick = rng.uniform(0.4, 0.65), rng.uniform(1.2, 1.9), rng.uniform(0.03, 0.06)
    side, under = float(rng.choice([-1.0, 1.0])), high - thick / 2
    wing_x, front = side * (width - wing) / 2, reach - depth / 2
    parts = [
        box((width, thick, depth), (0.0, high - thick / 2, 0.0)),
        box((wing, thick, reach), (wing_x, high - thick / 2, front - reach / 2)),
        box((width - 0.06, 0.7 * under, 0.03), (0.0, 0.65 * under, -depth / 2 + 0.05)),
        box((0.04, under, depth - 0.04), (-side * (width / 2 - 0.04), under / 2, 0.0)),
        box((0.03, 0.7 * under, reach - 0.06), (side * (width / 2 - 0.05), 0.65 * under, front - reach / 2)),
    ]
    case = min(0.45, 0.3 * reach)
    if rng.random() < 0.6:
        parts.append(moved(_chest(rng, wing - 0.06, 0.0, under, case / 2), (wing_x, 0.0, front - case / 2 - 0.02)))
    else:
        parts.append(box((wing - 0.04, under, 0.04), (wing_x, under / 2, front - 0.04)))
    if rng.random() < 0.4:
        low = moved(_chest(rng, 0.4, 0.0, under, 0.45 * depth), (-side * (width / 2 - 0.25), 0.0, 0.0))
        parts.append(low)
    parts.append(box((0.05, under, 0.05), (side * (width / 2 - 0.05), under / 2, -depth / 2 + 0.05)))
    return joined(*parts)


def make_secretary(rng: Generator) -> Mesh:
    """A writing desk with a closed case on it: a slanted lid, or a roll of slats."""
    width, depth, high = rng.uniform(0.9, 1.5), rng.uniform(0.55, 0.8), rng.uniform(0.72, 0.8)
    top = Top(width, depth, high, rng.uniform(0.03, 0.05))
    rise, flat = rng.uniform(0.25, 0.45), rng.uniform(0.2, 0.45) * depth
    back, front = -depth / 2 + 0.01, depth / 2 - rng.uniform(0.02, 0.2) * depth
    if rng.random() < 0.5:
        turn = np.linspace(0.0, np.pi / 2, 7)
        lid = np.stack((high + rise * np.sin(turn), back + flat + (front - back - flat) * np.cos(turn)), -1)
    else:
        lid = np.array([(high + 0.06, front), (high + rise, back + flat)])
    case = np.concatenate(([(high - 0.01, back), (high - 0.01, front)], lid, [(high + rise, back)]))
    cheek = width * rng.uniform(0.42, 0.49)
    shell = prism(case, -cheek, cheek)
    return joined(_board(top), *_under(rng, top), shell)


def make_cabinet(rng: Generator) -> Mesh:
    """A low table with drawers, or with compartments open to the front, under its whole top."""
    width, depth, high = rng.uniform(0.5, 1.5), rng.uniform(0.4, 0.65), rng.uniform(0.38, 0.62)
    wall, lift, overhang = rng.uniform(0.03, 0.05), rng.choice([0.0, 0.06, 0.16]), rng.uniform(0.0, 0.05)
    lid = box((width, wall + 0.01, depth), (0.0, high - wall / 2, 0.0))
    x, z = width / 2 - overhang, depth / 2 - overhang
    parts = [lid, box((2 * x, wall, 2 * z), (0.0, lift + wall / 2, 0.0))]
    if rng.random() < 0.5:
        columns = max(1, round(width / 0.5))
        parts.append(box((2 * x - 0.01, high - lift - 0.02, 2 * z - 0.02), (0.0, (high + lift) / 2, 0.0)))
        parts.append(drawers((-x, lift), (x, high - wall), z - 0.01, int(rng.integers(1, 3)), columns, 0.1))
    else:
        tall = high - lift - 0.01
        parts.append(both_sides(box((wall, tall, 2 * z), (x - wall / 2, lift + tall / 2, 0.0))))
        if rng.random() < 0.7:
            parts.append(box((2 * x - wall, tall, wall), (0.0, lift + tall / 2, -z + wall / 2)))
        if width > 0.8:
            parts.append(box((wall, tall, 1.9 * z), (rng.choice([0.0, 0.3]) * x, lift + tall / 2, 0.0)))
        parts.append(box((2 * x - wall, 0.8 * wall, 1.9 * z), (0.0, lift + rng.uniform(0.4, 0.6) * tall, 0.0)))
    if lift:
        bar = rng.uniform(0.035, 0.06)
        parts.append(front_and_back(both_sides(box((bar, lift + 0.02, bar), (x - bar, lift / 2 + 0.01, z - bar)))))
    return joined(*parts)
