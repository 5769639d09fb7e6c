"""Benches: with a back, without, storage, pews, picnic, curved, upholstered, and about one in nine unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.bench_parts import BACKS, SEATS, Bench, arc, arms, back, pad, rail, seat
from trainer.data.shapes.bench_supports import Support, support
from trainer.data.shapes.bench_unusual import make_log, make_planters, make_row, make_swing, make_tree_ring, make_wave
from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, loft, moved, tube, turned
from trainer.data.shapes.table_parts import front_and_back


def make_bench(rng: Generator) -> Mesh:
    """One bench, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.36, _backed),
        (0.15, _backless),
        (0.10, _storage),
        (0.06, _pew),
        (0.07, _picnic),
        (0.06, _curved),
        (0.05, _piano),
        (0.04, _window),
        (0.03, _block),
        (0.02, make_swing),
        (0.02, make_tree_ring),
        (0.02, make_row),
        (0.02, make_log),
        (0.02, make_wave),
        (0.02, make_planters),
    )
    shares = np.array([share for share, _ in builders])
    mesh = builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)
    # Slanted legs end square to themselves, so that an edge of theirs dips below the floor.
    return moved(mesh, (0.0, -float(mesh.vertices[:, 1].min()), 0.0))


def _measures(rng: Generator) -> Bench:
    width = rng.uniform(0.9, 2.1)
    return Bench(width, rng.uniform(0.33, 0.55), rng.uniform(0.39, 0.49), rng.uniform(0.04, 0.085))


def _backed(rng: Generator) -> Mesh:
    """In parks, gardens and halls."""
    bench, height, recline = _measures(rng), rng.uniform(0.28, 0.62), rng.uniform(0.0, 0.35)
    styles: tuple[Support, ...] = ("legs", "castings", "castings", "panels", "frames", "turned", "blocks")
    parts = [
        seat(rng, bench, SEATS[rng.integers(len(SEATS))]),
        back(rng, bench, BACKS[rng.integers(len(BACKS))], height, recline),
        support(rng, bench, styles[rng.integers(len(styles))]),
    ]
    if rng.random() < 0.55:
        parts.append(arms(rng, bench, rng.uniform(0.04, 0.08)))
    return joined(*parts)


def _backless(rng: Generator) -> Mesh:
    bench = _measures(rng)
    styles: tuple[Support, ...] = ("legs", "legs", "panels", "trestles", "frames", "blocks", "turned", "castings")
    return joined(
        seat(rng, bench, SEATS[rng.integers(len(SEATS))]), support(rng, bench, styles[rng.integers(len(styles))])
    )


def _storage(rng: Generator) -> Mesh:
    """A chest to sit on, or open compartments under a seat, some with a back and arms."""
    bench = Bench(rng.uniform(0.8, 1.6), rng.uniform(0.36, 0.55), rng.uniform(0.42, 0.52), rng.uniform(0.03, 0.06))
    lift, overhang = rng.choice([0.0, 0.06, 0.12]), rng.uniform(0.0, 0.03)
    x, z, wall = bench.width / 2 - overhang, bench.depth / 2 - overhang, rng.uniform(0.03, 0.05)
    tall, count = bench.under - lift, int(rng.integers(2, 4))
    edges = np.linspace(-x + wall / 2, x - wall / 2, count + 1)
    parts = [seat(rng, bench, "pads" if rng.random() < 0.4 else "plank")]
    if rng.random() < 0.6:
        parts.append(box((2 * x, tall, 2 * z), (0.0, lift + tall / 2, 0.0)))
        bay, trim = (2 * x - wall) / count, rng.uniform(0.06, 0.1)
        front = box((bay - trim, tall - 1.2 * trim, 0.04), (0.0, lift + tall / 2, z))
        parts += [moved(front, (middle, 0.0, 0.0)) for middle in (edges[1:] + edges[:-1]) / 2]
    else:
        parts.append(box((2 * x, wall, 2 * z), (0.0, lift + wall / 2, 0.0)))
        parts.append(box((2 * x, tall, wall), (0.0, lift + tall / 2, -z + wall / 2)))
        parts += [box((wall, tall, 2 * z), (edge, lift + tall / 2, 0.0)) for edge in edges]
    if lift:
        parts.append(front_and_back(both_sides(box((0.07, lift + 0.02, 0.07), (x - 0.04, lift / 2 + 0.01, z - 0.04)))))
    match int(rng.integers(4)):
        case 0:
            parts.append(back(rng, bench, BACKS[rng.integers(len(BACKS))], rng.uniform(0.3, 0.6), 0.0))
            parts.append(arms(rng, bench, 0.05))
        case 1:
            # A board with hooks and a shelf above, as in a hallway.
            high, thick = rng.uniform(1.3, 1.9), 0.05
            at = -bench.depth / 2 + thick / 2
            parts.append(box((0.98 * bench.width, high - lift, thick), (0.0, (high + lift) / 2, at)))
            parts.append(box((bench.width, 0.05, 0.28), (0.0, high - 0.02, at + 0.11)))
            hook = tube([(0.0, 0.0, 0.0), (0.0, -0.05, 0.09), (0.0, 0.03, 0.11)], 0.018, 6)
            parts += [moved(hook, (a * bench.width, 0.8 * high, at)) for a in (-0.36, -0.12, 0.12, 0.36)]
        case _:
            pass
    return joined(*parts)


