"""Benches that one meets less often: swings, rings around trees, rows of shells, logs, waves, and seats on planters."""

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.bench_parts import BACKS, SEATS, Bench, arc, arms, back, seat
from trainer.data.shapes.solid import (
    Mesh,
    both_sides,
    box,
    cylinder,
    joined,
    lathe,
    loft,
    moved,
    prism,
    ring,
    tube,
    turned,
)
from trainer.data.shapes.table_parts import front_and_back


def make_swing(rng: Generator) -> Mesh:
    """A bench that hangs from a beam between two splayed pairs of posts."""
    bench = Bench(rng.uniform(1.1, 1.7), rng.uniform(0.42, 0.52), rng.uniform(0.42, 0.52), rng.uniform(0.04, 0.07))
    high, bar, spread = rng.uniform(1.6, 2.0), rng.uniform(0.06, 0.1), rng.uniform(0.5, 0.75)
    x, hook = bench.width / 2 + rng.uniform(0.14, 0.3), bench.width / 2 - 0.04
    pair = front_and_back(tube([(x, 0.0, spread), (x, high, 0.02)], bar / 2, square=True))
    level = rng.uniform(0.2, 0.5)
    across = box((0.8 * bar, 0.8 * bar, 2 * spread * (1 - level)), (x, level * high, 0.0))
    rope = cylinder((hook, bench.under, 0.42 * bench.depth), (hook, high, 0.0), 0.018, 6)
    parts = [
        both_sides(joined(pair, across, front_and_back(rope))),
        box((2 * x + 2 * bar, bar, bar), (0.0, high, 0.0)),
        seat(rng, bench, SEATS[rng.integers(len(SEATS))]),
        back(rng, bench, BACKS[rng.integers(len(BACKS))], rng.uniform(0.4, 0.55), rng.uniform(0.05, 0.2)),
        arms(rng, bench, 0.05),
    ]
    if rng.random() < 0.4:
        plate = box((2 * x + 0.3, 0.06, rng.uniform(0.9, 1.3)))
        parts.append(moved(turned(plate, 0, rng.uniform(0.0, 0.2)), (0.0, high + bar / 2 + 0.02, 0.0)))
    return joined(*parts)


def make_tree_ring(rng: Generator) -> Mesh:
    """A ring to sit on around a tree, round or of six or eight straight sides, with or without a back."""
    sides, radius = int(rng.choice([6, 8, 24])), rng.uniform(0.5, 1.0)
    depth, high, thick = rng.uniform(0.34, 0.48), rng.uniform(0.42, 0.48), rng.uniform(0.06, 0.1)
    parts = [_ring(-depth / 2, depth / 2, high - thick, high, 0.0, radius, sides)]
    if rng.random() < 0.6:
        top, lean = high + rng.uniform(0.3, 0.5), rng.uniform(0.0, 0.12)
        parts.append(_ring(-depth / 2, -depth / 2 + 0.07, high - thick, top, lean, radius, sides))
    under = high - thick / 2
    posts = [box((0.08, under, 0.08), (0.0, under / 2, -radius + reach * depth)) for reach in (-0.36, 0.36)]
    trestle = joined(*posts, box((0.06, 0.08, 0.8 * depth), (0.0, high - thick - 0.02, -radius)))
    count = sides if sides < 20 else 8
    return joined(*parts, *(turned(trestle, 1, angle) for angle in np.arange(count) * 2 * np.pi / count))


def _ring(inner: float, outer: float, low: float, high: float, lean: float, radius: float, sides: int) -> Mesh:
    """A wall of `sides` corners around the y axis, its upper edge drawn inwards by `lean`."""
    section = np.array([(inner, low), (outer, low), (outer - lean, high), (inner - lean, high)])
    # Two halves, because a swept section needs two ends.
    half = arc(section, radius, np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1))
    return joined(half, turned(half, 1, np.pi))


