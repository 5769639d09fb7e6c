"""Vessels under sail: yachts and dinghies, catamarans, longships, square riggers."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, moved, tube, turned
from trainer.data.shapes.vessel_hull import Hull, decked, hollow, plate
from trainer.data.shapes.vessel_parts import fin_keel, house, mast, storeys
from trainer.data.shapes.vessel_rig import rig, sail, square_sail


def make_sailing_boat(rng: Generator) -> Mesh:
    """A yacht or dinghy under main and jib, with one mast or two; at times with its sails down."""
    length = rng.uniform(3.6, 17.0)
    dinghy = length < 5.8
    beam = length * (rng.uniform(0.32, 0.4) if dinghy else rng.uniform(0.25, 0.34))
    depth, classic = beam * rng.uniform(0.32, 0.42), rng.random() < 0.35
    transom = rng.uniform(0.25, 0.5) if classic else rng.uniform(0.6, 0.9)
    hull = Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(1.8, 2.5),
        entry=1.4,
        transom=transom,
        counter=0.3 * transom,
        widest=rng.uniform(0.4, 0.5),
        rake=length * (rng.uniform(0.1, 0.2) if classic else rng.uniform(0.01, 0.08)),
        overhang=length * (rng.uniform(0.08, 0.16) if classic else rng.uniform(-0.05, 0.04)),
        sheer=(depth * rng.uniform(0.0, 0.2), depth * rng.uniform(0.1, 0.45)),
        rocker=(0.35 * depth, 0.3 * depth),
        bilge=rng.uniform(1.4, 2.2),
    )
    parts = [hollow(hull, 0.04 * beam, 0.35)] if dinghy else [decked(hull), *_coachroof(rng, hull)]
    if dinghy:
        parts += [
            plate(hull, 0.7, 0.05 * depth, (0.4, 0.48), 0.02 * beam),
            plate(hull, 0.98, 0.1 * depth, (0.66, 1.0), 0.02 * beam),
        ]
    if dinghy or rng.random() < 0.75:
        deep = length * rng.uniform(0.1, 0.16)
        chord = length * (rng.uniform(0.25, 0.4) if classic else rng.uniform(0.1, 0.16))
        bulb = not classic and not dinghy and rng.random() < 0.5
        parts.append(fin_keel(0.0, 0.12 * depth, deep, chord, 0.016 * length, bulb))
        # A dinghy's rudder hangs on the transom, a yacht's stands under the hull.
        place, top = (hull.z(0.0), hull.deck(0.0)) if dinghy else (hull.z(0.16), 0.8 * depth)
        parts.append(fin_keel(place, top, 0.7 * deep + top, 0.06 * length, 0.012 * length, bulb=False))
    parts += rig(rng, hull, length * rng.uniform(0.95, 1.3), two_masts=not dinghy and rng.random() < 0.2)
    return joined(*parts)


def _coachroof(rng: Generator, hull: Hull) -> list[Mesh]:
    """A low cabin before the cockpit, and the cockpit's coaming."""
    height, half = 0.035 * hull.length + 0.1, hull.half(0.55) * rng.uniform(0.5, 0.65)
    base, rear = hull.deck(0.5) - 0.05, hull.z(rng.uniform(0.34, 0.42))
    lean = (0.1 * height, hull.length * rng.uniform(0.04, 0.12))
    cabin = house(base, height, (rear, hull.z(rng.uniform(0.66, 0.76))), half, lean, 0.18 * half)
    z = (hull.z(0.05) + rear) / 2
    coaming = box((0.1 * half, 0.6 * height + 0.1, rear - hull.z(0.05)), (0.9 * half, base + 0.3 * height, z))
    return [cabin, both_sides(coaming)]