def _pew(rng: Generator) -> Mesh:
    """A seat and a back between two solid ends."""
    width, depth, high = rng.uniform(1.1, 2.3), rng.uniform(0.42, 0.6), rng.uniform(0.42, 0.48)
    top, wall, lean = rng.uniform(0.75, 1.05), rng.uniform(0.04, 0.08), rng.uniform(0.0, 0.14)
    arm, step = rng.uniform(0.58, 0.7), rng.uniform(0.3, 0.6) * depth
    low = box((wall, arm, depth), ((width - wall) / 2, arm / 2, 0.0))
    tall = box((wall, top - arm + 0.02, step), ((width - wall) / 2, (top + arm) / 2 - 0.01, (step - depth) / 2))
    rest = moved(rail(width - wall, high - 0.05, top - 0.03, 0.04, 0.0), (0.0, 0.0, -depth / 2 + 0.08))
    parts = [
        both_sides(joined(low, tall)),
        turned(rest, 0, -lean, (0.0, top, -depth / 2 + 0.06)),
        box((width - wall, rng.uniform(0.04, 0.07), 0.9 * depth), (0.0, high - 0.03, 0.0)),
    ]
    if rng.random() < 0.4:
        parts.append(box((width - wall, high - 0.05, 0.04), (0.0, (high - 0.05) / 2, rng.uniform(-0.2, 0.4) * depth)))
    return joined(*parts)


def _picnic(rng: Generator) -> Mesh:
    """A table with a bench on each side, all on one frame."""
    width, high, low = rng.uniform(1.1, 1.9), rng.uniform(0.7, 0.78), rng.uniform(0.42, 0.48)
    plate, reach, plank = rng.uniform(0.6, 0.8), rng.uniform(0.66, 0.82), rng.uniform(0.22, 0.32)
    thick, bar, x = rng.uniform(0.06, 0.09), rng.uniform(0.06, 0.1), width * rng.uniform(0.3, 0.4)
    parts = [front_and_back(box((width, thick, plank), (0.0, low - thick / 2, reach)))]
    if rng.random() < 0.5:
        parts.append(box((width, thick, plate), (0.0, high - thick / 2, 0.0)))
    else:
        count = int(rng.integers(3, 6))
        slat = plate / count
        shift = (np.arange(count) - (count - 1) / 2) * slat
        parts += [box((width, thick, 0.88 * slat), (0.0, high - thick / 2, z)) for z in shift]
        parts.append(both_sides(box((bar, bar, 0.96 * plate), (x, high - thick - bar / 3, 0.0))))
    if rng.random() < 0.7:
        leg = tube([(x, 0.0, reach - 0.05), (x, high - thick / 2, 0.35 * plate)], bar / 2, square=True)
    else:
        leg = box((bar, high - thick / 2, 1.6 * bar), (x, (high - thick / 2) / 2, 0.25 * plate))
        foot = box((0.8 * bar, low, bar), (x, (low - thick / 2) / 2, reach))
        leg = joined(leg, foot)
    bearer = box((0.8 * bar, 1.4 * bar, 2 * reach + 0.8 * plank), (x, low - thick - 0.5 * bar, 0.0))
    beam = box((2 * x, 1.2 * bar, 0.7 * bar), (0.0, low - thick - 0.5 * bar, 0.0))
    return joined(*parts, both_sides(joined(front_and_back(leg), bearer)), beam)


