"""Pots: flower pots and planters, empty or planted, and cooking pots; about one in eight is unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.jar_parts import ROUND, Form, Profile, handle, hollow, lid, radius_at, smooth, solid, straight
from trainer.data.shapes.pot_parts import plant
from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, moved, tube, turned


def make_pot(rng: Generator) -> Mesh:
    """One pot, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.30, _flower_pot),
        (0.15, _square_planter),
        (0.12, _trough),
        (0.10, _round_bellied),
        (0.12, _cooking_pot),
        (0.06, _saucepan),
        (0.04, _cauldron),
        (0.04, _on_a_stand),
        (0.03, _strawberry_pot),
        (0.04, _tiered),
    )
    shares = np.array([share for share, _ in builders])
    return builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)


def _filled(
    rng: Generator, profile: Profile, wall: float, planted: float, form: Form = ROUND, most: float = 2.0
) -> Mesh:
    """The pot with a plant in a share `planted` of cases, otherwise empty or filled with bare soil.

    The plant is at `most` that many times as large as the mean of the pot's height and width.
    """
    width, height = 2 * profile[:, 0].max() * np.sqrt(form.depth), profile[-1, 1]
    with_plant = rng.random() < planted
    soil = height * rng.uniform(0.8, 0.93) if with_plant or rng.random() < 0.25 else 0.0
    pot = hollow(profile, wall, form, soil)
    if not with_plant:
        return pot
    grown = plant(rng)(rng, rng.uniform(0.5, most) * (width + height) / 2)
    return joined(pot, moved(grown, (0.0, soil, 0.0)))


def _flower_pot(rng: Generator) -> Mesh:
    """A cone or cylinder of clay, with or without a collar and a saucer."""
    height = rng.uniform(0.1, 0.45)
    radius = height * rng.uniform(0.32, 0.75)
    foot, wall = radius * rng.uniform(0.55, 1.0), radius * rng.uniform(0.09, 0.14)
    if rng.random() < 0.5:
        collar, step = height * rng.uniform(0.68, 0.84), rng.uniform(0.08, 0.15) * radius
        below = foot + (radius - foot) * collar / height
        points = [(foot, 0.0), (below, collar), (below + step, collar + 0.01 * height)]
        profile = straight([*points, (radius + step, height)])
    elif rng.random() < 0.5:
        profile = straight([(0.93 * foot, 0.0), (foot, 0.06 * height), (radius, height)])
    else:
        belly = (rng.uniform(0.92, 1.12) * radius, rng.uniform(0.45, 0.7) * height)
        profile = smooth([(foot, 0.0), belly, (radius, height)])
    form = Form(int(rng.choice([6, 8]))) if rng.random() < 0.12 else ROUND
    parts = [_filled(rng, profile, wall, 0.6, form)]
    if rng.random() < 0.35:
        reach = foot * rng.uniform(1.2, 1.45)
        parts.append(hollow(straight([(0.9 * reach, 0.0), (reach, rng.uniform(0.08, 0.14) * height)]), 0.07 * reach))
    return joined(*parts)


def _square_planter(rng: Generator) -> Mesh:
    """A box or an upturned obelisk, at times with a rim or on feet."""
    width = rng.uniform(0.2, 0.6)
    height, foot = width * rng.uniform(0.6, 2.2), 0.5 * width * rng.uniform(0.6, 1.0)
    points = [(foot, 0.0), (0.5 * width, height)]
    if rng.random() < 0.3:
        edge = 0.5 * width + rng.uniform(0.03, 0.06) * width
        points += [(edge, 1.005 * height), (edge, height + rng.uniform(0.08, 0.15) * width)]
    form = Form(4, 40.0) if rng.random() < 0.75 else Form(24, rng.uniform(4.0, 8.0))
    planter = _filled(rng, straight(points), rng.uniform(0.05, 0.08) * width, 0.6, form, 1.6)
    if rng.random() < 0.3:
        return _on_feet(planter, 0.75 * foot, 0.75 * foot, rng.uniform(0.08, 0.2) * width, 0.07 * width)
    return planter


def _on_feet(planter: Mesh, x: float, z: float, height: float, bar: float) -> Mesh:
    """The planter, raised on four square feet."""
    pair = both_sides(box((2 * bar, 1.2 * height, 2 * bar), (x, 0.6 * height, z)))
    turned_round = moved(pair, (0.0, 0.0, -2 * z))
    return joined(moved(planter, (0.0, height, 0.0)), pair, turned_round)


