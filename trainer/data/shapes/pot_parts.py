"""What grows in a pot. Each plant stands on the soil at y = 0 about the y axis and is about `size` metres tall or wide.

Leaves are closed slabs, thick enough to be seen in a small picture.
"""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, joined, lathe, loft, moved, tube, turned

_ALONG = np.linspace(0.0, 1.0, 6)
_TIP = 1.02 - 0.9 * _ALONG**4
# How broad and how thick a leaf is on its way from the stem to its tip.
_BREADTH = (0.25 + 0.75 * np.sin(np.pi * (0.1 + 0.85 * _ALONG))) * _TIP


def plant(rng: Generator) -> Callable[[Generator, float], Mesh]:
    """A kind of plant: what it returns draws one of a given size."""
    kinds = (bush, cactus, flowers, palm, rosette, swords, tree)
    return kinds[rng.integers(len(kinds))]


def leaf(length: float, width: float, thickness: float, rise: float, droop: float) -> Mesh:
    """A blade from the origin outwards along +z: it leaves at `rise` radians above the horizon and bends by `droop`."""
    angle = rise - droop * _ALONG
    step = length / (len(_ALONG) - 1) * np.ones_like(_ALONG)
    step[0] = 0.0
    sine, cosine = np.sin(angle), np.cos(angle)
    rings = np.zeros((len(_ALONG), 4, 3))
    rings[:, 0, 0] = width / 2 * _BREADTH
    rings[:, 2, 0] = -rings[:, 0, 0]
    rings[:, :, 1], rings[:, :, 2] = np.cumsum(step * sine)[:, None], np.cumsum(step * cosine)[:, None]
    half = thickness / 2 * _TIP
    up = half * cosine
    forward = -half * sine
    rings[:, 1, 1] += up
    rings[:, 1, 2] += forward
    rings[:, 3, 1] -= up
    rings[:, 3, 2] -= forward
    return loft(rings)


def rosette(rng: Generator, size: float) -> Mesh:
    """Blades that leave the soil in all directions: an agave, an aloe, a fern."""
    count, length = int(rng.integers(7, 14)), size * rng.uniform(0.8, 1.1)
    width, rise, droop = length * rng.uniform(0.12, 0.26), rng.uniform(0.7, 1.3), rng.uniform(0.0, 1.3)
    blades = []
    for index in range(count):
        inner = index % 2
        blade = leaf(length * rng.uniform(0.85, 1.0), width, 0.06 * length, rise + 0.25 * inner, droop)
        blades.append(turned(blade, 1, index * 2 * np.pi / count + rng.uniform(-0.1, 0.1)))
    return joined(moved(joined(*blades), (0.0, -0.05 * size, 0.0)), dome(0.2 * size, 0.2 * size))


def swords(rng: Generator, size: float) -> Mesh:
    """Stiff blades that stand almost upright: a snake plant."""
    count = int(rng.integers(4, 9))
    blades = []
    for index in range(count):
        length = size * rng.uniform(0.6, 1.0) if index else size
        blade = leaf(length, size * rng.uniform(0.12, 0.2), 0.05 * size, rng.uniform(1.2, 1.5), rng.uniform(-0.1, 0.2))
        blades.append(turned(moved(blade, (0.0, -0.05 * size, 0.03 * size)), 1, index * 2.4 + rng.uniform(-0.4, 0.4)))
    return joined(*blades)


def palm(rng: Generator, size: float) -> Mesh:
    """A bare stem with a crown of drooping fronds."""
    stem, bar = size * rng.uniform(0.4, 0.65), size * rng.uniform(0.025, 0.05)
    sway = rng.uniform(-0.08, 0.08) * size
    trunk = tube([(0.0, -0.1 * size, 0.0), (0.0, 0.5 * stem, 0.3 * sway), (0.0, stem, sway)], (bar, 0.7 * bar), 8)
    count, length = int(rng.integers(6, 12)), size * rng.uniform(0.4, 0.6)
    rise, droop = rng.uniform(0.6, 1.0), rng.uniform(1.2, 2.2)
    fronds = [
        turned(
            leaf(length, length * rng.uniform(0.2, 0.32), 0.07 * length, rise + 0.3 * (i % 2), droop),
            1,
            i * 2 * np.pi / count,
        )
        for i in range(count)
    ]
    return joined(trunk, moved(joined(*fronds), (0.0, stem - bar, sway)))


def cactus(rng: Generator, size: float) -> Mesh:
    """A ribbed column with a round head, at times with arms, or a ribbed ball."""
    if rng.random() < 0.3:
        radius = 0.42 * size
        heights = np.linspace(-0.6, 1.0, 10)
        return moved(
            _ribbed([(radius * np.sqrt(max(1.02 - h * h, 0.02)), radius * 0.95 * h) for h in heights], 10),
            (0.0, 0.5 * radius, 0.0),
        )
    radius = size * rng.uniform(0.1, 0.2)
    parts = [_ribbed([(0.85 * radius, -0.1 * size), (radius, 0.3 * size), *_head(radius, size)], 8)]
    for side in (1, -1):
        if rng.random() < 0.6:
            low, top = size * rng.uniform(0.25, 0.5), size * rng.uniform(0.65, 0.9)
            arm, out = 0.55 * radius, side * (radius + size * rng.uniform(0.12, 0.18))
            path = [
                (0.0, low, 0.0),
                (0.75 * out, low + 0.01 * size, 0.0),
                (out, low + 0.09 * size, 0.0),
                (out, top, 0.0),
                (out, top + 0.6 * arm, 0.0),
            ]
            parts.append(tube(path, (arm, arm, arm, arm, 0.45 * arm), 8))
    return joined(*parts)


