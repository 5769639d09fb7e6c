"""Freighters: container ships, tankers, bulk and gas carriers, coasters."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, moved, tube, turned
from trainer.data.shapes.vessel_hull import Hull, decked, plate
from trainer.data.shapes.vessel_parts import crane, funnel, house, mast, storeys


def _freighter(rng: Generator, length: float) -> Hull:
    beam = length / rng.uniform(5.8, 7.6)
    depth = beam * rng.uniform(0.5, 0.72)
    return Hull(
        length,
        beam,
        depth,
        bow=rng.uniform(5.0, 9.0),
        entry=rng.uniform(3.5, 5.5),
        transom=rng.uniform(0.7, 0.92),
        counter=0.15,
        widest=0.45,
        rake=length * rng.uniform(0.02, 0.05),
        overhang=length * rng.uniform(0.02, 0.05),
        sheer=(0.0, depth * rng.uniform(0.05, 0.3)),
        rocker=(0.0, 0.0),
        bilge=rng.uniform(5.0, 9.0),
    )


def _bridge(rng: Generator, hull: Hull, z: float, floors: int) -> Mesh:
    """The deckhouse of a freighter, with wings at the bridge, a mast and a funnel behind."""
    storey, half = 0.1 * hull.beam, 0.43 * hull.beam
    deep = hull.length * rng.uniform(0.045, 0.07)
    base, top = hull.deck(0.5) - 0.02 * hull.beam, hull.deck(0.5) + (floors + 1) * storey
    back, tall = z - deep / 2 - 0.035 * hull.length, 0.55 * floors * storey
    return joined(
        storeys(floors, base, storey, (z - deep / 2, z + deep / 2), half, (0.0, 0.0), 0.0),
        house(top - 1.1 * storey, 0.9 * storey, (z - 0.2 * deep, z + 0.56 * deep), 1.1 * half, (0.0, 0.05 * deep)),
        mast((0.0, top - 0.3 * storey, z), 2.2 * storey, 0.018 * hull.beam),
        house(base, tall + storey, (back - 0.02 * hull.length, z), 0.55 * half),
        funnel(back, base + 0.9 * tall, tall + 1.2 * storey, 0.12 * hull.beam, 0.02 * hull.length),
    )


def _bulb(hull: Hull) -> Mesh:
    """The bulb under the bow."""
    radius = 0.11 * hull.beam
    profile = [(k * radius, s * radius) for k, s in ((0.6, -3.0), (1.0, -1.0), (0.9, 0.6), (0.3, 1.6))]
    place = (0.0, 1.05 * radius, hull.length / 2 - hull.rake - 0.8 * radius)
    return moved(turned(lathe(profile, 12), 0, np.pi / 2), place)


def make_container_ship(rng: Generator) -> Mesh:
    """Stacks of containers in rows, uneven, before and behind the bridge."""
    hull = _freighter(rng, rng.uniform(90.0, 380.0))
    slim = hull._replace(bow=rng.uniform(2.8, 4.0), entry=1.9)
    stern, forward = rng.uniform(0.12, 0.3), rng.uniform(0.88, 0.92)
    floors, tier = int(rng.integers(5, 9)), 0.075 * hull.beam
    parts = [decked(slim), _bridge(rng, slim, hull.z(stern), floors), _bulb(hull)]
    bays = int(rng.integers(6, 13))
    edges = np.linspace(0.03, forward, bays + 1)
    pitch = edges[1] - edges[0]
    highest = rng.uniform(3.0, floors - 1.0)
    for start in edges[:-1]:
        if start < stern + 0.045 and start + pitch > stern - 0.085:
            continue
        tiers = round(rng.uniform(0.55, 1.0) * highest) * tier
        half = min(0.96 * slim.half(start + pitch), 0.47 * hull.beam, 0.98 * slim.half(start))
        base = slim.deck(start) - 0.2 * tier
        span = (hull.z(start) + 0.05 * pitch * hull.length, hull.z(start + pitch) - 0.05 * pitch * hull.length)
        if rng.random() < 0.4:
            parts.append(house(base, tiers - tier, span, half))
            parts.append(house(base, tiers, span, half * rng.uniform(0.4, 0.8)))
        else:
            parts.append(house(base, tiers, span, half))
    parts.append(mast((0.0, slim.deck(0.9), hull.z(0.95)), 0.45 * hull.beam, 0.015 * hull.beam))
    return joined(*parts)


def make_freighter(rng: Generator) -> Mesh:
    """A tanker, bulk carrier, gas carrier or a coaster with cranes; the bridge stands aft, rarely amidships."""
    hull = _freighter(rng, rng.uniform(60.0, 330.0))
    stern = 0.5 if rng.random() < 0.12 else rng.uniform(0.1, 0.16)
    parts = [
        decked(hull, 0.02 * hull.depth, 0.01 * hull.beam),
        _bridge(rng, hull, hull.z(stern), int(rng.integers(3, 6))),
        _bulb(hull),
        plate(hull, 1.1, 0.2 * hull.depth, (0.91, 1.0)),
    ]
    first, last, base = 0.22, 0.9, hull.deck(0.5)
    stations = np.linspace(first, last, int(rng.integers(4, 8)) + 1)
    pitch = (stations[1] - stations[0]) * hull.length
    clear = [s for s in (stations[:-1] + stations[1:]) / 2 if abs(s - stern) > 0.12]
    match int(rng.integers(0, 4)):
        case 0:
            span = (hull.z(first), hull.z(last))
            for x in (0.0, 0.12, -0.12):
                parts.append(tube([(x * hull.beam, base + 0.03 * hull.beam, z) for z in span], 0.025 * hull.beam, 6))
            middle = hull.z(0.52)
            size = (0.8 * hull.beam, 0.07 * hull.beam, 0.04 * hull.length)
            parts.append(box(size, (0.0, base + 0.03 * hull.beam, middle)))
            hose = crane(0.16 * hull.beam, middle, base, 0.22 * hull.beam, 0.2 * hull.beam, 0.025 * hull.beam)
            parts.append(both_sides(hose))
        case 1:
            radius = min(0.4 * pitch, 0.36 * hull.beam)
            angles = np.linspace(-0.3, 0.46, 8) * np.pi
            dome = lathe([(float(np.cos(a)) * radius, float(np.sin(a)) * radius) for a in angles], 16)
            parts += [moved(dome, (0.0, base + 0.2 * radius, hull.z(s))) for s in clear]
        case hatches:
            high = 0.12 * hull.beam
            for s in clear:
                span = (hull.z(s) - 0.36 * pitch, hull.z(s) + 0.36 * pitch)
                parts.append(house(base - 0.1 * high, high, span, 0.33 * hull.beam))
            if hatches == 3:
                for s in clear[::2]:
                    z, jib = hull.z(s) + 0.47 * pitch, rng.choice([-0.8, 0.8]) * pitch
                    parts.append(crane(0.0, z, base, 0.5 * hull.beam, jib, 0.045 * hull.beam))
    parts.append(mast((0.0, hull.deck(0.95), hull.z(0.95)), 0.4 * hull.beam, 0.015 * hull.beam))
    return joined(*parts)
