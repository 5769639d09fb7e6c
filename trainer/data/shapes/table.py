"""Tables: dining, coffee, side and console tables on all kinds of support, desks, nests, and one in seven unusual."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, moved, tube
from trainer.data.shapes.table_desk import make_cabinet, make_desk, make_l_desk, make_secretary
from trainer.data.shapes.table_parts import CORNERS, Outline, Top, board, front_and_back, outline, table_top
from trainer.data.shapes.table_supports import frames, legs, panels, pedestal, trestles
from trainer.data.shapes.table_unusual import (
    make_cantilever,
    make_drafting,
    make_drop_leaf,
    make_games,
    make_half_round,
    make_sculptural,
    make_workbench,
)


def make_table(rng: Generator) -> Mesh:
    """One table, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.27, _legged),
        (0.08, _panelled),
        (0.06, _trestle),
        (0.07, _framed),
        (0.14, _pedestal),
        (0.12, make_desk),
        (0.04, make_cabinet),
        (0.04, _block),
        (0.04, _nest),
        (0.03, _tiered),
        (0.03, make_l_desk),
        (0.02, make_secretary),
        (0.02, make_half_round),
        (0.02, make_drop_leaf),
        (0.02, make_games),
        (0.02, make_drafting),
        (0.02, make_sculptural),
        (0.02, make_workbench),
        (0.02, make_cantilever),
    )
    shares = np.array([share for share, _ in builders])
    mesh = builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)
    # Slanted legs end square to themselves, so that an edge of theirs dips below the floor.
    return moved(mesh, (0.0, -float(mesh.vertices[:, 1].min()), 0.0))


class _Use(NamedTuple):
    """What a table is for decides its measures: ranges in metres."""

    share: float
    width: tuple[float, float]
    aspect: tuple[float, float]
    """Depth over width."""
    height: tuple[float, float]


_USES = (
    _Use(0.27, (1.2, 2.4), (0.42, 0.65), (0.70, 0.78)),  # dining
    _Use(0.15, (0.65, 1.2), (0.95, 1.0), (0.70, 0.78)),  # for four
    _Use(0.26, (0.8, 1.4), (0.45, 1.0), (0.28, 0.48)),  # coffee
    _Use(0.14, (0.38, 0.6), (0.8, 1.0), (0.45, 0.68)),  # beside a bed
    _Use(0.09, (0.8, 1.6), (0.25, 0.36), (0.72, 0.92)),  # along a wall
    _Use(0.04, (2.5, 4.5), (0.3, 0.4), (0.71, 0.77)),  # conference
    _Use(0.05, (0.55, 1.5), (0.45, 1.0), (0.95, 1.12)),  # to stand at
)


def _top(rng: Generator, style: Outline) -> Top:
    use = _USES[rng.choice(len(_USES), p=[use.share for use in _USES])]
    width, height = rng.uniform(*use.width), rng.uniform(*use.height)
    depth = width * rng.uniform(*use.aspect)
    # Tops grow thicker with the table, though less than it does.
    span = float(np.linalg.norm((width, depth, height)))
    thickness = max(rng.uniform(0.03, 0.065) * np.sqrt(span), span / 40)
    return Top(width, depth, height, thickness, CORNERS[style])


def _style(rng: Generator) -> Outline:
    styles: tuple[Outline, ...] = ("rectangle", "rounded", "oval", "polygon", "boat")
    return styles[rng.choice(5, p=(0.52, 0.2, 0.16, 0.05, 0.07))]


def _bar(rng: Generator, top: Top) -> float:
    """The thickness of a leg that looks right under the top."""
    return float(rng.uniform(0.05, 0.11) * min(1.0, max(0.6, top.depth)))


def _legged(rng: Generator) -> Mesh:
    style = _style(rng)
    top = _top(rng, style)
    return joined(table_top(rng, top, style), legs(rng, top, _bar(rng, top)))


def _panelled(rng: Generator) -> Mesh:
    top = _top(rng, "rectangle")
    return joined(table_top(rng, top, "rectangle"), panels(rng, top))


def _trestle(rng: Generator) -> Mesh:
    style: Outline = "boat" if rng.random() < 0.2 else "rectangle"
    width, depth = rng.uniform(1.3, 2.6), rng.uniform(0.75, 1.1)
    top = Top(width, depth, rng.uniform(0.71, 0.78), rng.uniform(0.045, 0.09), CORNERS[style])
    return joined(table_top(rng, top, style), trestles(rng, top, rng.uniform(0.06, 0.12)))


def _framed(rng: Generator) -> Mesh:
    style: Outline = "rounded" if rng.random() < 0.2 else "rectangle"
    top = _top(rng, style)
    return joined(table_top(rng, top, style), frames(rng, top, 0.9 * _bar(rng, top)))


