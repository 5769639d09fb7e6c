"""Vessels that most people would call unusual: a canoe, a paddle steamer, a hovercraft."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, loft, moved, ring, tube, turned
from trainer.data.shapes.vessel_hull import Hull, decked, hollow, plate
from trainer.data.shapes.vessel_parts import house, storeys


def make_canoe(rng: Generator) -> Mesh:
    """A canoe, a kayak or a gondola: very slender, pointed at both ends."""
    length = rng.uniform(3.8, 11.0)
    kayak = length < 5.6 and rng.random() < 0.5
    beam = 0.12 * length + 0.3
    depth = beam * (0.42 if kayak else rng.uniform(0.42, 0.55))
    rise = depth * (0.2 if kayak else rng.uniform(0.4, 1.4))
    front = 1.0 if length < 7.0 else 1.9
    hull = Hull(
        length,
        beam,
        depth,
        bow=2.0,
        entry=1.8,
        transom=0.03,
        counter=0.03,
        widest=0.48,
        rake=0.05 * length,
        overhang=0.05 * length,
        sheer=(rise, front * rise),
        rocker=(0.5 * rise, 0.5 * rise),
        bilge=2.4,
    )
    if kayak:
        parts = [decked(hull), *_cockpit(hull)]
    else:
        parts = [hollow(hull, 0.06 * beam, 0.25)]
        for station in np.linspace(0.2, 0.72, 3):
            parts.append(plate(hull, 0.75, 0.07 * depth, (station - 0.02, station + 0.02), 0.01 * beam))
        parts.append(plate(hull, 0.98, 0.06 * depth, (0.86, 1.0), 0.01 * beam))
    if rng.random() < 0.5:
        way = [(-0.9 * beam, 1.1 * depth, 0.08 * length), (0.9 * beam, 1.5 * depth, 0.14 * length)]
        parts.append(tube(way, 0.03 * beam, 6))
        parts.append(tube([way[0], (-1.35 * beam, 0.95 * depth, 0.055 * length)], 0.11 * beam, 8))
    return joined(*parts)


def _cockpit(hull: Hull) -> list[Mesh]:
    """The rim of a kayak's opening, and its raised deck before it."""
    z, half, unit = hull.z(0.46), 0.33 * hull.beam, 0.1 * hull.beam
    rows = ((-0.5, 1.0), (1.1, 1.0), (1.1, 0.82), (0.3, 0.8))
    rim = loft(np.stack([ring(k * half, 1.5 * k * half, hull.depth + up * unit, 14) for up, k in rows]))
    front = (z + 1.3 * half, hull.z(0.9))
    deck = house(hull.depth - 0.4 * unit, 1.1 * unit, front, 0.5 * half, (0.0, 0.3 * hull.length), 0.3 * half)
    return [moved(rim, (0.0, 0.0, z)), deck]


def make_paddle_steamer(rng: Generator) -> Mesh:
    """Flat and broad, galleries on posts, two thin chimneys, a wheel at the stern or one at either side."""
    length = rng.uniform(30.0, 75.0)
    beam, stern = length * rng.uniform(0.18, 0.25), rng.random() < 0.6
    depth = 0.22 * beam
    hull = Hull(
        length,
        beam,
        depth,
        bow=2.6,
        entry=2.0,
        transom=0.9,
        counter=0.8,
        widest=0.42,
        rake=0.04 * length,
        overhang=0.02 * length,
        sheer=(0.0, 0.3 * depth),
        rocker=(0.2 * depth, 0.2 * depth),
        bilge=4.0,
    )
    floors, storey = int(rng.integers(2, 4)), 0.22 * beam
    span = (hull.z(0.08), hull.z(0.8))
    top = depth + floors * storey
    parts = [decked(hull)]
    for index in range(floors):
        low = depth + index * storey
        ends = (span[0], span[1] - 0.05 * index * length)
        rooms = (ends[0] + 0.03 * length, ends[1] - 0.06 * length)
        parts.append(house(low - 0.05 * storey, storey, rooms, 0.34 * beam))
        parts.append(house(low + 0.88 * storey, 0.12 * storey, ends, 0.5 * beam))
        post = both_sides(box((0.03 * beam, storey, 0.03 * beam), (0.47 * beam, low + 0.45 * storey, 0.0)))
        for z in np.linspace(ends[0] + 0.02 * length, ends[1] - 0.02 * length, 6):
            parts.append(moved(post, (0.0, 0.0, float(z))))
    parts.append(house(top - 0.05 * storey, 0.9 * storey, (hull.z(0.55), hull.z(0.66)), 0.2 * beam))
    x, z = 0.2 * beam, hull.z(0.7)
    parts.append(both_sides(cylinder((x, top - storey, z), (x, top + 2.2 * storey, z), 0.05 * beam, 10)))
    radius = storey * rng.uniform(1.0, 1.3)
    half = 0.4 * beam if stern else 0.09 * beam
    wheel = _paddle_wheel(radius, half)
    if stern:
        z = hull.z(0.0)
        parts.append(moved(wheel, (0.0, 0.9 * radius, z - 0.6 * radius)))
        bearer = box((0.04 * beam, 0.2 * depth, 1.6 * radius), (0.44 * beam, 0.9 * radius, z - 0.2 * radius))
        parts.append(both_sides(bearer))
    else:
        parts.append(both_sides(moved(wheel, (0.6 * beam, 0.95 * radius, hull.z(0.5)))))
        cover = lathe([(1.05 * radius, -half), (1.1 * radius, 0.0), (1.05 * radius, half)], 18)
        parts.append(both_sides(moved(turned(cover, 2, -np.pi / 2), (0.6 * beam, 1.2 * radius, hull.z(0.5)))))
    return joined(*parts)