def _head(radius: float, top: float) -> list[tuple[float, float]]:
    return [(radius * np.cos(a), top - radius + radius * np.sin(a)) for a in np.linspace(0.0, 1.35, 5)]


def _ribbed(profile: list[tuple[float, float]], ribs: int) -> Mesh:
    angles = np.arange(3 * ribs) * 2 * np.pi / (3 * ribs) + np.pi / (3 * ribs)
    relief = 1 + 0.1 * np.cos(ribs * (angles - np.pi / 2))
    rings = [
        np.stack((r * relief * np.cos(angles), np.full(len(angles), y), r * relief * np.sin(angles)), -1)
        for r, y in profile
    ]
    return loft(np.stack(rings))


def dome(radius: float, height: float) -> Mesh:
    """Half an ellipsoid on the soil."""
    return lathe(
        [(radius, -0.05 * height), *((radius * np.cos(a), height * np.sin(a)) for a in np.linspace(0.25, 1.4, 5))], 16
    )


def bush(rng: Generator, size: float) -> Mesh:
    """A lumpy round crown that sits on the rim."""
    return moved(crown(rng, 0.4 * size, rng.uniform(0.8, 1.2)), (0.0, 0.28 * size, 0.0))


def crown(rng: Generator, radius: float, tallness: float) -> Mesh:
    """A ball of foliage about the origin, lumpy."""
    latitude = np.linspace(-1.42, 1.42, 9)[:, None]
    angle = (np.arange(16) + 0.5) * 2 * np.pi / 16
    first, second = rng.uniform(0.0, 2 * np.pi, 2)
    lumps = 1 + 0.05 * np.sin(3 * angle + 2 * latitude + first) + 0.04 * np.sin(5 * angle - 3 * latitude + second)
    reach = radius * lumps * np.cos(latitude)
    y = np.broadcast_to(radius * tallness * np.sin(latitude), reach.shape)
    return loft(np.stack((reach * np.cos(angle), y, reach * np.sin(angle)), -1))


def tree(rng: Generator, size: float) -> Mesh:
    """A standard: a bare stem under one clipped ball, two of them, or a cone."""
    bar = size * rng.uniform(0.02, 0.04)
    match rng.integers(3):
        case 0:
            radius = size * rng.uniform(0.24, 0.34)
            tops = [moved(crown(rng, radius, 1.0), (0.0, size - radius, 0.0))]
        case 1:
            lower, upper = size * rng.uniform(0.2, 0.28), size * rng.uniform(0.13, 0.18)
            tops = [
                moved(crown(rng, lower, 0.85), (0.0, 0.42 * size, 0.0)),
                moved(crown(rng, upper, 0.9), (0.0, size - upper, 0.0)),
            ]
        case _:
            radius, foot, tiers = size * rng.uniform(0.2, 0.34), size * rng.uniform(0.02, 0.2), int(rng.integers(1, 5))
            cone = []
            for tier in range(tiers):
                low, high = (foot + (size - foot) * (tier + step) / tiers for step in (0.0, 1.0))
                wide, narrow = radius * (1 - 0.8 * tier / tiers), radius * (0.75 - 0.7 * (tier + 1) / tiers)
                cone += [(0.7 * wide, low), (wide, low + 0.08 * size / tiers), (narrow, high - 0.02 * size / tiers)]
            tops = [lathe(cone, 16)]
    return joined(tube([(0.0, -0.1 * size, 0.0), (0.0, 0.8 * size, 0.0)], bar, 8), *tops)


def flowers(rng: Generator, size: float) -> Mesh:
    """Stems with round heads above a tuft of leaves."""
    parts = [dome(0.28 * size, 0.3 * size)]
    for index in range(int(rng.integers(3, 7))):
        azimuth, tilt = index * 2.4 + rng.uniform(-0.3, 0.3), rng.uniform(0.08, 0.5)
        top = (
            size
            * rng.uniform(0.75, 1.0)
            * np.array([np.sin(tilt) * np.sin(azimuth), np.cos(tilt), np.sin(tilt) * np.cos(azimuth)])
        )
        head = size * rng.uniform(0.09, 0.14)
        parts.append(tube([(0.0, -0.05 * size, 0.0), 0.5 * top + (0.0, 0.06 * size, 0.0), top], 0.022 * size, 6))
        bloom = lathe(
            [(0.3 * head, -0.5 * head), (head, 0.0), (0.85 * head, 0.35 * head), (0.3 * head, 0.55 * head)], 12
        )
        parts.append(moved(turned(turned(bloom, 0, 0.8 * tilt), 1, azimuth), top))
    return joined(*parts)
