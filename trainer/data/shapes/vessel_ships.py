"""Ships and yachts with engines: for passengers, towing and fishing."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, moved, tube, turned
from trainer.data.shapes.vessel_hull import Hull, decked, plate
from trainer.data.shapes.vessel_parts import arch, funnel, house, mast, screen, storeys


def make_motor_yacht(rng: Generator) -> Mesh:
    """Sleek decks one above the other, each with a raked front; an arch for the radar."""
    length = rng.uniform(9.0, 45.0)
    beam = length * rng.uniform(0.2, 0.31) * (1.08 - 0.005 * length)
    depth, decks = beam * rng.uniform(0.42, 0.58), int(rng.integers(1, 4))
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(2.0, 3.0),
        entry=1.4,
        transom=rng.uniform(0.82, 0.95),
        counter=0.8,
        widest=0.4,
        rake=length * rng.uniform(0.1, 0.2),
        overhang=rng.uniform(-0.03, 0.03) * length,
        sheer=(0.0, depth * rng.uniform(0.15, 0.4)),
        rocker=(0.0, 0.3 * depth),
        bilge=rng.uniform(1.3, 1.9),
    )
    height = beam * rng.uniform(0.3, 0.4)
    forward = rng.uniform(0.66, 0.76)
    rear, front = hull.z(rng.uniform(0.08, 0.2)), hull.z(forward)
    base, lean = hull.deck(0.6) - 0.08 * depth, rng.uniform(0.6, 1.6)
    half = min(0.43 * beam, 0.94 * hull.half(forward, 0.8))
    parts = [decked(hull), plate(hull, 0.32, 0.12 * depth, (-0.06, 0.03))]
    shrink = (length * rng.uniform(-0.02, 0.08), length * rng.uniform(0.07, 0.12))
    parts.append(storeys(decks, base, height, (rear, front), half, shrink, lean))
    top, narrow = base + decks * height, half * (1 - 0.07 * decks)
    middle = (rear + decks * shrink[0] + front - decks * shrink[1] - lean * height) / 2
    if rng.random() < 0.6:
        z, low = middle + 0.06 * length, top - 0.02 * height
        parts.append(screen(z, low, 0.4 * height, 0.8 * narrow, 0.3 * height, 0.06 * narrow))
        parts.append(box((narrow, 0.35 * height, 0.04 * length), (0.0, top + 0.15 * height, middle - 0.02 * length)))
    if rng.random() < 0.7:
        z, tall = middle - 0.06 * length, top + height * rng.uniform(0.5, 0.8)
        radar = lathe([(0.15 * height, 0.0), (0.2 * height, 0.15 * height), (0.05 * height, 0.3 * height)], 10)
        parts.append(arch(0.9 * narrow, z, top - 0.1 * height, tall, 0.4 * height, 0.1 * height, square=True))
        parts.append(moved(radar, (0.0, tall, z - 0.4 * height)))
    return joined(*parts)


def make_liner(rng: Generator) -> Mesh:
    """A cruise ship, liner or ferry: rows of decks almost from end to end."""
    length = rng.uniform(60.0, 330.0)
    beam = length / rng.uniform(5.2, 8.2)
    depth = beam * rng.uniform(0.42, 0.6)
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(2.6, 4.5),
        entry=1.9,
        transom=rng.uniform(0.6, 0.9),
        counter=0.25,
        widest=0.45,
        rake=length * rng.uniform(0.03, 0.08),
        overhang=length * rng.uniform(0.01, 0.05),
        sheer=(0.05 * depth, depth * rng.uniform(0.05, 0.25)),
        rocker=(0.1 * depth, 0.0),
        bilge=4.0,
    )
    floors, storey = int(rng.integers(3, 8)), beam * rng.uniform(0.09, 0.15)
    rear, front = rng.uniform(0.04, 0.1), rng.uniform(0.76, 0.84)
    shrink = (rng.uniform(0.0, 0.03), rng.uniform(0.006, 0.022))
    parts = [decked(hull)]
    for index in range(floors):
        level, inset = 1 + (index + 1) * storey / depth, beam * (0.02 + 0.012 * index)
        ends = (rear + index * shrink[0], front - index * shrink[1])
        over = (ends[0] - 0.6 * shrink[0], ends[1] + 0.006)
        parts.append(plate(hull, level, 1.1 * storey, ends, inset))
        parts.append(plate(hull, level, 0.14 * storey, over, inset - 0.014 * beam))
    top = hull.deck(0.5) + floors * storey
    bridge = hull.z(front - 0.6 * floors * shrink[1])
    base = hull.deck(front) + 0.6 * floors * storey
    wing = min(0.52 * beam, 1.12 * hull.half(front))
    parts.append(house(base, storey, (bridge - 0.03 * length, bridge + 0.01 * length), wing, (0.0, 0.4 * storey)))
    count = int(rng.integers(1, 4))
    rake = storey * rng.uniform(0.3, 1.5)
    for share in np.linspace(0.3, 0.62, count) if count > 1 else [rng.uniform(0.2, 0.5)]:
        parts.append(funnel(hull.z(share), top - 0.4 * storey, storey * rng.uniform(2.6, 4.0), 0.1 * beam, rake, 1.7))
    parts.append(mast((0.0, top - storey, hull.z(0.7)), 3.0 * storey, 0.015 * beam, 0.3 * storey))
    return joined(*parts)


def make_tug(rng: Generator) -> Mesh:
    """Short and broad, a high wheelhouse well forward, a low working deck behind."""
    length = rng.uniform(14.0, 36.0)
    beam = length * rng.uniform(0.3, 0.38)
    depth = beam * rng.uniform(0.45, 0.6)
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(2.6, 4.0),
        entry=1.8,
        transom=rng.uniform(0.6, 0.85),
        counter=0.3,
        widest=0.45,
        rake=0.05 * length,
        overhang=0.05 * length,
        sheer=(0.05 * depth, depth * rng.uniform(0.35, 0.7)),
        rocker=(0.3 * depth, 0.0),
        bilge=2.6,
    )
    storey, half = 0.26 * beam, 0.36 * beam
    base, rear, front = hull.deck(0.5) - 0.05 * depth, rng.uniform(0.3, 0.42), rng.uniform(0.72, 0.8)
    upper = (hull.z(front) - 0.27 * length, hull.z(front) - 0.03 * length)
    top = base + 2.1 * storey
    parts = [
        decked(hull, 0.18 * depth, 0.05 * beam),
        storeys(1, base, 1.15 * storey, (hull.z(rear), hull.z(front)), half, (0.0, 0.0), 0.15),
        storeys(1, base + storey, 1.1 * storey, upper, 0.7 * half, (0.0, 0.0), -0.12),
        mast((0.0, top - 0.2 * storey, upper[0] + 0.08 * length), storey * rng.uniform(1.2, 2.0), 0.02 * beam),
        *_bitts(beam, base, depth, hull.z(0.24)),
    ]
    tall = rng.uniform(1.2, 1.8) * storey
    stack = funnel(hull.z(rear) + 0.07 * length, base + storey, tall, 0.1 * beam, 0.1 * storey, 1.3)
    parts.append(stack if rng.random() < 0.5 else both_sides(moved(stack, (0.55 * half, 0.0, 0.0))))
    tyre = turned(lathe([(0.07 * beam, -0.03 * beam), (0.1 * beam, 0.0), (0.07 * beam, 0.03 * beam)], 12), 2, np.pi / 2)
    for station in np.linspace(0.2, 0.75, int(rng.integers(3, 6))):
        place = (hull.half(station, 0.8), hull.deck(station) - 0.1 * beam, hull.z(station))
        parts.append(both_sides(moved(tyre, place)))
    return joined(*parts)


def _bitts(beam: float, base: float, depth: float, z: float) -> list[Mesh]:
    """The posts and the bar that a tug's hawser is made fast to."""
    x, bar, top = 0.14 * beam, base + 0.6 * depth, base + 0.75 * depth
    post = cylinder((x, base - 0.1 * depth, z), (x, top, z), 0.045 * beam, 8)
    return [both_sides(post), cylinder((-1.6 * x, bar, z), (1.6 * x, bar, z), 0.04 * beam, 8)]


