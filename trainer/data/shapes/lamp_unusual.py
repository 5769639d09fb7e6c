"""Lamps that one meets less often: lanterns, sputniks, mushrooms, stacked balls, lava lamps, salt rocks and hoops."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.lamp_parts import STANDING, foot, lantern, rotated, shade
from trainer.data.shapes.solid import Mesh, box, cylinder, joined, lathe, loft, moved, tube, turned


def make_lantern(rng: Generator) -> Mesh:
    """A lantern to carry or to hang, with a bow from eaves to eaves or a ring on its roof."""
    radius = rng.uniform(0.1, 0.18)
    high, bar = radius * rng.uniform(2.2, 4.0), 0.08 * radius
    angle = np.linspace(0.0, np.pi, 11)
    bow, base = (0.75 * radius, 0.72 * high) if rng.random() < 0.6 else (0.3 * radius, 0.9 * high)
    crown = high + rng.uniform(0.2, 0.6) * radius - base
    path = np.stack((bow * np.cos(angle), base + crown * np.sin(angle), 0 * angle), -1)
    return joined(lantern(rng, radius, high), tube(path, bar, 6))


def make_sputnik(rng: Generator) -> Mesh:
    """Rods in all directions from a ball, each with a globe or a cone at its end, hung or on a stem."""
    core, reach, bulb = rng.uniform(0.06, 0.11), rng.uniform(0.28, 0.42), rng.uniform(0.04, 0.08)
    parts = [moved(shade(rng, "globe", core, 2 * core).mesh, (0.0, -core, 0.0))]
    ball = shade(rng, "globe", bulb, 2 * bulb, 8).mesh
    ray = joined(cylinder((0.0, 0.0, 0.0), (0.0, reach, 0.0), 0.014, 6), moved(ball, (0.0, reach - 0.2 * bulb, 0.0)))
    for tilt, fewest in ((0.9, 3), (1.75, 4), (2.5, 2)):
        parts.append(rotated(turned(ray, 0, tilt), int(rng.integers(fewest, fewest + 3)), tilt))
    if rng.random() < 0.6:
        rise = reach + rng.uniform(0.1, 0.4)
        parts += [cylinder((0.0, 0.0, 0.0), (0.0, rise, 0.0), 0.014, 8), lathe([(0.07, rise - 0.03), (0.07, rise)], 14)]
    else:
        fall = reach + bulb + rng.uniform(0.1, 0.8)
        parts.append(cylinder((0.0, 0.0, 0.0), (0.0, -fall, 0.0), 0.018, 8))
        parts.append(moved(foot(rng, rng.uniform(0.13, 0.2), 0.04), (0.0, -fall, 0.0)))
    return joined(*parts)


def make_mushroom(rng: Generator) -> Mesh:
    """A dome over a stout stem of the same glass."""
    radius, high = rng.uniform(0.14, 0.26), rng.uniform(0.22, 0.45)
    cap = shade(rng, "dome", radius, radius * rng.uniform(0.5, 1.0))
    stem, waist = radius * rng.uniform(0.35, 0.7), rng.uniform(0.5, 0.9)
    levels = np.linspace(0.0, 1.0, 6)
    radii = stem * (1 - (1 - waist) * np.sin(np.pi * levels) ** 0.8)
    trunk = lathe([(float(r), float(y * (high + cap.socket))) for r, y in zip(radii, levels, strict=True)], 18)
    return joined(trunk, moved(cap.mesh, (0.0, high, 0.0)))


def make_stack(rng: Generator) -> Mesh:
    """Balls, cubes or drums one upon another under a shade, or one luminous ball on a low foot."""
    size, y = rng.uniform(0.07, 0.11), 0.03
    if rng.random() < 0.3:
        return joined(foot(rng, 1.2 * size, 0.04), moved(shade(rng, "globe", 2 * size, 3.9 * size).mesh, (0.0, y, 0.0)))
    shrink, twist, kind = rng.uniform(0.8, 1.0), rng.uniform(0.0, 0.8), int(rng.integers(3))
    parts = [foot(rng, size, 0.04)]
    for index in range(int(rng.integers(2, 5))):
        radius = size * shrink**index
        match kind:
            case 0:
                block, tall = shade(rng, "globe", radius, 1.9 * radius, 16).mesh, 1.75 * radius
            case 1:
                cube = box((1.5 * radius, 1.5 * radius, 1.5 * radius), (0.0, 0.75 * radius, 0.0))
                block, tall = turned(cube, 1, twist * index), 1.48 * radius
            case _:
                edge = 0.8 * radius
                block = lathe([(edge, 0.0), (radius, 0.12 * radius), (radius, 0.7 * radius), (edge, 0.82 * radius)], 18)
                tall = 0.8 * radius
        parts.append(moved(block, (0.0, y, 0.0)))
        y += tall
    cover = shade(
        rng, STANDING[rng.integers(len(STANDING))], size * rng.uniform(1.4, 2.2), size * rng.uniform(1.8, 3.0)
    )
    stem = cylinder((0.0, y - 0.03, 0.0), (0.0, y + 0.03 + cover.socket, 0.0), 0.015, 8)
    return joined(*parts, stem, moved(cover.mesh, (0.0, y + 0.03, 0.0)))


def make_lava(rng: Generator) -> Mesh:
    """A glass spindle between a cone to stand on and a cap."""
    high, radius, waist = rng.uniform(0.35, 0.75), rng.uniform(0.06, 0.11), rng.uniform(0.25, 0.4)
    base = [(radius, 0.0), (0.6 * radius, waist * high * 0.55), (0.95 * radius, waist * high)]
    glass = [(1.05 * radius, waist * high + 0.01), (0.9 * radius, 0.6 * high), (0.55 * radius, 0.85 * high)]
    return joined(lathe([*base, *glass, (0.6 * radius, 0.86 * high), (0.45 * radius, high)], 18))


def make_rock(rng: Generator) -> Mesh:
    """A lump of salt on a wooden plate."""
    radius, high, sides = rng.uniform(0.08, 0.14), rng.uniform(0.16, 0.34), 11
    levels = np.linspace(0.0, 1.0, 6)
    girth = radius * np.array([0.9, 1.05, 1.0, 0.85, 0.6, 0.25])
    angle = np.arange(sides) * 2 * np.pi / sides
    rough = girth[:, None] * rng.uniform(0.82, 1.12, (6, sides))
    rings = [
        np.stack((r * np.cos(angle), np.full(sides, 0.03 + y * high), r * np.sin(angle)), -1)
        for r, y in zip(rough, levels, strict=True)
    ]
    return joined(lathe([(1.1 * radius, 0.0), (1.1 * radius, 0.04)], 16), loft(np.stack(rings)))


def make_hoop(rng: Generator) -> Mesh:
    """An open ring on edge, on a foot, at times with a globe in it."""
    radius, bar = rng.uniform(0.14, 0.3), rng.uniform(0.018, 0.035)
    gap = rng.uniform(0.0, 0.6)
    angle = np.linspace(gap, 2 * np.pi - gap - 0.02, 25) - np.pi / 2
    centre = radius + 0.04
    hoop = tube(np.stack((radius * np.cos(angle), centre + radius * np.sin(angle), 0 * angle), -1), bar, 8)
    parts = [hoop, foot(rng, 0.6 * radius, 0.04)]
    if gap > 0.05:
        side = radius * np.sin(gap)
        parts.append(box((2 * side + 2 * bar, 0.05, 2.4 * bar), (0.0, centre - radius * np.cos(gap), 0.0)))
        parts.append(cylinder((0.0, 0.0, 0.0), (0.0, centre - radius * np.cos(gap), 0.0), bar, 8))
    if rng.random() < 0.5:
        ball = shade(rng, "globe", 0.4 * radius, 0.8 * radius)
        hang = 2 * radius + 0.04
        parts.append(cylinder((0.0, hang, 0.0), (0.0, centre, 0.0), 0.35 * bar, 6))
        parts.append(moved(ball.mesh, (0.0, centre - 0.4 * radius, 0.0)))
    return joined(*parts)