def _trough(rng: Generator) -> Mesh:
    """A window box or an oval bowl, longer than deep, often with a row of plants."""
    width = rng.uniform(0.4, 1.2)
    depth, height = rng.uniform(0.25, 0.55), width * rng.uniform(0.2, 0.5)
    form = Form(*(((4, 40.0), (4, 40.0), (24, 5.0), (24, 2.0))[rng.integers(4)]), depth=depth)
    foot, wall = 0.5 * width * rng.uniform(0.8, 1.0), rng.uniform(0.03, 0.045) * width
    profile = straight([(foot, 0.0), (0.5 * width, height)])
    planted = rng.random() < 0.6
    soil = height * rng.uniform(0.8, 0.93) if planted or rng.random() < 0.2 else 0.0
    parts = [hollow(profile, wall, form, soil)]
    if planted:
        count, grown = int(rng.integers(2, 5)), plant(rng)
        size = rng.uniform(0.8, 1.6) * max(depth * width, height)
        for x in 0.9 * width * ((np.arange(count) + 0.5) / count - 0.5):
            parts.append(moved(grown(rng, size * rng.uniform(0.85, 1.0)), (x, soil, 0.0)))
    if rng.random() < 0.3:
        reach, bar = (0.6 if form.roundness < 3 else 0.8) * foot, 0.025 * width
        return _on_feet(joined(*parts), reach, depth * reach, rng.uniform(0.05, 0.2) * width, bar)
    return joined(*parts)


def _round_bellied(rng: Generator) -> Mesh:
    """A clay pot with a belly and a wide mouth, at times with two ears."""
    height = rng.uniform(0.15, 0.6)
    radius = height * rng.uniform(0.45, 0.75)
    foot, mouth = radius * rng.uniform(0.35, 0.75), radius * rng.uniform(0.6, 0.9)
    points = [(foot, 0.0), (radius, rng.uniform(0.4, 0.62) * height), (mouth, 0.9 * height)]
    profile = smooth([*points, (mouth * rng.uniform(1.0, 1.22), height)], 18)
    wall = rng.uniform(0.09, 0.13) * radius
    parts = [_filled(rng, profile, wall, 0.4)]
    if rng.random() < 0.4:
        low = 0.5 * height
        ear = handle(profile, wall, low, low + rng.uniform(0.2, 0.35) * height, 0.16 * radius, 0.07 * radius)
        parts.append(both_sides(ear))
    return joined(*parts)


def _kettle_body(rng: Generator, flatness: tuple[float, float]) -> tuple[Profile, float]:
    """A straight metal wall over a rounded bottom edge: profile and radius."""
    radius = rng.uniform(0.08, 0.2)
    height, edge = 2 * radius * rng.uniform(*flatness), rng.uniform(0.06, 0.25) * radius
    bottom = radius * rng.uniform(0.88, 1.0)
    bend = [(bottom - edge * (1 - np.cos(a)), edge * (1 - np.sin(a))) for a in np.linspace(np.pi / 2, 0.2, 5)]
    rim = [(radius, height - 0.07 * radius), (1.05 * radius, height - 0.05 * radius), (1.05 * radius, height)]
    return straight([*bend, *rim]), radius


def _pan(rng: Generator, profile: Profile, radius: float, covered: float) -> list[Mesh]:
    """The body, with a lid in a share `covered` of cases."""
    if rng.random() >= covered:
        return [hollow(profile, 0.08 * radius)]
    height, knob = rng.uniform(0.12, 0.4) * radius, rng.uniform(0.13, 0.2) * radius
    return [solid(profile), lid(1.08 * radius, profile[-1, 1] - 0.01 * radius, height, knob)]


def _cooking_pot(rng: Generator) -> Mesh:
    """Two loops for handles, and a lid on more than half of them."""
    profile, radius = _kettle_body(rng, (0.35, 1.0))
    height, bar = profile[-1, 1], radius * rng.uniform(0.05, 0.09)
    y, out, half = height * rng.uniform(0.65, 0.85), rng.uniform(0.25, 0.45) * radius, rng.uniform(0.22, 0.4) * radius
    root = np.sqrt(radius_at(profile, y) ** 2 - half**2) - 0.3 * bar
    loop = [(root, y, -half), (root + 0.8 * out, y, -half), (root + out, y, -0.6 * half), (root + out, y, 0.6 * half)]
    loop += [(root + 0.8 * out, y, half), (root, y, half)]
    return joined(*_pan(rng, profile, radius, 0.6), both_sides(tube(loop, bar, 8)))


def _saucepan(rng: Generator) -> Mesh:
    """One long handle behind."""
    profile, radius = _kettle_body(rng, (0.2, 0.8))
    height, bar = profile[-1, 1], radius * rng.uniform(0.08, 0.13)
    length, y = radius * rng.uniform(1.2, 2.2), 0.82 * height
    rise = rng.uniform(0.0, 0.3) * radius
    path = [(0.0, y, -0.96 * radius), (0.0, y + 0.3 * rise, -radius - 0.3 * length), (0.0, y + rise, -radius - length)]
    return joined(*_pan(rng, profile, radius, 0.4), tube(path, (0.7 * bar, bar, bar), 8))


