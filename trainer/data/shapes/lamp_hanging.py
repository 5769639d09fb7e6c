"""Lamps on ceilings and walls: pendants, clusters, bowls, bars over a table, chandeliers, and sconces."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.lamp_parts import HANGING, STANDING, Shade, ShadeStyle, foot, hanging, rotated, shade
from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, loft, moved, tube, turned


def _pendant_shade(rng: Generator) -> Shade:
    radius = rng.uniform(0.12, 0.32)
    return shade(rng, HANGING[rng.integers(len(HANGING))], radius, radius * rng.uniform(0.6, 2.0))


def make_pendant(rng: Generator) -> Mesh:
    """One shade on a cord or a rod below a ceiling plate."""
    cover, cord = _pendant_shade(rng), rng.uniform(0.08, 0.6)
    plate = turned(foot(rng, rng.uniform(0.05, 0.09), rng.uniform(0.025, 0.05)), 0, np.pi)
    parts = [plate, hanging(cover, cord, rng.uniform(0.008, 0.016))]
    if rng.random() < 0.3:
        cap = cover.radius * rng.uniform(0.12, 0.2)
        parts.append(lathe([(cap, -cord - 0.1 * cover.height), (0.8 * cap, 0.06 - cord)], 14))
    return joined(*parts)


def make_cluster(rng: Generator) -> Mesh:
    """Several shades at different heights, on cords that spread from one plate."""
    count, radius = int(rng.integers(3, 7)), rng.uniform(0.08, 0.13)
    reach = radius * rng.uniform(1.1, 1.6) / np.sin(np.pi / count)
    cover = shade(rng, HANGING[rng.integers(len(HANGING))], radius, radius * rng.uniform(1.0, 2.4), 12)
    parts = [lathe([(0.09, -0.04), (0.09, 0.0)], 20)]
    for angle in np.arange(count) * 2 * np.pi / count:
        drop = rng.uniform(0.12, 0.6)
        path = [(0.0, -0.02, 0.06), (0.0, -drop, reach), (0.0, cover.socket - cover.height - drop, reach)]
        shaded = joined(tube(path, 0.011, 6), moved(cover.mesh, (0.0, -drop - cover.height, reach)))
        parts.append(turned(shaded, 1, angle))
    return joined(*parts)


def make_flush(rng: Generator) -> Mesh:
    """A bowl, a drum or a box close under the ceiling, or a little below it on a rod."""
    radius, gap = rng.uniform(0.16, 0.3), rng.choice([0.0, 1.0]) * rng.uniform(0.05, 0.2)
    styles: tuple[ShadeStyle, ...] = ("bowl", "bowl", "drum", "square", "facets")
    cover = shade(rng, styles[rng.integers(5)], radius, radius * rng.uniform(0.35, 0.8))
    rim, low = radius * rng.uniform(0.3, 0.65), -0.03 - gap - cover.height
    rod = cylinder((0.0, -0.02, 0.0), (0.0, low + cover.socket, 0.0), 0.025, 8)
    return joined(lathe([(rim, -0.04), (rim, 0.0)], 20), rod, moved(cover.mesh, (0.0, low, 0.0)))


def make_linear(rng: Generator) -> Mesh:
    """A bar on two cords, a row of shades on such a bar, or a rail of spots under the ceiling."""
    length, cord = rng.uniform(0.7, 1.3), rng.uniform(0.15, 0.5)
    count, style = int(rng.integers(3, 6)), HANGING[rng.integers(len(HANGING))]
    places = np.linspace(-0.42, 0.42, count) * length
    radius, tall = rng.uniform(0.25, 0.42) * length / count, rng.uniform(0.3, 0.6) * length / count
    cover = shade(rng, style, radius, tall, 14)
    if rng.random() < 0.3:
        spot = hanging(cover, 0.07, 0.014)
        tilts = rng.uniform(-0.8, 0.0, count)
        spots = [moved(turned(spot, 0, tilt), (x, -0.03, 0.0)) for x, tilt in zip(places, tilts, strict=True)]
        return joined(box((length, 0.05, 0.08), (0.0, -0.025, 0.0)), *spots)
    thick, cords = (
        rng.uniform(0.04, 0.1),
        cylinder((0.3 * length, -0.02, 0.0), (0.3 * length, -cord - 0.02, 0.0), 0.01, 8),
    )
    bar = box((length, thick, rng.uniform(0.05, 0.14)), (0.0, -cord - thick / 2, 0.0))
    parts = [box((0.7 * length, 0.04, 0.09), (0.0, -0.02, 0.0)), both_sides(cords), bar]
    if rng.random() < 0.6:
        drop = moved(hanging(cover, rng.uniform(0.0, 0.1), 0.014), (0.0, -cord - 0.5 * thick, 0.0))
        parts += [moved(drop, (x, 0.0, 0.0)) for x in places]
    return joined(*parts)


def make_chandelier(rng: Generator) -> Mesh:
    """Curved arms around a turned stem, each with a candle or a shade; large ones have two tiers."""
    reach, high, drop = rng.uniform(0.28, 0.5), rng.uniform(0.3, 0.55), rng.uniform(0.15, 0.5)
    levels = np.array([0.0, 0.06, 0.14, 0.2, 0.34, 0.5, 0.62, 0.8, 1.0]) * high
    radii = reach * np.array([0.04, 0.13, 0.22, 0.1, 0.07, 0.15, 0.08, 0.11, 0.04]) * rng.uniform(0.8, 1.3, 9)
    parts = [
        lathe([(float(r), float(y)) for r, y in zip(radii, levels, strict=True)], 14),
        cylinder((0.0, 0.9 * high, 0.0), (0.0, high + drop, 0.0), rng.uniform(0.012, 0.022), 8),
        lathe([(0.06, high + drop - 0.05), (0.08, high + drop)], 14),
    ]
    tiers = 1 if rng.random() < 0.75 else 2
    sag, count = rng.uniform(0.05, 0.3) * high, int(rng.integers(4, 9 if tiers == 1 else 7))
    rise, bar = rng.uniform(0.1, 0.5) * high, rng.uniform(0.012, 0.02)
    light = _candle(rng, reach)
    for tier in range(tiers):
        out, base = reach * (1 - 0.4 * tier), (0.14 + 0.36 * tier) * high
        share = np.linspace(0.0, 1.0, 7)
        y = base - sag * np.sin(np.pi * share * 0.9) + rise * share**3
        arm = tube(np.stack((0 * share, y, out * share), -1), bar, 6)
        parts.append(rotated(joined(arm, moved(light, (0.0, float(y[-1]), out))), count, tier * np.pi / count))
    return joined(*parts)


def make_ring_chandelier(rng: Generator) -> Mesh:
    """A wheel on three rods, with candles, shades or globes on its rim."""
    reach, bar, rise = rng.uniform(0.28, 0.45), rng.uniform(0.02, 0.04), rng.uniform(0.25, 0.6)
    light, count = _candle(rng, reach), int(rng.integers(4, 9))
    angle = np.linspace(0.0, np.pi, 13)
    # Two halves, because a bar needs two ends.
    half = tube(np.stack((reach * np.cos(angle), 0 * angle, reach * np.sin(angle)), -1), bar, 8)
    rod = cylinder((0.0, 0.0, reach), (0.0, rise, 0.02), 0.012, 6)
    crown = lathe([(0.05, rise - 0.04), (0.07, rise + 0.02)], 14)
    return joined(rotated(half, 2), rotated(rod, 3), crown, rotated(moved(light, (0.0, bar, reach)), count, 0.4))


def _candle(rng: Generator, reach: float) -> Mesh:
    """What an arm's end carries: a pan, and on it a candle, a small shade or a globe, or a shade below it."""
    pan = lathe([(0.03, -0.02), (0.08 * reach + 0.02, 0.01), (0.08 * reach + 0.02, 0.025)], 10)
    match int(rng.integers(4)):
        case 0:
            return joined(pan, lathe([(0.018, 0.01), (0.018, 0.11), (0.026, 0.13), (0.016, 0.17), (0.004, 0.2)], 8))
        case 1:
            cover = shade(rng, "cone", reach * rng.uniform(0.17, 0.25), reach * rng.uniform(0.2, 0.35), 10)
            return joined(
                pan,
                cylinder((0.0, 0.0, 0.0), (0.0, 0.06 + cover.socket, 0.0), 0.016, 6),
                moved(cover.mesh, (0.0, 0.06, 0.0)),
            )
        case 2:
            ball = shade(rng, "globe", reach * rng.uniform(0.16, 0.25), reach * rng.uniform(0.32, 0.5), 8)
            return joined(pan, moved(ball.mesh, (0.0, 0.01, 0.0)))
        case _:
            bell = shade(rng, "bell", reach * rng.uniform(0.18, 0.28), reach * rng.uniform(0.2, 0.4), 8)
            return joined(pan, hanging(bell, 0.0, 0.02))


