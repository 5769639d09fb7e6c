"""Aeroplanes that carry many or fly fast: airliners, business jets, transports, fighters."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.airplane_parts import (
    Knot,
    Station,
    body,
    canopy,
    fin,
    leg,
    nacelle,
    nozzle,
    propeller_pod,
    station_at,
    store,
    surface,
    tapered,
    with_winglet,
)
from trainer.data.shapes.solid import Mesh, both_sides, box, joined, moved


def _cabin(length: float, half: float, tall: float, nose: float, tail: float) -> list[Knot]:
    """The tube of an airliner: blunt nose, long tail cone that rises to its end."""
    front, end = length / 2, -length / 2
    return [
        (front, 0.06 * half, 0.06 * tall, -0.25 * tall),
        (front - 0.1 * nose, 0.42 * half, 0.4 * tall, -0.22 * tall),
        (front - 0.45 * nose, 0.84 * half, 0.82 * tall, -0.08 * tall),
        (front - nose, half, tall, 0.0),
        (front - 1.4 * nose, half, tall, 0.0),
        (end + 1.2 * tail, half, tall, 0.0),
        (end + tail, half, tall, 0.0),
        (end + 0.4 * tail, 0.62 * half, 0.62 * tall, 0.28 * tall),
        (end, 0.1 * half, 0.14 * tall, 0.6 * tall),
    ]


def _tail(rng: Generator, length: float, tall: float, high: bool, span: float) -> list[Mesh]:
    """Fin and tailplane of an airliner or transport."""
    end, height, sweep = -length / 2, length * rng.uniform(0.13, 0.18), rng.uniform(0.55, 0.8)
    chord = length * rng.uniform(0.13, 0.17)
    upright = fin((0.0, 0.45 * tall, end + 0.06 * length + chord), height, (chord, 0.42 * chord), sweep)
    root = (0.0, 0.4 * tall, end + 0.05 * length + 0.62 * chord)
    if high:
        _, y, z, _ = upright[-2]
        root = (0.0, y - 0.04 * height, z)
    chords = (0.62 * chord, 0.28 * chord)
    level = tapered(root, span, chords, rng.uniform(0.45, 0.65), rng.uniform(0.0, 0.12) * (not high))
    return [surface(upright, 0.12), both_sides(surface(level, 0.12))]


def _hung(wing: list[Station], x: float, radius: float, length: float) -> Mesh:
    """A jet engine on a pylon before and under the wing."""
    _, y, z, _ = station_at(wing, x)
    centre = (x, y - 1.2 * radius, z + 0.1 * length)
    pylon = box((0.22 * radius, 0.9 * radius, 0.75 * length), (x, y - 0.5 * radius, z - 0.28 * length))
    return joined(nacelle(centre, radius, length), pylon)


def _undercarriage(length: float, half: float, bottom: float, drop: float, bogies: int) -> Mesh:
    """A nose leg, and main legs of two wheels in a row each."""
    radius = 0.3 * drop
    parts = [leg((0.0, bottom + radius, 0.38 * length), (0.0, bottom - drop, 0.38 * length), 0.8 * radius, 0.1 * drop)]
    for row in range(bogies):
        z = -0.03 * length - 2.1 * radius * row
        x = 1.1 * half
        parts.append(both_sides(leg((x, bottom + 0.7 * half, z), (x, bottom - drop, z), radius, 0.14 * drop)))
    return joined(*parts)


def make_airliner(rng: Generator) -> Mesh:
    """A low wing with two or four engines under it."""
    length, four = rng.uniform(30.0, 72.0), rng.random() < 0.3
    half = length / rng.uniform(8.0, 11.8) / 2
    tall, reach = half * rng.uniform(1.0, 1.15), length * rng.uniform(0.4, 0.55)
    chord, sweep = length * rng.uniform(0.11, 0.145), rng.uniform(0.42, 0.68)
    root = (0.0, -0.55 * tall, length * rng.uniform(0.13, 0.2))
    wing = tapered(root, reach, (chord, chord * rng.uniform(0.25, 0.4)), sweep, rng.uniform(0.07, 0.13), 0.34)
    outline = with_winglet(wing, reach * rng.uniform(0.07, 0.13)) if rng.random() < 0.45 else wing
    parts = [body(_cabin(length, half, tall, half * rng.uniform(2.2, 3.2), half * rng.uniform(5.0, 7.0)))]
    parts += [both_sides(surface(outline, rng.uniform(0.12, 0.15), 0.015))]
    parts += _tail(rng, length, tall, high=False, span=reach * rng.uniform(0.34, 0.42))
    radius = half * (rng.uniform(0.38, 0.5) if four else rng.uniform(0.48, 0.72))
    for share in (0.36, 0.64) if four else (0.34,):
        parts.append(both_sides(_hung(wing, share * reach, radius, radius * rng.uniform(2.8, 4.0))))
    if rng.random() < 0.45:
        parts.append(_undercarriage(length, half, -tall, half * rng.uniform(0.7, 1.0), 2))
    if four and rng.random() < 0.4:
        hump = length * rng.uniform(0.2, 0.6)
        parts.append(canopy(length / 2 - 1.0 * half, hump, 0.82 * half, 0.75 * tall, 0.6 * tall, 0.25))
    return joined(*parts)


def make_rear_engined(rng: Generator) -> Mesh:
    """Business and regional jets: engines beside the tail, the tailplane on top of the fin."""
    length = rng.uniform(14.0, 40.0)
    half = length / rng.uniform(8.0, 11.8) / 2
    tall, reach = half * rng.uniform(1.0, 1.15), length * rng.uniform(0.38, 0.52)
    chord = length * rng.uniform(0.11, 0.15)
    root = (0.0, -0.6 * tall, length * rng.uniform(0.02, 0.1))
    wing = tapered(root, reach, (chord, 0.35 * chord), rng.uniform(0.2, 0.55), rng.uniform(0.03, 0.1), 0.3)
    outline = with_winglet(wing, 0.12 * reach) if rng.random() < 0.6 else wing
    radius = half * rng.uniform(0.5, 0.68)
    centre = (half + 1.05 * radius, 0.35 * tall, length * rng.uniform(-0.3, -0.22))
    pylon = box((half + radius, 0.25 * radius, 2.2 * radius), (half / 2 + radius / 2, centre[1], centre[2]))
    parts = [
        body(_cabin(length, half, tall, half * rng.uniform(2.6, 4.0), half * rng.uniform(5.0, 6.5))),
        both_sides(surface(outline, 0.13, 0.015)),
        *_tail(rng, length, tall, high=True, span=reach * rng.uniform(0.34, 0.42)),
        both_sides(joined(nacelle(centre, radius, radius * rng.uniform(3.4, 4.6)), pylon)),
    ]
    if rng.random() < 0.25:
        parts.append(nacelle((0.0, tall + 0.6 * radius, -0.3 * length), radius, 5.0 * radius))
    if rng.random() < 0.4:
        parts.append(_undercarriage(length, half, -tall, 0.9 * half, 1))
    return joined(*parts)


def make_transport(rng: Generator) -> Mesh:
    """A high wing with two or four jets or propellers, a deep body and a tail that sweeps up."""
    length = rng.uniform(20.0, 60.0)
    half = length / rng.uniform(7.0, 11.0) / 2
    tall, reach = half * rng.uniform(1.0, 1.2), length * rng.uniform(0.45, 0.68)
    jets, count = rng.random() < 0.45, int(rng.choice([1, 2]))
    sweep = rng.uniform(0.35, 0.5) if jets else rng.uniform(0.02, 0.1)
    chord = length * rng.uniform(0.1, 0.13)
    root = (0.0, 0.85 * tall, chord * (1.3 if jets else 0.6))
    chords = (chord, chord * rng.uniform(0.35, 0.6))
    wing = tapered(root, reach, chords, sweep, rng.uniform(-0.08, 0.02), 0.35 * jets)
    fairing = body([(root[2] + s, k * half, 0.5 * k * tall, 0.75 * tall) for s, k in _fairing(chord)])
    high = rng.random() < 0.7
    parts = [
        body(_cabin(length, half, tall, half * rng.uniform(1.6, 2.6), half * rng.uniform(5.5, 7.5)), 2.4),
        fairing,
        both_sides(surface(wing, rng.uniform(0.13, 0.16), 0.02)),
        *_tail(rng, length, tall, high, span=reach * rng.uniform(0.32, 0.42)),
    ]
    blades, phase = int(rng.integers(4, 7)), rng.uniform(0.0, 1.5)
    for share in (0.3, 0.56)[:count]:
        x = share * reach
        if jets:
            radius = half * (0.5 if count == 1 else 0.4)
            parts.append(both_sides(_hung(wing, x, radius, 3.2 * radius)))
            continue
        _, y, z, local = station_at(wing, x)
        radius = (0.3 if count == 2 else 0.36) * half
        pod = propeller_pod(x, y - 0.45 * radius, z + 0.7 * local, radius, 1.65 * local, blades, phase)
        parts.append(both_sides(pod))
    sizes = ((3.4, 0.15), (2.4, 0.8), (0.0, 1.0), (-2.0, 0.8), (-3.2, 0.12))
    sponson = body([(s * half, 0.24 * k * half, 0.34 * k * tall, -0.72 * tall) for s, k in sizes], 2.6, points=12)
    parts.append(both_sides(moved(sponson, (0.88 * half, 0.0, -0.02 * length))))
    if rng.random() < 0.4:
        parts.append(_undercarriage(length, 0.8 * half, -tall, 0.6 * half, 2))
    return joined(*parts)


def _fairing(chord: float) -> list[tuple[float, float]]:
    return [(0.6 * chord, 0.1), (0.3 * chord, 0.7), (-0.2 * chord, 0.9), (-1.0 * chord, 0.85), (-1.8 * chord, 0.1)]


def make_fighter(rng: Generator) -> Mesh:
    """A jet with trapezoidal wings, one or two fins, one or two engines."""
    length = rng.uniform(14.0, 20.0)
    twin, stealthy = rng.random() < 0.5, rng.random() < 0.3
    half = length * (rng.uniform(0.062, 0.085) if twin else rng.uniform(0.045, 0.06))
    tall, roundness = length * rng.uniform(0.04, 0.055), rng.uniform(2.0, 3.2)
    reach = length * rng.uniform(0.28, 0.4)
    spine = _fighter_body(length, half, tall)
    chord, sweep = length * rng.uniform(0.24, 0.32), rng.uniform(0.45, 0.85)
    root = (0.6 * half, 0.0, length * rng.uniform(0.02, 0.1))
    wing = tapered(root, reach - 0.6 * half, (chord, chord * rng.uniform(0.15, 0.35)), sweep, rng.uniform(-0.06, 0.03))
    aft, span = (0.7 * half, -0.1 * tall, -0.28 * length), reach * rng.uniform(0.42, 0.55)
    rear = tapered(aft, span, (0.16 * length, 0.06 * length), sweep, rng.uniform(-0.1, 0.0))
    height = length * rng.uniform(0.13, 0.19)
    lean = rng.uniform(0.3, 0.5) if stealthy else rng.choice([0.0, 1.0]) * rng.uniform(0.0, 0.35)
    fins = (0.2 * length, 0.07 * length)
    parts = [
        body(spine, roundness, 1, 14),
        canopy(0.33 * length, 0.24 * length, 0.45 * half if twin else 0.62 * half, 0.85 * tall, 0.7 * tall, 0.35),
        both_sides(surface(wing, 0.07)),
        both_sides(surface(rear, 0.07)),
    ]
    if twin:
        parts.append(both_sides(surface(fin((0.6 * half, 0.5 * tall, -0.17 * length), height, fins, 0.7, lean), 0.07)))
        parts.append(both_sides(nozzle((0.45 * half, 0.0, -0.5 * length), 0.42 * half, 0.12 * length)))
    else:
        parts.append(surface(fin((0.0, 0.5 * tall, -0.17 * length), 1.2 * height, fins, 0.8), 0.07))
        parts.append(nozzle((0.0, 0.0, -0.5 * length), 0.7 * half, 0.12 * length))
    intake = length * rng.uniform(0.3, 0.42)
    size = (0.42 * half, 1.3 * tall, intake)
    parts.append(both_sides(box(size, (0.8 * half, -0.1 * tall, 0.16 * length - intake / 2))))
    if rng.random() < 0.6:
        strake = [(0.5 * half, 0.1 * tall, 0.26 * length, 0.45 * length)]
        strake.append((half + 0.05 * length, 0.1 * tall, 0.02 * length, 0.2 * length))
        parts.append(both_sides(surface(strake, 0.03)))
    if rng.random() < 0.35:
        for share in (0.45, 0.7)[: int(rng.integers(1, 3))]:
            x, y, z, local = station_at(wing, share * reach)
            parts.append(both_sides(store((x, y, z - 0.45 * local), 0.13 * length, 0.008 * length)))
    return joined(*parts)


def _fighter_body(length: float, half: float, tall: float) -> list[Knot]:
    """Pointed nose, shoulders where the engines' ducts run, and a flat end."""
    return [
        (0.5 * length, 0.02 * half, 0.03 * tall, -0.1 * tall),
        (0.44 * length, 0.2 * half, 0.36 * tall, -0.08 * tall),
        (0.36 * length, 0.36 * half, 0.68 * tall, 0.0),
        (0.24 * length, 0.46 * half, 0.95 * tall, 0.0),
        (0.12 * length, 0.75 * half, tall, 0.0),
        (-0.05 * length, half, tall, 0.0),
        (-0.3 * length, half, 0.85 * tall, 0.0),
        (-0.42 * length, 0.9 * half, 0.7 * tall, 0.0),
    ]