def make_catamaran(rng: Generator) -> Mesh:
    """Two slender hulls under one bridge: with sails, or a fast ferry's decks."""
    length = rng.uniform(4.5, 28.0)
    apart, beam = length * rng.uniform(0.17, 0.23), length * rng.uniform(0.09, 0.13)
    depth = beam * rng.uniform(0.9, 1.25)
    hull = Hull(
        length,
        beam,
        depth,
        bow=1.9,
        entry=1.5,
        transom=0.75,
        counter=0.5,
        widest=0.4,
        rake=0.03 * length,
        overhang=0.02 * length,
        sheer=(0.0, 0.1 * depth),
        rocker=(0.3 * depth, 0.1 * depth),
        bilge=2.2,
    )
    parts = [both_sides(moved(decked(hull), (apart, 0.0, 0.0)))]
    low, half = 0.6 * depth, apart + 0.18 * beam
    span = (hull.z(rng.uniform(0.04, 0.12)), hull.z(rng.uniform(0.6, 0.78)))
    parts.append(house(low, depth - low + 0.02 * length, span, half, (0.0, 0.03 * length)))
    if rng.random() < 0.65:
        if length > 9.0:
            height = rng.uniform(0.07, 0.1) * length
            cabin, lean = (hull.z(0.2), hull.z(0.62)), (0.03 * length, 0.12 * length)
            parts.append(house(depth, height, cabin, 0.8 * apart, lean, 0.15 * apart))
        tall = hull._replace(depth=depth + 0.06 * length * (length > 9.0))
        parts += rig(rng, tall, length * rng.uniform(1.0, 1.25))
        beam_ends = [(x, 0.95 * depth, hull.z(0.9)) for x in (-apart, apart)]
        parts.append(tube(beam_ends, 0.014 * length, 8))
    else:
        count = int(rng.integers(1, 4))
        base, decks = depth + 0.02 * length, (span[0] + 0.05 * length, span[1])
        parts.append(storeys(count, base, 0.065 * length, decks, 0.92 * half, (0.07 * length, 0.09 * length), 0.5))
    return joined(*parts)


def make_viking_ship(rng: Generator) -> Mesh:
    """Pointed and high at both ends, shields along the sides, one square sail, a dragon before."""
    length = rng.uniform(12.0, 28.0)
    beam = length * rng.uniform(0.17, 0.26)
    depth = beam * rng.uniform(0.3, 0.4)
    rise = length * rng.uniform(0.07, 0.11)
    hull = Hull(
        length,
        beam,
        depth,
        bow=2.0,
        entry=1.8,
        transom=0.04,
        counter=0.04,
        widest=0.5,
        rake=0.06 * length,
        overhang=0.06 * length,
        sheer=(rise, 1.1 * rise),
        rocker=(0.6 * rise, 0.6 * rise),
        bilge=1.8,
    )
    parts = [
        hollow(hull, 0.065 * beam, 0.4),
        _stem(hull, 1.0, rng.uniform(0.09, 0.14) * length),
        _stem(hull, -1.0, rng.uniform(0.05, 0.09) * length),
    ]
    profile = [(0.055 * length, -0.004 * length), (0.05 * length, 0.004 * length), (0.01 * length, 0.012 * length)]
    shield = turned(lathe(profile, 12), 2, -np.pi / 2)
    if rng.random() < 0.75:
        for station in np.linspace(0.22, 0.78, int(rng.integers(5, 9))):
            x, y = hull.half(station, 0.96) + 0.003 * length, hull.deck(station) - 0.01 * length
            parts.append(both_sides(moved(shield, (x, y, hull.z(station)))))
    tall = length * rng.uniform(0.45, 0.62)
    z = hull.z(rng.uniform(0.5, 0.56))
    parts.append(mast((0.0, 0.3 * depth, z), tall, 0.012 * length))
    if rng.random() < 0.85:
        half = length * rng.uniform(0.2, 0.28)
        parts.append(square_sail(z, depth + 0.3 * tall, 0.95 * tall, half, rng.uniform(0.08, 0.18), 0.012 * length))
    if rng.random() < 0.6:
        for station in np.linspace(0.25, 0.72, int(rng.integers(3, 7))):
            x, z = hull.half(station), hull.z(station)
            loom, blade = (x - 0.02 * beam, hull.deck(station), z), (x + 0.16 * length, 0.1 * depth, z - 0.05 * length)
            parts.append(both_sides(tube([loom, blade], (0.004 * length, 0.008 * length), 6)))
    return joined(*parts)


