"""Aeroplanes that most people would call unusual: two wings, two booms, no tail, or a hull to swim on."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.airplane_parts import (
    body,
    canopy,
    fin,
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


def make_biplane(rng: Generator) -> Mesh:
    """Two wings one above the other, struts between them, an open cockpit; rarely three wings."""
    length = rng.uniform(5.8, 8.2)
    half, triple = length * rng.uniform(0.055, 0.075), rng.random() < 0.15
    tall = 1.25 * half
    spine = [
        (0.44 * length, 0.9 * half, 0.75 * tall, 0.0),
        (0.36 * length, half, 0.95 * tall, 0.0),
        (0.05 * length, half, tall, 0.0),
        (-0.1 * length, 0.85 * half, 0.9 * tall, 0.0),
        (-0.5 * length, 0.12 * half, 0.25 * tall, 0.2 * tall),
    ]
    gap, stagger = length * rng.uniform(0.2, 0.26), length * rng.uniform(0.0, 0.08)
    reach, chord = length * rng.uniform(0.5, 0.66), length * rng.uniform(0.16, 0.2)
    low, z = -0.8 * tall, 0.2 * length
    levels = [(low, z), (low + gap, z + stagger)]
    if triple:
        levels = [(low, z), (low + 0.6 * gap, z + 0.5 * stagger), (low + 1.2 * gap, z + stagger)]
    sweep, shrink = rng.uniform(0.0, 0.08), rng.uniform(0.8, 1.0)
    parts = [
        body(spine, rng.uniform(2.2, 3.5)),
        *light_tail(rng, length, 0.2 * tall, reach * rng.uniform(0.34, 0.42)),
        propeller((0.0, 0.0, 0.45 * length), 0.15 * length, int(rng.integers(2, 4)), rng.uniform(0.0, 3.0)),
        fixed_gear(rng, length, half, -0.7 * tall),
        canopy(0.0, 0.09 * length, 0.5 * half, 0.5 * half, 0.9 * tall, 0.3),
    ]
    for index, (y, lead) in enumerate(levels):
        span = reach * (shrink if index == 0 else 1.0)
        wing = tapered((0.0, y, lead), span, (chord, 0.9 * chord), sweep, 0.02)
        parts.append(both_sides(surface(wing, 0.12, 0.03)))
    bottom, top = levels[0], levels[-1]
    for x, foot in ((0.72 * shrink * reach, bottom[0]), (1.2 * half, 0.0)):
        lean = float(np.tan(sweep)) * x
        for back in (0.2, 0.65):
            start = (x if foot else 0.6 * half, foot + 0.02 * x, bottom[1] - lean - back * chord)
            end = (x, top[0] + 0.02 * x, top[1] - lean - back * chord)
            parts.append(both_sides(tube([start, end], 0.008 * length, 6)))
    return joined(*parts)


def make_twin_boom(rng: Generator) -> Mesh:
    """A pod between two booms that carry the tail."""
    length, twin = rng.uniform(9.0, 12.5), rng.random() < 0.6
    half, out = length * rng.uniform(0.05, 0.065), length * rng.uniform(0.19, 0.25)
    tall, radius = 1.2 * half, length * rng.uniform(0.032, 0.042)
    reach, chord = length * rng.uniform(0.58, 0.72), length * rng.uniform(0.18, 0.23)
    wing = tapered((0.0, 0.0, 0.18 * length), reach, (chord, 0.5 * chord), 0.06, rng.uniform(0.02, 0.09))
    front = 0.38 * length if twin else 0.1 * length
    boom = body(
        [
            (front, 0.5 * radius, 0.6 * radius, 0.0),
            (front - 0.06 * length, radius, 1.2 * radius, 0.0),
            (-0.05 * length, 0.8 * radius, radius, 0.0),
            (-0.48 * length, 0.35 * radius, 0.5 * radius, 0.06 * length),
        ]
    )
    height, chords = length * rng.uniform(0.12, 0.16), (0.13 * length, 0.08 * length)
    upright = fin((out, 0.03 * length, -0.36 * length), height, chords, 0.4)
    level = tapered((0.0, 0.06 * length, -0.38 * length), out, (0.1 * length, 0.1 * length), 0.0)
    spine = [
        (0.42 * length, 0.2 * half, 0.2 * tall, -0.1 * tall),
        (0.36 * length, 0.7 * half, 0.6 * tall, -0.1 * tall),
        (0.18 * length, half, tall, 0.05 * tall),
        (0.0, 0.9 * half, 0.9 * tall, 0.0),
        (-0.16 * length, 0.35 * half, 0.4 * tall, 0.0),
    ]
    phase, blades = rng.uniform(0.0, 3.0), int(rng.integers(2, 5))
    parts = [
        body(spine, 2.3),
        canopy(0.3 * length, 0.22 * length, 0.7 * half, 0.8 * half, 0.7 * tall),
        both_sides(surface(wing, 0.15, 0.02)),
        both_sides(joined(moved(boom, (out, 0.0, 0.0)), surface(upright, 0.12), surface(level, 0.12))),
    ]
    if twin:
        parts.append(both_sides(propeller((out, 0.0, front), 0.14 * length, blades, phase)))
    else:
        parts += [propeller((0.0, 0.0, -0.16 * length), 0.12 * length, blades, phase, pusher=True)]
    return joined(*parts)


def make_canard(rng: Generator) -> Mesh:
    """The small wing in front, the swept one and the propeller behind."""
    length = rng.uniform(4.8, 6.2)
    half, reach = length * rng.uniform(0.075, 0.09), length * rng.uniform(0.7, 0.85)
    chord, sweep = length * rng.uniform(0.18, 0.24), rng.uniform(0.35, 0.5)
    wing = tapered((0.0, -0.2 * half, -0.1 * length), reach, (1.2 * chord, 0.5 * chord), sweep, 0.0)
    x, y, z, tip = wing[-2]
    upright = fin((x, y - 0.04 * length, z), length * rng.uniform(0.16, 0.22), (tip, 0.6 * tip), 0.5)
    span, chords = reach * rng.uniform(0.4, 0.5), (0.08 * length, 0.07 * length)
    front = tapered((0.0, 0.2 * half, 0.42 * length), span, chords, 0.0)
    spine = [
        (0.5 * length, 0.15 * half, 0.15 * half, 0.0),
        (0.4 * length, 0.6 * half, 0.6 * half, 0.0),
        (0.1 * length, half, 1.2 * half, 0.1 * half),
        (-0.2 * length, 0.9 * half, 1.1 * half, 0.2 * half),
        (-0.38 * length, 0.6 * half, 0.6 * half, 0.3 * half),
    ]
    blades, phase = int(rng.integers(2, 4)), rng.uniform(0.0, 3.0)
    top, foot = (0.5 * half, -0.3 * half, -0.16 * length), (1.8 * half, -2.2 * half, -0.18 * length)
    return joined(
        body(spine, 2.4),
        canopy(0.28 * length, 0.45 * length, 0.8 * half, 0.9 * half, 0.8 * half, 0.4),
        both_sides(joined(surface(wing, 0.14), surface(upright, 0.11), surface(front, 0.14))),
        propeller((0.0, 0.3 * half, -0.39 * length), 0.15 * length, blades, phase, pusher=True),
        leg((0.0, -0.3 * half, 0.36 * length), (0.0, -2.2 * half, 0.36 * length), 0.026 * length, 0.008 * length),
        both_sides(leg(top, foot, 0.03 * length, 0.009 * length)),
    )


def make_flying_boat(rng: Generator) -> Mesh:
    """A hull that swims, and engines high above the water on the wing."""
    length, pairs = rng.uniform(14.0, 28.0), int(rng.integers(1, 3))
    half = length * rng.uniform(0.055, 0.07)
    tall, reach, chord = 1.3 * half, length * rng.uniform(0.62, 0.78), length * rng.uniform(0.13, 0.17)
    level = tall * rng.uniform(1.2, 1.7)
    wing = tapered((0.0, level, 0.16 * length), reach, (chord, 0.55 * chord), 0.06, 0.03)
    spine = [
        (0.48 * length, 0.2 * half, 0.3 * tall, 0.25 * tall),
        (0.42 * length, 0.75 * half, 0.75 * tall, 0.1 * tall),
        (0.2 * length, half, tall, 0.0),
        (-0.05 * length, half, tall, 0.0),
        (-0.1 * length, 0.9 * half, 0.75 * tall, 0.25 * tall),
        (-0.3 * length, 0.55 * half, 0.5 * tall, 0.5 * tall),
        (-0.5 * length, 0.12 * half, 0.25 * tall, 0.75 * tall),
    ]
    parts = [
        body(spine, 2.8),
        box((0.9 * half, level, 0.9 * chord), (0.0, level / 2, 0.15 * length - 0.5 * chord), (0.7, 0.9)),
        both_sides(surface(wing, 0.15, 0.02)),
        *light_tail(rng, length, 0.7 * tall, reach * rng.uniform(0.3, 0.38)),
    ]
    blades, phase = int(rng.integers(3, 5)), rng.uniform(0.0, 2.0)
    for share in (0.2, 0.42)[:pairs]:
        x, y, z, local = station_at(wing, share * reach)
        parts.append(both_sides(propeller_pod(x, y, z + 0.45 * local, 0.033 * length, 1.3 * local, blades, phase)))
    x, y, z, _ = station_at(wing, 0.75 * reach)
    sizes = ((0.09, 0.15), (0.06, 0.8), (-0.02, 1.0), (-0.1, 0.15))
    low = -0.15 * tall
    small = body([(z + s * length, 0.018 * k * length, 0.022 * k * length, low) for s, k in sizes])
    strut = tube([(x, low, z - 0.02 * length), (x, y, z - 0.04 * length)], 0.008 * length, 6)
    parts.append(both_sides(joined(moved(small, (x, 0.0, 0.0)), strut)))
    return joined(*parts)


def make_supersonic(rng: Generator) -> Mesh:
    """An airliner as slender as a needle on an ogival wing."""
    length = rng.uniform(55.0, 66.0)
    half = length / rng.uniform(18.0, 22.0) / 2
    reach, chord, droop = length * rng.uniform(0.19, 0.24), length * rng.uniform(0.5, 0.58), rng.uniform(0.5, 1.5)
    end = -0.4 * length
    shares = np.array([0.05, 0.2, 0.4, 0.62, 0.85, 1.0])
    depth = chord * np.array([1.0, 0.72, 0.53, 0.36, 0.17, 0.05])
    wing = [
        (float(s * reach), -0.7 * half, float(end + c - 0.04 * chord * s), float(c))
        for s, c in zip(shares, depth, strict=True)
    ]
    knots = [
        (0.5 * length, 0.04 * half, 0.04 * half, -droop * half),
        (0.44 * length, 0.55 * half, 0.55 * half, -0.35 * half),
        (0.36 * length, half, half, 0.0),
        (-0.25 * length, half, half, 0.0),
        (-0.5 * length, 0.06 * half, 0.08 * half, 0.25 * half),
    ]
    upright = fin((0.0, 0.7 * half, -0.22 * length), 0.13 * length, (0.2 * length, 0.05 * length), 0.9)
    pod = box((1.7 * half, 0.8 * half, 0.2 * length), (0.45 * reach, -1.3 * half, end + 0.1 * length), (0.9, 0.96))
    return joined(body(knots), both_sides(surface(wing, 0.035)), surface(upright, 0.05), both_sides(pod))


def make_flying_wing(rng: Generator) -> Mesh:
    """A swept wing without a tail, thick in the middle."""
    reach, sweep = rng.uniform(15.0, 26.0), rng.uniform(0.4, 0.68)
    chord, outer = reach * rng.uniform(0.6, 0.8), reach * rng.uniform(0.13, 0.22)
    lead = float(np.tan(sweep))
    kink = rng.uniform(0.3, 0.5)
    sawtooth = rng.random() < 0.6
    inner = outer * (1.4 if sawtooth else 1.0) + (0.0 if sawtooth else 0.35 * (chord - outer))
    wing = [
        (0.0, 0.0, 0.0, chord),
        (0.14 * reach, 0.0, -0.14 * reach * lead, chord * 0.86 - 0.1 * reach * lead),
        (kink * reach, 0.0, -kink * reach * lead, inner),
        (0.94 * reach, 0.02 * reach, -0.94 * reach * lead, outer),
        (reach, 0.022 * reach, -reach * lead - 0.4 * outer, 0.3 * outer),
    ]
    peak, height = rng.uniform(0.06, 0.1) * reach, rng.uniform(0.05, 0.08) * reach
    parts = [
        both_sides(surface(wing, rng.uniform(0.11, 0.15))),
        canopy(-0.02 * chord, 0.8 * chord, peak, height + 0.05 * chord, 0.0, 0.35),
    ]
    x = 0.5 * kink * reach
    hump = canopy(-x * lead, 0.6 * chord, 0.7 * peak, 0.8 * height + 0.02 * chord, 0.0)
    parts.append(both_sides(moved(hump, (x, 0.0, 0.0))))
    if rng.random() < 0.35:
        upright = fin((0.92 * reach, 0.0, -0.92 * reach * lead), 0.13 * reach, (outer, 0.5 * outer), 0.5)
        parts.append(both_sides(surface(upright, 0.1)))
    return joined(*parts)