def _curved(rng: Generator) -> Mesh:
    """An arc of stone or wood on blocks, with or without a back."""
    radius, half_angle = rng.uniform(0.7, 1.8), rng.uniform(0.5, 1.4)
    depth, high, thick = rng.uniform(0.32, 0.5), rng.uniform(0.4, 0.5), rng.uniform(0.05, 0.12)
    angles = np.linspace(-half_angle, half_angle, 13)
    out = depth / 2 * np.array([-1, 1, 1, -1])
    parts = [arc(np.stack((out, np.array([high - thick, high - thick, high, high])), -1), radius, angles)]
    if rng.random() < 0.35:
        wall, top = rng.uniform(0.05, 0.12), high + rng.uniform(0.3, 0.5)
        side = depth / 2 + wall * np.array([-1.0, 0.0, 0.6, -0.4])
        foot = rng.choice([0.0, high - thick])
        parts.append(arc(np.stack((side, np.array([foot, foot, top, top])), -1), radius, angles))
    if rng.random() < 0.3:
        plinth = np.stack((0.8 * out, np.array([0.0, 0.0, high - thick / 2, high - thick / 2])), -1)
        return joined(*parts, arc(plinth, radius, 0.94 * angles))
    width, taper = rng.uniform(0.14, 0.3), rng.uniform(0.8, 1.15)
    block = box((width, high - thick / 2, 0.8 * depth), (0.0, (high - thick / 2) / 2, -radius), (taper, 1.0))
    count = max(2, round(half_angle * radius / 0.6))
    spread = half_angle - 0.75 * width / radius
    return joined(*parts, *(turned(block, 1, angle) for angle in np.linspace(-spread, spread, count)))


def _piano(rng: Generator) -> Mesh:
    """Short and padded, on straight, turned or crossed legs."""
    bench = Bench(rng.uniform(0.5, 0.95), rng.uniform(0.32, 0.42), rng.uniform(0.44, 0.54), rng.uniform(0.04, 0.07))
    soft, drop = rng.uniform(0.05, 0.1), rng.uniform(0.07, 0.14)
    parts = [
        moved(pad(bench.width, soft, bench.depth, 0.35 * soft), (0.0, bench.height + 0.3 * soft, 0.0)),
        box((0.95 * bench.width, drop, 0.93 * bench.depth), (0.0, bench.height - drop / 2, 0.0)),
    ]
    styles: tuple[Support, ...] = ("legs", "legs", "turned", "trestles")
    return joined(*parts, support(rng, bench._replace(width=0.94 * bench.width), styles[rng.integers(len(styles))]))


def _window(rng: Generator) -> Mesh:
    """Upholstered, with an arm at each end and no back."""
    bench = Bench(rng.uniform(0.9, 1.6), rng.uniform(0.42, 0.55), rng.uniform(0.42, 0.5), rng.uniform(0.1, 0.16))
    rise, lean, wall = rng.uniform(0.15, 0.35), rng.uniform(0.0, 0.3), rng.uniform(0.05, 0.1)
    inner, z = bench.width / 2 - wall, 0.49 * bench.depth
    low, high = bench.height - 0.8 * bench.thickness, bench.height + rise
    rings = [
        [(x, y, -z), (x + wall, y, -z), (x + wall, y, z), (x, y, z)]
        for x, y in ((inner, low), (inner + lean * rise, high))
    ]
    roll, at = rng.uniform(0.5, 0.9) * wall, inner + wall / 2 + lean * rise
    top = cylinder((at, high, -1.02 * z), (at, high, 1.02 * z), roll, 12)
    cushion = pad(bench.width - wall, bench.thickness, bench.depth, 0.03)
    styles: tuple[Support, ...] = ("legs", "turned", "trestles")
    return joined(
        moved(cushion, (0.0, bench.height - bench.thickness / 2, 0.0)),
        both_sides(joined(loft(np.array(rings)), top)),
        support(rng, bench._replace(width=bench.width - wall), styles[rng.integers(len(styles))]),
    )


def _block(rng: Generator) -> Mesh:
    """Stone or concrete: one piece, or a slab whose ends are folded down to the floor."""
    width, depth, high = rng.uniform(0.9, 2.2), rng.uniform(0.38, 0.6), rng.uniform(0.4, 0.5)
    taper = rng.uniform(0.85, 1.12)
    if rng.random() < 0.4:
        plinth = rng.uniform(0.04, 0.1)
        foot = box((0.92 * width, plinth + 0.02, 0.8 * depth), (0.0, plinth / 2 + 0.01, 0.0))
        return joined(foot, box((width, high - plinth, depth), (0.0, (high + plinth) / 2, 0.0), (taper, taper)))
    wall, lean = rng.uniform(0.07, 0.16), rng.uniform(-0.1, 0.1)
    x = width / 2 - wall / 2
    side = tube([(x + lean, 0.0, 0.0), (x, high - 0.5 * wall, 0.0)], wall / 2, square=True)
    broad = Mesh(side.vertices * (1.0, 1.0, depth / wall), side.faces)
    parts = [both_sides(broad), box((width, wall, depth), (0.0, high - wall / 2, 0.0))]
    if rng.random() < 0.4:
        parts.append(box((2 * x, high * rng.uniform(0.2, 1.0) - wall / 2, wall), (0.0, high / 2, 0.0)))
    return joined(*parts)
