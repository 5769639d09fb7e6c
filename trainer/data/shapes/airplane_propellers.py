"""Aeroplanes that fly slowly: light ones, warbirds, twins, gliders."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.airplane_parts import (
    Knot,
    body,
    canopy,
    elliptical,
    fixed_gear,
    leg,
    light_tail,
    propeller,
    propeller_pod,
    station_at,
    surface,
    tapered,
)
from trainer.data.shapes.solid import Mesh, both_sides, box, joined, moved, tube


def make_light(rng: Generator) -> Mesh:
    """One engine, one wing above or below the cabin, on fixed wheels or, rarely, on floats."""
    length, high = rng.uniform(6.6, 9.0), rng.random() < 0.55
    half, tall = length * rng.uniform(0.07, 0.092), length * rng.uniform(0.085, 0.115)
    reach, chord = length * rng.uniform(0.55, 0.72), length * rng.uniform(0.17, 0.22)
    roof, disc = (0.9 if high else 1.0) * tall, length * rng.uniform(0.11, 0.13)
    spine = [
        (0.46 * length, 0.5 * half, 0.4 * tall, -0.1 * tall),
        (0.42 * length, 0.72 * half, 0.5 * tall, -0.15 * tall),
        (0.24 * length, 0.94 * half, 0.58 * tall, -0.18 * tall),
        (0.2 * length, half, 0.62 * tall, -0.16 * tall),
        (0.06 * length, half, roof, 0.1 * tall),
        (-0.12 * length, 0.94 * half, roof * 0.9, 0.12 * tall),
        (-0.26 * length, 0.5 * half, 0.5 * tall, 0.1 * tall),
        (-0.5 * length, 0.1 * half, 0.16 * tall, 0.2 * tall),
    ]
    level = 0.98 * tall if high else -0.5 * tall
    dihedral = rng.uniform(0.0, 0.04) if high else rng.uniform(0.07, 0.13)
    tip = chord * rng.choice([1.0, rng.uniform(0.5, 0.9)])
    wing = tapered((0.0, level, 0.16 * length), reach, (chord, tip), rng.uniform(0.0, 0.06), dihedral)
    parts = [
        body(spine, rng.uniform(2.4, 4.5), steps=0),
        both_sides(surface(wing, rng.uniform(0.13, 0.17), 0.025)),
        *light_tail(rng, length, 0.2 * tall, reach * rng.uniform(0.3, 0.37), t_tail=rng.random() < 0.12),
        propeller((0.0, -0.1 * tall, 0.47 * length), disc, int(rng.integers(2, 4)), rng.uniform(0.0, 3.0)),
    ]
    if high and rng.random() < 0.75:
        x, y, z, _ = station_at(wing, rng.uniform(0.45, 0.6) * reach)
        strut = tube([(0.8 * half, -0.5 * tall, 0.1 * length), (x, y, z - 0.3 * chord)], 0.014 * length, 8)
        parts.append(both_sides(strut))
    low = -0.75 * tall
    if high and rng.random() < 0.2:
        parts.append(both_sides(_float(length, 1.5 * half, low)))
    else:
        parts.append(fixed_gear(rng, length, half, low))
    return joined(*parts)


def _float(length: float, x: float, low: float) -> Mesh:
    """One of two floats, with its struts."""
    y, sizes = (
        low / length - 0.1,
        ((0.42, 0.1, 0.35), (0.36, 0.8, 0.15), (0.1, 1.0, 0.0), (-0.3, 0.6, 0.1), (-0.42, 0.1, 0.3)),
    )
    hull = body(np.array([(s, 0.04 * k, 0.045 * k, y + 0.1 * r) for s, k, r in sizes]) * length, 3.0)
    top = (0.6 * x, low + 0.1 * length, 0.0)
    strut = tube([(x, y * length, 0.0), top], 0.009 * length, 6)
    return joined(moved(hull, (x, 0.0, 0.0)), *(moved(strut, (0.0, 0.0, z * length)) for z in (0.22, -0.08)))


def make_warbird(rng: Generator) -> Mesh:
    """A fighter of the forties, in flight or on its tail wheel."""
    length, radial = rng.uniform(8.5, 11.0), rng.random() < 0.45
    half = length * (rng.uniform(0.065, 0.095) if radial else rng.uniform(0.048, 0.058))
    tall = half * (1.05 if radial else 1.45)
    nose = (0.85, 0.95) if radial else (0.5, 0.45)
    spine = [
        (0.44 * length, nose[0] * half, nose[1] * tall, 0.0),
        (0.4 * length, max(nose[0], 0.75) * half, max(nose[1], 0.65) * tall, 0.0),
        (0.18 * length, half, tall, 0.0),
        (-0.05 * length, 0.95 * half, 0.95 * tall, 0.05 * tall),
        (-0.3 * length, 0.5 * half, 0.6 * tall, 0.2 * tall),
        (-0.5 * length, 0.08 * half, 0.2 * tall, 0.35 * tall),
    ]
    reach, chord = length * rng.uniform(0.52, 0.64), length * rng.uniform(0.24, 0.29)
    root = (0.0, -0.6 * tall, 0.18 * length)
    dihedral, disc = rng.uniform(0.06, 0.11), length * rng.uniform(0.15, 0.18)
    wing = tapered(root, reach, (chord, 0.5 * chord), rng.uniform(0.03, 0.12), dihedral)
    if rng.random() < 0.4:
        wing = elliptical(root, reach, chord, dihedral)
    parts = [
        body(spine),
        canopy(0.1 * length, length * rng.uniform(0.18, 0.34), 0.6 * half, 0.85 * half, 0.75 * tall, 0.35),
        both_sides(surface(wing, 0.14, 0.02)),
        *light_tail(rng, length, 0.45 * tall, reach * rng.uniform(0.32, 0.4)),
        propeller((0.0, 0.0, 0.44 * length), disc, int(rng.integers(3, 5)), rng.uniform(0.0, 2.0)),
    ]
    if rng.random() < 0.45:
        parts.append(box((0.9 * half, 0.5 * tall, 0.16 * length), (0.0, -tall, -0.02 * length), (1.2, 1.4)))
    if rng.random() < 0.5:
        x, _, z, local = station_at(wing, 0.27 * reach)
        low = -tall - 0.14 * length
        main = leg((x, root[1], z - 0.15 * local), (x, low, z), 0.036 * length, 0.01 * length)
        top, foot = (0.0, 0.2 * tall, -0.42 * length), (0.0, -0.45 * tall, -0.44 * length)
        parts += [both_sides(main), leg(top, foot, 0.014 * length, 0.006 * length)]
    return joined(*parts)


def _cabin(length: float, half: float, tall: float) -> list[Knot]:
    """A body without an engine in its nose."""
    return [
        (0.5 * length, 0.1 * half, 0.1 * tall, -0.3 * tall),
        (0.46 * length, 0.45 * half, 0.4 * tall, -0.25 * tall),
        (0.36 * length, 0.8 * half, 0.68 * tall, -0.15 * tall),
        (0.26 * length, half, tall, 0.0),
        (-0.15 * length, half, tall, 0.0),
        (-0.32 * length, 0.65 * half, 0.66 * tall, 0.2 * tall),
        (-0.5 * length, 0.1 * half, 0.15 * tall, 0.4 * tall),
    ]


def make_twin(rng: Generator) -> Mesh:
    """Two propellers on the wing: business turboprops, old airliners."""
    length, high = rng.uniform(9.0, 20.0), rng.random() < 0.2
    half = length * rng.uniform(0.055, 0.075)
    tall, reach = half * rng.uniform(1.0, 1.15), length * rng.uniform(0.5, 0.68)
    chord = length * rng.uniform(0.14, 0.18)
    root = (0.0, 0.9 * tall if high else -0.6 * tall, length * rng.uniform(0.08, 0.14))
    chords, dihedral = (chord, chord * rng.uniform(0.4, 0.6)), 0.02 if high else rng.uniform(0.06, 0.12)
    wing = tapered(root, reach, chords, rng.uniform(0.03, 0.15), dihedral)
    x, y, z, local = station_at(wing, reach * rng.uniform(0.27, 0.34))
    radius = length * rng.uniform(0.034, 0.046)
    engine = propeller_pod(x, y, z + 0.75 * local, radius, 1.75 * local, int(rng.integers(2, 5)), rng.uniform(0.0, 3.0))
    parts = [
        body(_cabin(length, half, tall), rng.uniform(2.0, 2.6)),
        both_sides(surface(wing, 0.15, 0.02)),
        both_sides(engine),
        *light_tail(rng, length, 0.4 * tall, reach * rng.uniform(0.32, 0.4), t_tail=rng.random() < 0.35),
    ]
    if rng.random() < 0.5:
        ground = -tall - 0.07 * length
        parts.append(both_sides(leg((x, y, z), (x, ground, z - 0.2 * local), 0.03 * length, 0.009 * length)))
        top, foot = (0.0, -0.5 * tall, 0.36 * length), (0.0, ground, 0.37 * length)
        parts.append(leg(top, foot, 0.024 * length, 0.008 * length))
    return joined(*parts)


def make_glider(rng: Generator) -> Mesh:
    """Long narrow wings, a slim body, mostly a T-tail."""
    length = rng.uniform(6.2, 8.5)
    half, reach = length * rng.uniform(0.054, 0.066), length * rng.uniform(0.8, 1.15)
    tall, chord = 1.35 * half, length * rng.uniform(0.13, 0.16)
    spine = [
        (0.5 * length, 0.08 * half, 0.08 * tall, -0.2 * tall),
        (0.45 * length, 0.6 * half, 0.5 * tall, -0.15 * tall),
        (0.3 * length, half, 0.95 * tall, 0.0),
        (0.12 * length, 0.9 * half, 0.95 * tall, 0.05 * tall),
        (-0.05 * length, 0.42 * half, 0.42 * tall, 0.25 * tall),
        (-0.5 * length, 0.25 * half, 0.24 * tall, 0.3 * tall),
    ]
    root = (0.0, 0.6 * tall, 0.14 * length)
    wing = tapered(root, reach, (chord, 0.5 * chord), rng.uniform(0.0, 0.05), rng.uniform(0.03, 0.09))
    if rng.random() < 0.5:
        x, y, z, tip = wing[-2]
        wing = [*wing[:-1], (x + 0.05 * reach, y + 0.05 * reach, z - 0.3 * tip, 0.4 * tip)]
    return joined(
        body(spine),
        canopy(0.45 * length, 0.3 * length, 0.78 * half, 0.85 * tall, 0.22 * tall, 0.5),
        both_sides(surface(wing, 0.16, 0.025)),
        *light_tail(rng, length, 0.3 * tall, length * rng.uniform(0.17, 0.22), t_tail=rng.random() < 0.75),
    )