def make_trawler(rng: Generator) -> Mesh:
    """A fishing boat: one wheelhouse, masts with booms, a gallows at the stern."""
    length = rng.uniform(8.0, 34.0)
    beam = length * rng.uniform(0.26, 0.36)
    depth, aft = beam * rng.uniform(0.45, 0.62), rng.random() < 0.45
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(2.0, 3.0),
        entry=1.6,
        transom=rng.uniform(0.5, 0.8),
        counter=0.25,
        widest=0.46,
        rake=length * rng.uniform(0.06, 0.13),
        overhang=length * rng.uniform(0.0, 0.06),
        sheer=(depth * rng.uniform(0.05, 0.3), depth * rng.uniform(0.4, 0.8)),
        rocker=(0.1 * depth, 0.05 * depth),
        bilge=rng.uniform(1.8, 2.6),
    )
    centre, storey, half = 0.24 if aft else 0.62, 0.33 * beam, 0.32 * beam
    base, z = hull.deck(centre) - 0.06 * depth, hull.z(centre)
    deep = 0.2 * length
    parts = [
        decked(hull, 0.16 * depth, 0.04 * beam),
        storeys(1, base, storey, (z - deep / 2, z + deep / 2), half, (0.0, 0.0), 0.1),
        storeys(1, base + 0.9 * storey, 0.8 * storey, (z - 0.3 * deep, z + 0.35 * deep), 0.75 * half, (0.0, 0.0), -0.1),
        mast((0.0, base + 1.4 * storey, z - 0.1 * deep), 1.5 * storey, 0.018 * beam),
        box((0.4 * beam, 0.12 * beam, 0.12 * length), (0.0, hull.deck(0.5), hull.z(0.46))),
    ]
    work = hull.z(0.62 if aft else 0.36)
    tall = rng.uniform(0.32, 0.45) * length
    parts.append(mast((0.0, depth - 0.1 * depth, work), tall, 0.012 * length))
    boom = rng.choice([-1.0, 1.0]) * 0.25 * length
    parts.append(tube([(0.0, depth + 0.35 * tall, work), (0.0, depth + 0.8 * tall, work + boom)], 0.008 * length, 6))
    if rng.random() < 0.6:
        deck = hull.deck(0.06)
        parts.append(
            arch(0.75 * hull.half(0.06), hull.z(0.06), deck - 0.1 * depth, deck + 0.42 * beam, 0.0, 0.02 * beam)
        )
    if rng.random() < 0.3:
        outrigger = [(0.0, depth + 0.2 * tall, work), (0.3 * length, depth + 0.9 * tall, work)]
        parts.append(both_sides(tube(outrigger, 0.007 * length, 6)))
    return joined(*parts)
