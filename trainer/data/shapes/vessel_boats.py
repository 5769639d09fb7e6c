"""Boats that carry a few people: rowed, and driven by small engines."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, joined, moved, tube
from trainer.data.shapes.vessel_hull import Hull, hollow, plate, shell
from trainer.data.shapes.vessel_parts import arch, house, oar, outboard, screen


def make_rowing_boat(rng: Generator) -> Mesh:
    """An open boat with thwarts, at times with oars or a motor."""
    length = rng.uniform(2.4, 6.0)
    beam = length * rng.uniform(0.3, 0.46) * (1.12 - 0.04 * length)
    depth, pointed = beam * rng.uniform(0.3, 0.46), rng.random() < 0.2
    transom = 0.05 if pointed else rng.uniform(0.5, 0.85)
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(1.7, 3.2),
        entry=rng.uniform(1.3, 2.0),
        transom=transom,
        counter=0.7 * transom,
        widest=rng.uniform(0.42, 0.52),
        rake=length * rng.uniform(0.04, 0.14),
        overhang=length * rng.uniform(0.0, 0.06),
        sheer=(depth * rng.uniform(0.0, 0.25), depth * rng.uniform(0.15, 0.6)),
        rocker=(depth * 0.05, depth * 0.2),
        bilge=rng.uniform(1.5, 3.5),
    )
    wall, floor = rng.uniform(0.045, 0.075) * beam, rng.uniform(0.18, 0.28)
    parts = [hollow(hull, wall, floor)]
    seat, deep = rng.uniform(0.5, 0.72), 0.06 * depth + 0.015
    for station in np.linspace(rng.uniform(0.16, 0.24), rng.uniform(0.66, 0.76), int(rng.integers(2, 5))):
        reach = rng.uniform(0.05, 0.08)
        parts.append(plate(hull, seat, deep, (station - reach / 2, station + reach / 2), 0.5 * wall))
    if not pointed and rng.random() < 0.5:
        parts.append(plate(hull, seat, deep, (0.01, 0.12), 0.5 * wall))
    if rng.random() < 0.35:
        parts.append(plate(hull, 0.96, deep, (0.8, 1.0), 0.5 * wall))
    if rng.random() < 0.28:
        side = (hull.half(0.45) - wall, hull.deck(0.45) + 0.02, hull.z(0.45))
        parts.append(both_sides(oar(rng, side, rng.uniform(0.55, 0.7) * length)))
    elif not pointed and rng.random() < 0.3:
        parts.append(outboard(0.0, hull.deck(0.0), hull.z(0.0), 0.45 + 0.04 * length))
    return joined(*parts)


def make_inflatable(rng: Generator) -> Mesh:
    """A fat tube bent around the bow, a floor, a motor or oars."""
    length = rng.uniform(2.4, 6.5)
    beam = length * rng.uniform(0.36, 0.48) * (1.1 - 0.035 * length)
    radius = beam * rng.uniform(0.11, 0.14)
    x, start, rise = beam / 2 - radius, -length / 2, rng.uniform(0.3, 1.2) * radius
    shoulder = length / 2 - 1.3 * beam * rng.uniform(0.45, 0.65)
    angles = np.linspace(0.0, np.pi / 2, 6)
    level, reach = radius + 0.05 * beam, length / 2 - radius - shoulder
    bend = np.stack((x * np.cos(angles), level + rise * np.sin(angles) ** 2, shoulder + reach * np.sin(angles)), -1)
    side = np.concatenate(([(x, level, start), (x, level, start + 0.08 * length)], bend))
    path = np.concatenate((side, side[-2::-1] * (-1.0, 1.0, 1.0)))
    radii = [0.35 * radius, *[radius] * (len(path) - 2), 0.35 * radius]
    outline = np.concatenate((side[:-1], side[-2::-1] * (-1.0, 1.0, 1.0)))
    keel, floor = outline * (0.25, 0.0, 1.0), outline * (1.0, 0.0, 1.0)
    keel[:, 1], floor[:, 1] = 0.05 * beam, level - 0.3 * radius
    # The keel ends before the bow's tube, which rises above it.
    keel[:, 2] = start + 0.86 * (keel[:, 2] - start)
    parts = [
        tube(path, radii, 12),
        shell((keel, floor)),
        box((2 * x, 1.6 * radius, 0.12 * radius), (0.0, level, start + 0.12 * length)),
    ]
    if rng.random() < 0.7:
        parts.append(outboard(0.0, level + 0.8 * radius, start + 0.1 * length, 0.4 + 0.06 * length))
    else:
        parts.append(both_sides(oar(rng, (x, level + radius, 0.0), 0.7 * length)))
    if length > 4.2:
        console = (-0.06 * length, 0.06 * length)
        parts.append(house(level - radius, 2.6 * radius, console, 0.45 * x, (0.0, 0.05 * length)))
        parts.append(box((0.8 * x, 1.8 * radius, 0.09 * length), (0.0, level, -0.2 * length)))
    else:
        parts.append(box((2 * x, 0.3 * radius, 0.08 * length), (0.0, level + 0.4 * radius, -0.05 * length)))
    return joined(*parts)


def make_motor_boat(rng: Generator) -> Mesh:
    """A runabout: foredeck, windscreen, open cockpit; at times a roof or a small cabin."""
    length = rng.uniform(4.5, 9.5)
    beam, depth = length * rng.uniform(0.27, 0.37), length * rng.uniform(0.13, 0.18)
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(2.0, 3.4),
        entry=rng.uniform(1.2, 1.7),
        transom=rng.uniform(0.8, 0.96),
        counter=0.85,
        widest=rng.uniform(0.34, 0.45),
        rake=length * rng.uniform(0.12, 0.22),
        overhang=rng.uniform(-0.04, 0.02) * length,
        sheer=(0.0, depth * rng.uniform(0.05, 0.3)),
        rocker=(0.0, depth * rng.uniform(0.2, 0.45)),
        bilge=rng.uniform(1.4, 2.0),
    )
    wall, front = 0.05 * beam, rng.uniform(0.5, 0.64)
    deck = plate(hull, 0.98, 0.5 * depth, (front, 0.99), 0.4 * wall)
    parts = [hollow(hull, wall, 0.55), deck]
    base, half = hull.deck(front), hull.half(front)
    if rng.random() < 0.35:
        cabin = (hull.z(front), hull.z(0.86))
        height = depth * rng.uniform(0.45, 0.8)
        breadth = min(0.6 * half, 0.85 * hull.half(0.86))
        parts.append(house(base - 0.1 * depth, height, cabin, breadth, (0.0, 0.2 * length), 0.2 * breadth))
    glass = length * rng.uniform(0.055, 0.085)
    parts.append(screen(hull.z(front) + 0.3 * half, base - 0.03 * depth, glass, 0.88 * half, 0.35 * half, 0.05 * half))
    for station in (front - 0.14, front - 0.28)[: int(rng.integers(1, 3))]:
        z, floor = hull.z(station), 0.56 * depth
        pad = cushion((0.42 * half, 0.3 * depth, 0.07 * length), (0.36 * half, floor + 0.14 * depth, z), 0.03)
        back = (0.36 * half, floor + 0.3 * depth, z - 0.04 * length)
        parts.append(both_sides(joined(pad, cushion((0.42 * half, 0.65 * depth, 0.02 * length), back, 0.02))))
    parts.append(plate(hull, 0.86, 0.25 * depth, (0.05, 0.14), 0.5 * wall))
    kind = rng.random()
    if kind < 0.6:
        motor = outboard(0.0, hull.deck(0.0) + 0.05, hull.z(0.0), 0.1 * length)
        parts.append(both_sides(moved(motor, (0.07 * length, 0.0, 0.0))) if kind < 0.2 else motor)
    else:
        parts.append(plate(hull, 0.3, 0.1 * depth, (-0.08, 0.02)))
    roof = rng.random()
    if roof < 0.25:
        x, top = 0.92 * hull.half(0.4), base + 0.17 * length
        parts.append(arch(x, hull.z(0.4), 0.9 * depth, top, 0.06 * length, 0.007 * length))
    elif roof < 0.5:
        z, x, top = hull.z(front - 0.2), 0.85 * half, base + 0.2 * length
        parts.append(cushion((2 * x, 0.012 * length, 0.3 * length), (0.0, top, z), 0.005 * length))
        for end in (-0.13, 0.13):
            foot, head = (0.95 * x, 0.6 * depth, z + end * length), (0.92 * x, top, z + end * length)
            parts.append(both_sides(tube([foot, head], 0.006 * length, 6)))
    return joined(*parts)