def make_sconce(rng: Generator) -> Mesh:
    """A plate on the wall at -Z, with one or two arms and shades, or a half bowl on it."""
    if rng.random() < 0.3:
        radius, high = rng.uniform(0.12, 0.2), rng.uniform(0.12, 0.26)
        angle = np.linspace(0.0, np.pi, 13)
        half = radius * np.stack((np.cos(angle), 0 * angle, np.sin(angle)), -1)
        levels = ((0.3, 0.0), (0.7, 0.35), (0.92, 0.75), (1.0, 1.0))
        bowl = loft(np.stack([half * size + (0.0, y * high, 0.0) for size, y in levels]))
        return joined(bowl, box((0.8 * radius, 0.7 * high, 0.03), (0.0, 0.55 * high, -0.01)))
    cover = shade(rng, STANDING[rng.integers(len(STANDING))], rng.uniform(0.06, 0.11), rng.uniform(0.1, 0.2))
    out, rise, drop = 1.5 * cover.radius + 0.03, rng.uniform(0.0, 0.06), rng.uniform(0.05, 0.12)
    sweep = [(0.0, 0.0, 0.0), (0.0, -drop, 0.5 * out), (0.0, -0.6 * drop, out), (0.0, rise + cover.socket, out)]
    arm = joined(tube(sweep, 0.012, 8), moved(cover.mesh, (0.0, rise, out)))
    plate = box((rng.uniform(0.07, 0.14), rng.uniform(0.12, 0.28), 0.03), (0.0, -0.02, 0.0))
    if rng.random() < 0.35:
        return joined(plate, turned(arm, 1, -0.8), turned(arm, 1, 0.8))
    return joined(plate, arm)
