"""What carries a bench's seat; every support stands on y = 0 and ends inside the seat."""

from typing import Literal

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.bench_parts import Bench
from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, loft, moved, tube
from trainer.data.shapes.table_parts import front_and_back

Support = Literal["legs", "panels", "trestles", "frames", "blocks", "castings", "turned"]


def support(rng: Generator, bench: Bench, style: Support) -> Mesh:
    """Two ends, or four legs, and what holds them together."""
    bar, y = rng.uniform(0.05, 0.1) * min(1.0, 0.5 + 0.4 * bench.width), bench.under
    x, z = (bench.width - bar) / 2 - rng.choice([0.0, 1.0]) * rng.uniform(0.03, 0.16) * bench.width, bench.depth / 2
    match style:
        case "legs":
            mesh = _legs(rng, bench, bar, x, z - bar / 2)
        case "turned":
            levels = np.array([0.0, 0.08, 0.16, 0.22, 0.5, 0.62, 0.68, 0.74, 0.8, 1.0]) * y
            radii = bar * np.array([0.3, 0.48, 0.4, 0.26, 0.42, 0.52, 0.3, 0.55, 0.5, 0.55])
            spindle = lathe([(float(r), float(level)) for r, level in zip(radii, levels, strict=True)], 10)
            mesh = front_and_back(both_sides(moved(spindle, (x - 0.1 * bar, 0.0, z - 0.6 * bar))))
        case "panels":
            side = box((bar * rng.uniform(0.6, 1.4), y, 2 * z * rng.uniform(0.8, 1.0)), (x, y / 2, 0.0))
            beam = box((2 * x, rng.uniform(0.06, 0.14), 0.04), (0.0, y * rng.uniform(0.4, 0.8), 0.0))
            mesh = joined(both_sides(side), *([beam] if rng.random() < 0.6 else []))
        case "trestles":
            mesh = _trestles(rng, bench, bar, x, 0.9 * z)
        case "frames":
            foot, thick = (z - bar / 2) * rng.choice([1.0, 1.0, 0.7]), 0.8 * bar
            post = tube([(x, 0.3 * bar, foot), (x, y - 0.3 * bar, z - bar / 2)], thick / 2, square=True)
            low = box((thick, thick, 2 * foot + thick), (x, thick / 2, 0.0))
            high = box((thick, thick, 2 * z - bar + thick), (x, y - thick / 2, 0.0))
            mesh = both_sides(joined(low, high, front_and_back(post)))
        case "blocks":
            breadth, taper = rng.uniform(0.12, 0.35) * min(bench.width, 1.2), rng.uniform(0.75, 1.15)
            at = (bench.width - breadth) / 2 - rng.uniform(0.02, 0.2) * bench.width
            mesh = both_sides(box((breadth, y, 2 * z * rng.uniform(0.6, 0.9)), (at, y / 2, 0.0), (taper, 1.0)))
        case "castings":
            mesh = both_sides(moved(_casting(rng, bench, bar), (x, 0.0, 0.0)))
    return mesh


def _legs(rng: Generator, bench: Bench, bar: float, x: float, z: float) -> Mesh:
    """Plumb or splayed legs, with or without an apron, a shelf or stretchers."""
    y, splay = bench.under, rng.choice([0.0, 1.0]) * rng.uniform(0.02, 0.08)
    radii = (bar * rng.uniform(0.3, 0.5), bar / 2)
    post = tube([(x + splay, 0.0, z + splay), (x, y, z)], radii, 8, square=rng.random() < 0.6)
    parts = [front_and_back(both_sides(post))]
    if rng.random() < 0.5:
        drop = rng.uniform(0.05, 0.1)
        level = bench.height - bench.thickness - drop / 2 + 0.005
        parts.append(front_and_back(box((2 * x, drop, 0.6 * bar), (0.0, level, z))))
        parts.append(both_sides(box((0.6 * bar, drop, 2 * z), (x, level, 0.0))))
    level = rng.uniform(0.2, 0.4)
    at, to = x + splay * (1 - level), z + splay * (1 - level)
    match int(rng.integers(4)):
        case 0:
            parts.append(box((2 * at, 0.035, 2 * to), (0.0, level * y, 0.0)))
        case 1:
            parts.append(both_sides(box((0.6 * bar, 0.6 * bar, 2 * to), (at, level * y, 0.0))))
            parts.append(box((2 * at, 0.6 * bar, 0.6 * bar), (0.0, level * y, 0.0)))
        case _:
            pass
    return joined(*parts)


def _trestles(rng: Generator, bench: Bench, bar: float, x: float, z: float) -> Mesh:
    """Crossed bars, or pairs that spread towards the floor, with a beam along the bench."""
    y = bench.under
    if rng.random() < 0.5:
        head, level = -z, y / 2
        across = box((bar, 0.8 * bar, 1.9 * z), (x, y - 0.4 * bar, 0.0))
    else:
        head, level = z * rng.uniform(0.3, 0.7), y * rng.uniform(0.35, 0.6)
        across = box((0.8 * bar, 0.8 * bar, 2 * (z + (head - z) * level / y)), (x, level, 0.0))
    pair = front_and_back(tube([(x, 0.0, z), (x, y, head)], 0.45 * bar, square=True))
    return joined(both_sides(joined(pair, across)), box((2 * x, bar, 0.5 * bar), (0.0, level, 0.0)))


def _casting(rng: Generator, bench: Bench, bar: float) -> Mesh:
    """A cast end in the plane x = 0: two legs that sweep outwards, and a deep head between them."""
    y, reach, sweep = bench.under, 0.38 * bench.depth, np.linspace(0.0, 1.0, 6)
    outer = reach + bench.depth * rng.uniform(0.08, 0.2) * (1 - sweep) ** 2
    x = bar / 2 * np.array([-1, 1, 1, -1])
    rings = []
    for side, level in zip(outer, sweep * y, strict=True):
        inner = side - bar * (1.0 + 0.6 * level / y)
        rings.append(np.stack((x, np.full(4, level), np.array([inner, inner, side, side])), -1))
    head = y * rng.uniform(0.2, 0.5)
    return joined(front_and_back(loft(np.stack(rings))), box((0.9 * bar, head, 1.8 * reach), (0.0, y - head / 2, 0.0)))