def make_delta(rng: Generator) -> Mesh:
    """A fighter on a triangular wing, with or without small wings before it."""
    length = rng.uniform(13.0, 19.0)
    half, tall = length * rng.uniform(0.045, 0.06), length * rng.uniform(0.045, 0.055)
    reach, chord = length * rng.uniform(0.26, 0.34), length * rng.uniform(0.42, 0.52)
    root = (0.5 * half, -0.35 * tall, -0.42 * length + chord)
    sweep = float(np.arctan((0.9 * chord) / reach))
    wing = tapered(root, reach, (chord, 0.08 * chord), sweep, rng.uniform(-0.04, 0.04))
    height, chords = length * rng.uniform(0.17, 0.22), (0.26 * length, 0.07 * length)
    upright = fin((0.0, 0.5 * tall, -0.16 * length), height, chords, 0.85)
    parts = [
        body(_fighter_body(length, half, tall), rng.uniform(2.0, 2.8), 1, 14),
        canopy(0.35 * length, 0.2 * length, 0.6 * half, 0.8 * tall, 0.7 * tall, 0.35),
        both_sides(surface(wing, 0.055)),
        surface(upright, 0.06),
        nozzle((0.0, 0.0, -0.5 * length), 0.68 * half, 0.13 * length),
        both_sides(box((0.5 * half, 1.2 * tall, 0.3 * length), (0.75 * half, 0.0, 0.02 * length))),
    ]
    if rng.random() < 0.55:
        small = (0.12 * length, 0.03 * length)
        front = tapered((0.3 * half, 0.35 * tall, 0.3 * length), rng.uniform(0.1, 0.15) * length, small, 0.75)
        parts.append(both_sides(surface(front, 0.06)))
    return joined(*parts)