def make_row(rng: Generator) -> Mesh:
    """Shells or pads in a row on a beam, as in a waiting room."""
    count, pitch, high = int(rng.integers(2, 6)), rng.uniform(0.5, 0.62), rng.uniform(0.42, 0.47)
    width, depth, thick = pitch - rng.uniform(0.04, 0.1), rng.uniform(0.42, 0.5), rng.uniform(0.05, 0.1)
    rise, recline = rng.uniform(0.35, 0.5), rng.uniform(0.1, 0.3)
    rest = box((width, rise, thick), (0.0, rise / 2, 0.0), (rng.uniform(0.8, 1.0), 1.0))
    shell = joined(
        box((width, thick, depth), (0.0, high - thick / 2, 0.0)),
        moved(turned(rest, 0, -recline), (0.0, high - 0.05, 0.02 - depth / 2)),
        box((0.12, 0.08, 0.2), (0.0, high - thick - 0.02, 0.0)),
    )
    reach = (count - 1) / 2 * pitch
    parts = [moved(shell, (index * pitch - reach, 0.0, 0.0)) for index in range(count)]
    beam, end = high - thick - 0.07, max(reach * rng.uniform(0.7, 1.0), 0.18)
    parts.append(box((2 * reach + 0.3, 0.08, 0.1), (0.0, beam, 0.0)))
    foot = joined(box((0.08, beam, 0.08), (end, beam / 2, 0.0)), box((0.08, 0.05, 0.55), (end, 0.025, 0.0)))
    parts.append(both_sides(foot))
    if rng.random() < 0.5:
        edges = (np.arange(count + 1) - count / 2) * pitch
        parts += [box((0.045, 0.05, 0.36), (x, high + 0.2, 0.02)) for x in edges]
        parts += [box((0.04, 0.32 + thick, 0.05), (x, high + 0.07 - thick / 2, -0.1)) for x in edges]
        parts.append(box((count * pitch, 0.05, 0.06), (0.0, beam, -0.1)))
    return joined(*parts)


def make_log(rng: Generator) -> Mesh:
    """A split log, its flat side up, on two logs that lie or stand under it, at times with a slab as a back."""
    width, radius, high = rng.uniform(1.0, 2.2), rng.uniform(0.17, 0.27), rng.uniform(0.38, 0.5)
    angle = np.linspace(np.pi, 2 * np.pi, 9)
    flat = np.stack((high + radius * rng.uniform(0.6, 1.0) * np.sin(angle), radius * np.cos(angle)), -1)
    x, under = width * rng.uniform(0.28, 0.4), high - 0.6 * radius
    if rng.random() < 0.5:
        foot = lathe([(0.75 * radius, 0.0), (0.7 * radius, high - 0.1)], 10)
    else:
        foot = turned(lathe([(under / 2, -1.1 * radius), (under / 2, 1.1 * radius)], 12), 0, np.pi / 2)
        foot = moved(foot, (0.0, under / 2 * np.cos(np.pi / 12), 0.0))
    parts = [prism(flat, -width / 2, width / 2), both_sides(moved(foot, (x, 0.0, 0.0)))]
    if rng.random() < 0.45:
        rise = rng.uniform(0.3, 0.45)
        slab = box((0.95 * width, rise * 0.7, 0.07), (0.0, rise * 0.65, 0.03))
        posts = both_sides(box((0.1, rise + 0.1, 0.08), (0.8 * x, rise / 2 - 0.05, 0.0)))
        parts.append(moved(turned(joined(slab, posts), 0, -0.15), (0.0, high, 0.05 - radius)))
    return joined(*parts)


def make_wave(rng: Generator) -> Mesh:
    """One ribbon bent into foot, seat and back, or a long seat that winds or undulates."""
    return _ribbon(rng) if rng.random() < 0.5 else _winding(rng)