def _paddle_wheel(radius: float, half: float) -> Mesh:
    """Boards between two hoops, and the axle; `half` its breadth."""
    board = box((2 * half, 0.3 * radius, 0.06 * radius), (0.0, 0.85 * radius, 0.0))
    spokes = box((0.06 * radius, 1.8 * radius, 0.08 * radius), (0.8 * half, 0.0, 0.0))
    hoop = moved(turned(_hoop(0.9 * radius, 0.05 * radius), 1, np.pi / 2), (0.8 * half, 0.0, 0.0))
    return joined(
        cylinder((-half, 0.0, 0.0), (half, 0.0, 0.0), 0.2 * radius, 10),
        *(turned(board, 0, angle) for angle in np.arange(10) * np.pi / 5),
        *(both_sides(turned(spokes, 0, angle)) for angle in np.arange(5) * np.pi / 5),
        both_sides(hoop),
    )


def _hoop(radius: float, thickness: float) -> Mesh:
    """A ring about the z axis; its last segment lies on its first, so that no wedge stays open."""
    angles = np.arange(18) * np.pi / 8
    return tube(radius * np.stack((np.cos(angles), np.sin(angles), 0 * angles), -1), thickness, 6)


def make_hovercraft(rng: Generator) -> Mesh:
    """A cabin on a rounded air cushion, with screws in rings behind."""
    length = rng.uniform(6.0, 40.0)
    half, skirt = length * rng.uniform(0.22, 0.27), length * rng.uniform(0.07, 0.1)
    rows = ((0.0, 0.86), (0.35, 1.0), (0.8, 1.0), (1.0, 0.92))
    cushion = loft(np.stack([ring(k * half, k * length / 2, y * skirt, 24, 4.0) for y, k in rows]))
    high = length * rng.uniform(0.09, 0.14)
    cabin = storeys(1, skirt, high, (-0.25 * length, 0.34 * length), 0.68 * half, (0.0, 0.0), 0.9)
    bridge, lean = (0.02 * length, 0.2 * length), (0.02 * length, 0.06 * length)
    pilot = house(skirt + 0.9 * high, 0.5 * high, bridge, 0.35 * half, lean)
    radius = 0.42 * half
    blade = box((0.2 * radius, 0.95 * radius, 0.08 * radius), (0.0, 0.45 * radius, 0.0))
    rudder = box((0.07 * radius, 1.7 * radius, 0.4 * radius), (0.0, 0.0, -0.45 * radius))
    stand = box((0.25 * radius, radius, 0.4 * radius), (0.0, -0.6 * radius, 0.0))
    screw = joined(
        _hoop(radius, 0.13 * radius),
        *(turned(blade, 2, angle + 0.3) for angle in np.arange(4) * np.pi / 2),
        rudder,
        stand,
    )
    place = (0.5 * half, skirt + 1.05 * radius, -0.4 * length)
    return joined(cushion, cabin, pilot, both_sides(moved(screw, place)))
