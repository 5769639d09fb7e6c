"""Vessels of navies: frigates and battleships, aircraft carriers, submarines."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, loft, moved, ring, tube, turned
from trainer.data.shapes.vessel_hull import Hull, decked
from trainer.data.shapes.vessel_parts import funnel, house, lattice_mast, turret


def make_warship(rng: Generator) -> Mesh:
    """A frigate, destroyer or battleship: slender, guns before and behind, a tower, one funnel or two."""
    length = rng.uniform(60.0, 240.0)
    beam = length / rng.uniform(6.5, 9.5)
    depth, stealthy = beam * rng.uniform(0.5, 0.65), rng.random() < 0.35
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(1.9, 2.6),
        entry=1.5,
        transom=rng.uniform(0.6, 0.85),
        counter=0.35,
        widest=rng.uniform(0.42, 0.5),
        rake=length * rng.uniform(0.05, 0.09),
        overhang=length * rng.uniform(0.0, 0.03),
        sheer=(0.0, depth * rng.uniform(0.1, 0.35)),
        rocker=(0.3 * depth, 0.05 * depth),
        bilge=rng.uniform(2.0, 3.5),
    )
    rear, front = rng.uniform(0.2, 0.28), rng.uniform(0.66, 0.74)
    base, storey = hull.deck(0.5) - 0.05 * depth, 0.17 * beam
    half = min(beam * rng.uniform(0.3, 0.42), 0.95 * hull.half(front, 0.8))
    lean, tumble = (2.0 * storey, 0.22 * half) if stealthy else (0.3 * storey, 0.02 * half)
    tower = front - rng.uniform(0.08, 0.12)
    upper = (hull.z(tower - 0.07), hull.z(front) - 0.8 * lean - 0.01 * length)
    parts = [
        decked(hull),
        house(base, 1.5 * storey, (hull.z(rear), hull.z(front)), half, (0.5 * lean, lean), tumble),
        house(base + storey, 2.4 * storey, upper, 0.82 * half, (0.2 * lean, 0.6 * lean), tumble),
        lattice_mast(hull.z(tower - 0.02), base + 3.2 * storey, beam * rng.uniform(0.7, 1.1), 0.28 * beam),
    ]
    for index in range(int(rng.integers(1, 3))):
        z = hull.z(tower - 0.15 - 0.13 * index)
        if stealthy:
            span = (z - 0.03 * length, z + 0.03 * length)
            slopes = (0.3 * storey, 0.8 * storey)
            parts.append(house(base + storey, 2.3 * storey, span, 0.5 * half, slopes, 0.15 * half))
        else:
            parts.append(funnel(z, base + 1.3 * storey, rng.uniform(1.6, 2.6) * storey, 0.13 * beam, 0.4 * storey, 1.6))
    guns, barrels = int(rng.integers(1, 3)), int(rng.integers(1, 4))
    size = beam * (rng.uniform(0.4, 0.52) if barrels > 1 else rng.uniform(0.2, 0.3))
    for index in range(guns):
        station = front + 0.07 + (0.1 + 0.04 * (barrels > 1)) * (guns - 1 - index)
        up = hull.deck(station) + index * 0.35 * size
        parts.append(turret(hull.z(station), up, size, barrels, forward=True))
        if index:
            parts.append(moved(lathe([(0.45 * size, -0.5 * size), (0.45 * size, 0.0)], 12), (0.0, up, hull.z(station))))
    if rng.random() < 0.55:
        parts.append(turret(hull.z(rear - 0.08), hull.deck(rear - 0.08), size, barrels, forward=False))
    else:
        hangar = (hull.z(rear - 0.02), hull.z(rear + 0.09))
        parts.append(house(base, 2.6 * storey, hangar, 0.75 * half, (0.0, 0.1 * lean), tumble))
    return joined(*parts)


def make_carrier(rng: Generator) -> Mesh:
    """An aircraft carrier: a flat deck wider than the hull, the island on its right."""
    length = rng.uniform(180.0, 340.0)
    beam, depth = length / rng.uniform(6.8, 8.2), length * rng.uniform(0.065, 0.085)
    hull = Hull(
        length,
        beam,
        depth,
        bow=2.6,
        entry=1.7,
        transom=0.85,
        counter=0.3,
        widest=0.45,
        rake=0.06 * length,
        overhang=0.03 * length,
        sheer=(0.0, 0.0),
        rocker=(0.2 * depth, 0.0),
        bilge=3.0,
    )
    thick, over = 0.1 * depth, rng.uniform(0.72, 0.95)
    ski = depth * rng.uniform(0.25, 0.45) if rng.random() < 0.3 else 0.0
    left = [(0.45, 0.52), (over, 0.2), (over, -0.3), (0.5, -0.42), (0.5, -0.51)]
    outline = np.array([*left, (-0.62, -0.51), (-0.66, 0.3), (-0.3, 0.52)]) * (beam, length)
    height = depth + np.where(outline[:, 1] > 0.4 * length, ski, 0.0)
    levels = ((-0.6 * depth, 0.7), (0.0, 1.0), (thick, 1.0))
    deck = loft(np.stack([np.stack((outline[:, 0] * k, height + y, outline[:, 1]), -1) for y, k in levels]))
    parts = [
        decked(hull),
        deck,
        moved(_island(length, beam, depth), (-0.52 * beam, 0.0, rng.uniform(-0.1, 0.1) * length)),
    ]
    jet = _parked_jet(0.055 * length)
    for _ in range(int(rng.integers(0, 9))):
        spot = (rng.uniform(-0.35, 0.6) * beam, depth + thick, rng.uniform(-0.42, 0.3) * length)
        parts.append(moved(turned(jet, 1, rng.uniform(-0.7, 0.7)), spot))
    return joined(*parts)


def _island(length: float, beam: float, depth: float) -> Mesh:
    """Bridge, mast and funnel of a carrier."""
    storey, unit = 0.2 * depth, 0.01 * length
    return joined(
        house(depth, 4.5 * storey, (-5 * unit, 5 * unit), 0.09 * beam, (unit, 1.2 * unit)),
        house(depth + 2.5 * storey, 2.6 * storey, (-unit, 4.5 * unit), 0.12 * beam, (0.0, 0.8 * unit)),
        lattice_mast(0.0, depth + 4.8 * storey, 4.5 * storey, 0.09 * beam),
        funnel(-3.5 * unit, depth + 3.0 * storey, 3.0 * storey, 0.05 * beam, storey),
    )


def _parked_jet(size: float) -> Mesh:
    return joined(
        box((0.14 * size, 0.16 * size, size), (0.0, 0.08 * size, 0.0), (0.7, 0.9)),
        box((0.75 * size, 0.05 * size, 0.3 * size), (0.0, 0.08 * size, -0.08 * size)),
        box((0.04 * size, 0.3 * size, 0.2 * size), (0.0, 0.2 * size, -0.4 * size)),
    )


def make_submarine(rng: Generator) -> Mesh:
    """A cigar with a sail, planes and a screw."""
    length = rng.uniform(55.0, 170.0)
    radius = length / rng.uniform(8.5, 12.5) / 2
    blunt = rng.uniform(0.35, 0.6)
    shares = np.array([0.0, 0.015, 0.05, 0.11, 0.2, 0.62, 0.8, 0.93, 1.0])
    sizes = np.array([0.12, 0.42, 0.72, 0.93, 1.0, 1.0, 0.78, 0.32, 0.08])
    sizes[1:4] = sizes[1:4] ** (2 * blunt)
    old = rng.random() < 0.3
    width = 0.8 if old else 1.0
    rings = [
        ring(width * k * radius, k * radius, 0.0, 18)[:, [0, 2, 1]] + np.array((0.0, radius, length / 2 - s * length))
        for s, k in zip(shares, sizes, strict=True)
    ]
    tower = length * rng.uniform(0.12, 0.26)
    deep, high = length * rng.uniform(0.08, 0.15), radius * rng.uniform(0.9, 1.4)
    half = radius * rng.uniform(0.2, 0.3)
    rows = ((1.7 * radius, 1.0), (2 * radius + 0.9 * high, 0.93), (2 * radius + high, 0.75))
    conning = loft(np.stack([ring(k * half, k * deep / 2, y, 16, 2.4) for y, k in rows]))
    tail, fin = -0.43 * length, 1.35 * radius
    parts = [
        loft(np.stack(rings)),
        moved(conning, (0.0, 0.0, tower)),
        both_sides(box((fin, 0.12 * radius, 0.55 * radius), (0.55 * fin, radius, tail))),
        box((0.12 * radius, 2.5 * radius, 0.6 * radius), (0.0, radius, tail - 0.1 * radius)),
    ]
    on_sail, on_bow = (0.3 * radius, 2 * radius + 0.6 * high, tower), (0.9 * radius, radius, 0.36 * length)
    plane = box((1.1 * radius, 0.1 * radius, 0.4 * radius), on_sail if rng.random() < 0.5 else on_bow)
    parts.append(both_sides(plane))
    for offset in (0.15, -0.1)[: int(rng.integers(1, 3))]:
        parts.append(
            cylinder(
                (0.0, 2 * radius, tower + offset * deep),
                (0.0, 2 * radius + high * rng.uniform(1.3, 1.8), tower + offset * deep),
                0.07 * radius,
                8,
            )
        )
    blade = turned(box((0.25 * radius, 0.75 * radius, 0.06 * radius), (0.0, 0.4 * radius, 0.0), (0.7, 1.0)), 1, 0.6)
    parts += [moved(turned(blade, 2, angle), (0.0, radius, -0.49 * length)) for angle in np.arange(5) * 2 * np.pi / 5]
    if old:
        parts.append(
            house(
                1.75 * radius,
                0.35 * radius,
                (-0.36 * length, 0.44 * length),
                0.4 * radius,
                (0.05 * length, 0.03 * length),
                0.05 * radius,
            )
        )
        parts.append(
            tube([(0.0, 2.3 * radius, tower + 1.0 * deep), (0.0, 2.4 * radius, tower + 1.6 * deep)], 0.06 * radius, 6)
        )
    return joined(*parts)