def _ribbon(rng: Generator) -> Mesh:
    width, thick, high = rng.uniform(0.9, 1.9), rng.uniform(0.05, 0.1), rng.uniform(0.38, 0.46)
    rear, top = -rng.uniform(0.32, 0.5), high + rng.uniform(0.3, 0.48)
    foot, nose = rng.uniform(-0.3, 0.0), rng.uniform(0.3, 0.42)
    # (z, y) corners of the run, from its end on the floor to the upper edge of the back.
    corners = np.array([(foot, 0.0), (nose, 0.0), (nose, high), (-0.25, high - 0.04), (rear, top)])
    if rng.random() < 0.4:
        corners = np.array([(nose - 0.05, 0.0), (foot, 0.0), (foot, 0.2), (nose, high), (-0.2, high), (rear, top)])
    path = _smoothed(_smoothed(corners))
    path[:, 1] += thick / 2
    along = np.gradient(path, axis=0)
    across = np.stack((-along[:, 1], along[:, 0]), -1) * thick / 2 / np.linalg.norm(along, axis=1, keepdims=True)
    edges = [(-width / 2, path + across), (width / 2, path + across), (width / 2, path - across)]
    edges.append((-width / 2, path - across))
    return loft(np.stack([np.stack((np.full(len(edge), x), edge[:, 1], edge[:, 0]), -1) for x, edge in edges], 1))


def _winding(rng: Generator) -> Mesh:
    width, depth, high = rng.uniform(1.6, 3.0), rng.uniform(0.42, 0.6), rng.uniform(0.4, 0.48)
    share, turns = np.linspace(-1, 1, 25), rng.uniform(0.6, 1.3)
    swing, heave = rng.uniform(0.1, 0.35), rng.choice([0.0, 1.0]) * rng.uniform(0.03, 0.09)
    x, z = share * width / 2, swing * np.sin(turns * np.pi * share)
    top = high + heave * np.cos(1.5 * turns * np.pi * share)
    low = rng.choice([0.0, 1.0]) * (top - 0.09)
    corners = ((low, -1), (low, 1), (top, 1), (top, -1))
    parts = [loft(np.stack([np.stack((x, y, z + side * depth / 2), -1) for y, side in corners], 1))]
    if low.max() > 0:
        for index in (4, 12, 20):
            under = top[index] - 0.05
            parts.append(box((0.14, under, 0.75 * depth), (x[index], under / 2, z[index])))
    return joined(*parts)


def _smoothed(path: Float64[ndarray, "S 2"]) -> Float64[ndarray, "S2 2"]:
    """Corners cut off at a quarter of their sides (Chaikin), both ends kept."""
    inner = np.stack((0.75 * path[:-1] + 0.25 * path[1:], 0.25 * path[:-1] + 0.75 * path[1:]), 1).reshape(-1, 2)
    return np.concatenate((path[:1], inner[1:-1], path[-1:]))


def make_planters(rng: Generator) -> Mesh:
    """A seat between two boxes for plants, some of them planted."""
    side, tall, gap = rng.uniform(0.4, 0.65), rng.uniform(0.45, 0.8), rng.uniform(0.9, 1.7)
    flare, wall, soil = rng.uniform(0.8, 1.25), 0.06, tall - rng.uniform(0.06, 0.2)
    levels = ((0.0, side), (tall, side * flare), (tall, side * flare - 2 * wall), (soil, 0.8 * side * min(1.0, flare)))
    roundness = float(rng.choice([2.0, 12.0]))
    planter = loft(np.stack([ring(width / 2, width / 2, y, 20, roundness) for y, width in levels]))
    if rng.random() < 0.5:
        bush = rng.uniform(0.55, 0.75) * side * min(1.0, flare)
        angle = np.linspace(-1.3, 1.4, 7)
        ball = [(float(bush * np.cos(a)), float(soil + bush * (0.8 + np.sin(a)))) for a in angle]
        planter = joined(planter, lathe(ball, 12))
    high, thick, depth = min(0.45, tall - 0.05), rng.uniform(0.05, 0.1), min(0.8 * side, 0.45)
    bench = Bench(gap + 0.6 * side, depth, high, thick)
    parts = [
        both_sides(moved(planter, ((gap + side) / 2, 0.0, 0.0))),
        box((gap + 0.3 * side, thick, depth), (0.0, high - thick / 2, 0.0)),
    ]
    if rng.random() < 0.5:
        parts.append(moved(back(rng, bench._replace(width=0.95 * gap), "slats", 0.35, 0.1), (0.0, 0.0, 0.02)))
    return joined(*parts)