def _pedestal(rng: Generator) -> Mesh:
    """A round, square or eight-sided top on one foot, or a long one on two."""
    if rng.random() < 0.2:
        style: Outline = ("rectangle", "rounded", "oval", "boat")[rng.integers(4)]
        top = Top(rng.uniform(1.6, 3.6), rng.uniform(0.9, 1.3), rng.uniform(0.71, 0.77), rng.uniform(0.05, 0.1))
        foot = pedestal(rng, top.under, 0.33 * top.depth, rng.uniform(0.05, 0.09))
        return joined(
            table_top(rng, top, style), both_sides(moved(foot, (rng.uniform(0.22, 0.28) * top.width, 0.0, 0.0)))
        )
    style = ("oval", "oval", "oval", "rounded", "rectangle", "polygon")[rng.integers(6)]
    width, high = rng.uniform(0.4, 1.5), rng.uniform(0.68, 0.78)
    if width < 0.8:
        high = rng.choice([high, rng.uniform(0.45, 0.6), rng.uniform(0.95, 1.1)])
    top = Top(width, width * rng.choice([1.0, rng.uniform(0.75, 1.0)]), high, rng.uniform(0.03, 0.065) * np.sqrt(width))
    foot = pedestal(rng, top.under, rng.uniform(0.28, 0.38) * top.depth, rng.uniform(0.035, 0.05) * (0.4 + 0.6 * width))
    return joined(table_top(rng, top, style), foot)


def _block(rng: Generator) -> Mesh:
    """Drums, plinths, hollow cubes and stacked slabs."""
    width, high = rng.uniform(0.4, 1.2), rng.uniform(0.32, 0.5)
    depth = width * rng.uniform(0.7, 1.0)
    match int(rng.integers(4)):
        case 0:
            belly = rng.uniform(0.75, 1.25)
            radii = width / 2 * (1 + (belly - 1) * np.sin(np.linspace(0, np.pi, 7)))
            drum = [(float(r), float(y)) for r, y in zip(radii, np.linspace(0.0, high, 7), strict=True)]
            rim = width / 2 * rng.uniform(0.98, 1.15)
            return joined(lathe(drum, 24), lathe([(rim, high - 0.03), (rim, high + 0.02)], 24))
        case 1:
            wall = rng.uniform(0.04, 0.09)
            lids = [box((width, wall, depth), (0.0, y, 0.0)) for y in (wall / 2, high - wall / 2)]
            side = box((wall, high - wall, depth), ((width - wall) / 2, high / 2, 0.0))
            back = box((width - wall, high - wall, wall), (0.0, high / 2, -(depth - wall) / 2))
            return joined(*lids, both_sides(side), *([back] if rng.random() < 0.5 else []))
        case 2:
            base = box((width * rng.uniform(0.5, 0.85), high, depth * rng.uniform(0.5, 0.85)), (0.0, high / 2, 0.0))
            return joined(base, box((width, 0.08, depth), (0.0, high, 0.0)))
        case _:
            thick, gap = high * 0.3, high * 0.4
            core = box((0.6 * width, high, 0.6 * depth), (0.0, high / 2, 0.0))
            slabs = [box((width, thick, depth), (0.0, y, 0.0)) for y in (thick / 2, thick * 1.5 + gap)]
            return joined(core, *slabs)


def _nest(rng: Generator) -> Mesh:
    """Two or three tables of one kind, each drawn out from under the next larger one."""
    width, depth, high = rng.uniform(0.5, 0.75), rng.uniform(0.36, 0.5), rng.uniform(0.48, 0.6)
    thick, bar, pull = rng.uniform(0.025, 0.05), rng.uniform(0.03, 0.05), rng.uniform(0.35, 0.7) * depth
    boarded = rng.random() < 0.4
    parts = []
    for index in range(int(rng.integers(2, 4))):
        top = Top(width - index * 2.4 * bar - index * 0.03, depth - 0.03 * index, high - index * (thick + 0.05), thick)
        x, z = top.spot(bar)
        post = box((bar, top.under, bar), (x, top.under / 2, z))
        side = box((bar, top.under, top.depth * 0.96), (x, top.under / 2, 0.0))
        table = joined(
            box((top.width, thick, top.depth), (0.0, top.height - thick / 2, 0.0)),
            both_sides(side if boarded else front_and_back(post)),
        )
        parts.append(moved(table, (0.0, 0.0, index * pull)))
    return joined(*parts)


def _tiered(rng: Generator) -> Mesh:
    """Two or three shelves on a column or on posts."""
    width, high, count = rng.uniform(0.45, 0.8), rng.uniform(0.6, 0.95), int(rng.integers(2, 4))
    depth = width * rng.uniform(0.7, 1.0)
    style: Outline = ("oval", "rectangle", "rounded")[rng.integers(3)]
    points, shrink = outline(rng, style, width, depth), rng.choice([0.0, 0.18])
    thick, lowest = rng.uniform(0.03, 0.05), rng.uniform(0.1, 0.2)
    levels = np.linspace(lowest, high, count)
    shelves = [
        board(points * (1 - shrink * index), [(y - thick, 0.0), (y, 0.0)]) for index, y in enumerate(levels.tolist())
    ]
    if style == "oval" and rng.random() < 0.5:
        column = lathe([(0.35 * depth, 0.0), (0.3 * depth, 0.04), (0.04, 0.07), (0.03, high - 0.01)])
        return joined(*shelves, column)
    top = Top(width, depth, high, thick, CORNERS[style] * (1 - shrink * (count - 1)))
    x, z = top.spot(0.05)
    post = tube([(x, 0.0, z), (x, high + rng.choice([-0.01, 0.06]), z)], 0.025, 8, square=rng.random() < 0.5)
    return joined(*shelves, front_and_back(both_sides(post)))