def _cauldron(rng: Generator) -> Mesh:
    """A round iron belly on three legs, at times with a bail over it."""
    radius = rng.uniform(0.15, 0.35)
    mouth, leg = radius * rng.uniform(0.72, 0.85), radius * rng.uniform(0.35, 0.6)
    angles = np.linspace(-1.2, 0.85, 12)
    belly = [(radius * np.cos(a), radius * (np.sin(a) - np.sin(-1.2))) for a in angles]
    top = belly[-1][1]
    profile = straight([*belly, (mouth, top + 0.1 * radius), (1.1 * mouth, top + 0.2 * radius)])
    feet = []
    for azimuth in (0.0, 2 * np.pi / 3, 4 * np.pi / 3):
        out = np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
        feet.append(
            tube(
                [0.62 * radius * out + (0.0, 0.2 * radius, 0.0), 0.78 * radius * out - (0.0, leg, 0.0)],
                (0.12 * radius, 0.08 * radius),
                8,
            )
        )
    parts = [hollow(profile, 0.1 * radius), *feet]
    if rng.random() < 0.6:
        bow = [
            (0.95 * mouth * np.cos(a), top + 0.12 * radius + 0.9 * mouth * np.sin(a), 0.0)
            for a in np.linspace(0.0, np.pi, 13)
        ]
        parts.append(tube(bow, 0.05 * radius, 8))
    return moved(joined(*parts), (0.0, leg, 0.0))


def _on_a_stand(rng: Generator) -> Mesh:
    """A pot held between four wooden posts."""
    radius = rng.uniform(0.1, 0.2)
    height, lift = radius * rng.uniform(1.5, 2.4), radius * rng.uniform(0.6, 2.0)
    profile = straight([(0.93 * radius, 0.0), (radius, 0.08 * radius), (radius, height)])
    pot = moved(_filled(rng, profile, 0.1 * radius, 0.7), (0.0, lift, 0.0))
    bar, top = rng.uniform(0.06, 0.1), lift + height * rng.uniform(0.4, 0.8)
    splay = rng.uniform(0.0, 0.25)
    square = rng.random() < 0.5
    parts = []
    for azimuth in (np.pi / 4, 3 * np.pi / 4):
        out = radius * np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
        foot, head = (1 + splay) * out, (1 + 0.5 * bar) * out + (0.0, top, 0.0)
        parts.append(both_sides(tube([foot, head], bar * radius, 8, square)))
        level = np.array([0.0, lift - 0.4 * bar * radius, 0.0])
        parts.append(both_sides(tube([level, out + level], bar * radius, 8, square)))
    return joined(pot, *parts)


def _strawberry_pot(rng: Generator) -> Mesh:
    """A tall belly with pockets in its side."""
    height = rng.uniform(0.3, 0.6)
    radius, pocket = height * rng.uniform(0.28, 0.38), height * rng.uniform(0.1, 0.135)
    profile = smooth(
        [(0.65 * radius, 0.0), (radius, 0.5 * height), (0.72 * radius, 0.9 * height), (0.82 * radius, height)]
    )
    bowl = smooth([(0.3 * pocket, -pocket), (0.8 * pocket, -0.4 * pocket), (pocket, 0.5 * pocket)], 5)
    cup = hollow(bowl, 0.22 * pocket, Form(12))
    parts = [_filled(rng, profile, 0.1 * radius, 0.6, most=0.8)]
    for level, offset in ((0.35, 0.0), (0.62, np.pi / 4)):
        out = radius_at(profile, level * height) + 0.15 * pocket
        leaning = moved(turned(cup, 0, 0.4), (0.0, level * height, out))
        parts += [turned(leaning, 1, offset + index * np.pi / 2) for index in range(4)]
    return joined(*parts)


def _tiered(rng: Generator) -> Mesh:
    """Bowls that grow smaller, one above the other on a column."""
    radius, tiers = rng.uniform(0.2, 0.4), int(rng.integers(2, 4))
    parts, y = [], 0.0
    for _ in range(tiers):
        height = radius * rng.uniform(0.5, 0.75)
        bowl = smooth([(0.5 * radius, 0.0), (0.85 * radius, 0.5 * height), (radius, height)], 8)
        parts.append(moved(hollow(bowl, 0.11 * radius, floor=0.72 * height), (0.0, y, 0.0)))
        rise = height * rng.uniform(1.2, 1.5)
        parts.append(lathe([(0.3 * radius, y + 0.5 * height), (0.25 * radius, y + rise + 0.05 * height)], 16))
        y, radius = y + rise, radius * rng.uniform(0.6, 0.75)
    crest = plant(rng)(rng, 2.0 * radius)
    return joined(*parts, moved(crest, (0.0, y, 0.0)))