def _stem(hull: Hull, way: float, height: float) -> Mesh:
    """The timber that rises from the bow, `way` 1, into a dragon's head, or from the stern, `way` -1."""
    z, y, unit = way * hull.length / 2, hull.deck(1.0 if way > 0 else 0.0), 0.01 * hull.length
    path = [
        (0.0, 0.6 * y, z - 3 * way * unit),
        (0.0, y, z),
        (0.0, y + 0.6 * height, z + 2 * way * unit),
        (0.0, y + height, z - way * unit),
    ]
    timber = tube(path, 1.4 * unit, 8)
    if way < 0:
        return timber
    snout = [(0.0, y + height, z - 2 * unit), (0.0, y + height - unit, z + 5 * unit)]
    return joined(timber, tube(snout, (2.4 * unit, 1.1 * unit), 8))


def make_tall_ship(rng: Generator) -> Mesh:
    """A square rigger: high stern, bowsprit, two or three masts full of sails."""
    length = rng.uniform(22.0, 70.0)
    beam, galleon = length * rng.uniform(0.2, 0.28), rng.random() < 0.55
    depth = beam * rng.uniform(0.55, 0.75)
    hull = Hull(
        length,
        beam,
        depth,
        bow=2.8,
        entry=2.0,
        transom=rng.uniform(0.55, 0.75),
        counter=0.12,
        widest=0.5,
        rake=length * rng.uniform(0.06, 0.12),
        overhang=length * rng.uniform(0.02, 0.06),
        sheer=(depth * rng.uniform(0.15, 0.45), depth * rng.uniform(0.15, 0.4)),
        rocker=(0.1 * depth, 0.05 * depth),
        bilge=2.4,
    )
    parts = [decked(hull, 0.12 * depth, 0.04 * beam)]
    if galleon:
        for top, high in ((0.34, 0.32), (0.2, 0.62)):
            parts.append(plate(hull, 1.0 + high, high * depth + 0.1 * depth, (0.0, top)))
        parts.append(plate(hull, 1.25, 0.35 * depth, (0.8, 0.99)))
    sprit, deck = 0.22 * length, hull.deck(1.0)
    way = [(0.0, deck - 0.05 * depth, hull.z(0.92)), (0.0, deck + 0.4 * sprit, length / 2 + sprit)]
    parts.append(tube(way, (0.014 * length, 0.007 * length), 8))
    count, tall = int(rng.integers(2, 4)), length * rng.uniform(0.62, 0.82)
    stations = (0.72, 0.46, 0.2)[:count] if count == 3 else (0.66, 0.34)
    belly, furled = rng.uniform(0.06, 0.16), rng.random() < 0.12
    for station, size in zip(stations, (0.92, 1.0, 0.8), strict=False):
        z, high = hull.z(station), size * tall
        parts.append(mast((0.0, 0.5 * depth, z), depth + high - 0.5 * depth, 0.009 * length))
        levels = depth + high * np.array([0.16, 0.5, 0.76, 0.96])
        for index, share in enumerate((0.2, 0.165, 0.125)):
            low, top = float(levels[index]) + 0.02 * high, float(levels[index + 1])
            half = share * size * length
            if furled:
                parts.append(tube([(-half, top, z), (half, top, z)], 0.009 * length, 6))
            else:
                parts.append(square_sail(z + 0.012 * length, low, top, half, belly, 0.008 * length))
    if not furled:
        z, end = hull.z(stations[0]), length / 2 + 0.85 * sprit
        luff = ((0.0, deck + 0.4 * sprit, end), (0.0, depth + 0.72 * tall, z + 0.04 * length))
        leech = ((0.0, deck + 0.3 * sprit, z + 0.12 * length), (0.0, depth + 0.68 * tall, z + 0.03 * length))
        parts.append(sail(luff, leech, 0.05, 0.008 * length))
    return joined(*parts)
