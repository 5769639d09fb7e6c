"""Jars: vases, amphoras, jugs, lidded jars, bottles and urns; about one in eight has an unusual section or body."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.jar_parts import (
    Form,
    handle,
    hollow,
    lid,
    radius_at,
    shouldered_profile,
    smooth,
    solid,
    straight,
    vase_profile,
)
from trainer.data.shapes.pot_parts import flowers
from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, moved, tube, turned


def make_jar(rng: Generator) -> Mesh:
    """One jar, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.26, _vase),
        (0.14, _amphora),
        (0.08, _jug),
        (0.13, _lidded),
        (0.07, _screw_top),
        (0.10, _bottle),
        (0.09, _urn),
        (0.05, _carved),
        (0.03, _moon_flask),
        (0.035, _stepped),
        (0.03, _ring_flask),
    )
    shares = np.array([share for share, _ in builders])
    return builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)


def _form(rng: Generator) -> Form:
    """Mostly round, at times square or with six or eight sides."""
    match rng.choice(["round", "rounded square", "square", "faceted"], p=[0.68, 0.12, 0.1, 0.1]):
        case "rounded square":
            return Form(24, rng.uniform(3.0, 6.0), rng.choice([1.0, rng.uniform(0.55, 0.9)]))
        case "square":
            return Form(4, 40.0, rng.choice([1.0, rng.uniform(0.5, 0.9)]))
        case "faceted":
            return Form(int(rng.choice([6, 8])))
        case _:
            return Form()


def _wall(rng: Generator, height: float, radius: float) -> float:
    return rng.uniform(0.04, 0.065) * float(np.hypot(height, 2 * radius))


def _vase(rng: Generator) -> Mesh:
    height = rng.uniform(0.15, 0.6)
    profile = vase_profile(rng, height)
    wall, mouth = _wall(rng, height, profile[:, 0].max()), profile[-1, 0]
    if rng.random() < 0.08 and mouth > 2 * wall:
        bouquet = moved(flowers(rng, 3.6 * (mouth - 0.8 * wall)), (0.0, height - wall, 0.0))
        return joined(hollow(profile, wall), bouquet)
    return hollow(profile, wall, _form(rng))


def _amphora(rng: Generator) -> Mesh:
    """Two handles from the shoulder to the neck, or two rings on the belly."""
    height = rng.uniform(0.3, 0.9)
    profile = shouldered_profile(rng, height)
    wall = 0.035 * height
    bar = height * rng.uniform(0.024, 0.036)
    if rng.random() < 0.7:
        low, high = rng.uniform(0.55, 0.74) * height, rng.uniform(0.88, 0.96) * height
        grip = handle(profile, wall, low, high, rng.uniform(0.02, 0.2) * height, bar, rng.uniform(-0.02, 0.12) * height)
    else:
        low = rng.uniform(0.4, 0.52) * height
        grip = handle(profile, wall, low, low + rng.uniform(0.12, 0.22) * height, rng.uniform(0.05, 0.1) * height, bar)
    parts = [hollow(profile, wall), both_sides(grip)]
    if rng.random() < 0.15:
        # Pointed amphoras stand in a ring.
        radius = radius_at(profile, 0.15 * height) + bar
        parts.append(lathe([(radius, 0.0), (radius + bar, 0.03 * height), (radius, 0.1 * height)], 24))
    return joined(*parts)


def _jug(rng: Generator) -> Mesh:
    """One handle behind, a lip drawn out in front."""
    height = rng.uniform(0.18, 0.4)
    if rng.random() < 0.5:
        profile = shouldered_profile(rng, height)
    else:
        radius = height * rng.uniform(0.28, 0.45)
        foot, mouth = rng.uniform(0.7, 1.0) * radius, rng.uniform(0.5, 0.9) * radius
        profile = smooth([(foot, 0.0), (radius, rng.uniform(0.25, 0.5) * height), (mouth, height)])
    wall = 0.035 * height
    low, high = rng.uniform(0.2, 0.4) * height, rng.uniform(0.82, 0.94) * height
    reach, bar = rng.uniform(0.08, 0.22) * height, rng.uniform(0.026, 0.038) * height
    grip = handle(profile, wall, low, high, reach, bar, rng.uniform(0.0, 0.08) * height)
    return joined(hollow(profile, wall, Form(spout=rng.uniform(0.3, 0.65))), turned(grip, 1, np.pi / 2))


def _lidded(rng: Generator) -> Mesh:
    """A ginger jar, a biscuit barrel or an apothecary's jar; its lid hides the inside."""
    height = rng.uniform(0.12, 0.45)
    radius = height * rng.uniform(0.32, 0.62)
    foot, mouth = rng.uniform(0.5, 0.95) * radius, rng.uniform(0.45, 0.9) * radius
    shoulder = rng.uniform(0.55, 0.8)
    body = smooth([(foot, 0.0), (radius, shoulder * height), (mouth, 0.93 * height), (mouth, height)])
    overhang, knob = rng.uniform(1.03, 1.14) * mouth, rng.choice([0.0, 1.0, 1.0]) * rng.uniform(0.12, 0.25) * mouth
    parts = [solid(body), lid(overhang, height - 0.02 * height, rng.uniform(0.15, 0.7) * overhang, knob)]
    if rng.random() < 0.3:
        low = rng.uniform(0.4, 0.55) * height
        grip = handle(body, 0.04 * height, low, low + 0.25 * height, 0.12 * height, 0.03 * height)
        parts.append(both_sides(grip))
    return joined(*parts)


def _screw_top(rng: Generator) -> Mesh:
    """A preserving jar: straight sides, a shoulder and a broad cap; or the same without its cap."""
    radius = rng.uniform(0.03, 0.07)
    height, neck = radius * rng.uniform(1.4, 3.4), radius * rng.uniform(0.7, 0.92)
    shoulder, section = height - (radius - neck) - 0.25 * radius, (Form(), Form(24, 5.0), Form(8))[rng.integers(3)]
    points = [(0.93 * radius, 0.0), (radius, 0.08 * radius), (radius, shoulder)]
    points += [(0.96 * radius, shoulder + 0.1 * radius), (neck, height - 0.18 * radius), (neck, height)]
    body = straight(points)
    if rng.random() < 0.3:
        return hollow(body, 0.11 * radius, section)
    cap = rng.uniform(1.03, 1.12) * neck
    top = height + rng.uniform(0.0, 0.25) * radius
    cover = lathe([(cap, height - 0.16 * radius), (cap, top), (0.93 * cap, top + 0.06 * radius)], 24)
    return joined(solid(body, section), cover)


def _bottle(rng: Generator) -> Mesh:
    """A body that narrows to a long neck; at times with a stopper."""
    height = rng.uniform(0.2, 0.4)
    radius = height * rng.uniform(0.13, 0.34)
    neck = max(radius * rng.uniform(0.22, 0.4), 0.04 * height)
    shoulder, throat = rng.uniform(0.35, 0.55), rng.uniform(0.62, 0.75)
    if rng.random() < 0.5:
        points = [(0.94 * radius, 0.0), (radius, 0.03), (radius, shoulder), (0.85 * radius, shoulder + 0.06)]
    else:
        points = [(rng.uniform(0.5, 0.8) * radius, 0.0), (radius, 0.5 * shoulder), (0.8 * radius, shoulder)]
    points += [(neck, throat), (neck, 0.93), (1.25 * neck, 0.95), (1.25 * neck, 1.0)]
    profile = smooth([(r, y * height) for r, y in points], 20)
    section = _form(rng)
    if rng.random() < 0.6:
        return hollow(profile, 0.5 * neck, section)
    stopper = height * rng.uniform(0.04, 0.1)
    ball = [(0.8 * neck, 0.98 * height), (0.8 * neck, height + 0.2 * stopper)]
    ball += [(stopper * np.cos(a), height + stopper * (1.2 + np.sin(a))) for a in (-0.7, -0.2, 0.3, 0.8, 1.3)]
    return joined(solid(profile, section), lathe(ball, 16))


def _urn(rng: Generator) -> Mesh:
    """A bowl or egg on a stem and a square or round plinth, often with a lid; at times square itself."""
    height = rng.uniform(0.35, 1.0)
    radius = height * rng.uniform(0.25, 0.5)
    foot, stem, bowl = rng.uniform(0.4, 0.6) * radius, rng.uniform(0.18, 0.28) * radius, rng.uniform(0.14, 0.26)
    closed = rng.random() < 0.5
    mouth = rng.uniform(0.6, 0.8) * radius if closed else rng.uniform(0.8, 1.25) * radius
    points = [(foot, 0.0), (0.9 * foot, 0.04), (stem, bowl - 0.04), (0.55 * radius, bowl + 0.06), (radius, 0.68)]
    points += [(0.8 * min(mouth, radius), 0.88), (mouth, 0.96), (mouth, 1.0)]
    profile = smooth([(r, y * height) for r, y in points], 22)
    plinth = height * rng.uniform(0.03, 0.12)
    base = box((2.1 * foot, plinth, 2.1 * foot), (0.0, plinth / 2, 0.0)) if rng.random() < 0.6 else None
    lift = plinth if base else 0.0
    form = Form(4, 40.0) if rng.random() < 0.15 and not closed else Form()
    parts = [solid(profile) if closed else hollow(profile, 0.04 * height, form)]
    if closed:
        parts.append(lid(1.04 * mouth, 0.99 * height, rng.uniform(0.3, 0.7) * mouth, rng.uniform(0.14, 0.22) * mouth))
    if rng.random() < 0.45:
        low, reach = rng.uniform(0.45, 0.55) * height, rng.uniform(0.04, 0.12) * height
        grip = handle(profile, 0.04 * height, low, low + rng.uniform(0.2, 0.4) * height, reach, 0.028 * height)
        parts.append(both_sides(grip))
    raised = moved(joined(*parts), (0.0, lift, 0.0))
    return joined(raised, base) if base else raised


def _carved(rng: Generator) -> Mesh:
    """A vase with ribs, a twist, or a lean to one side."""
    height = rng.uniform(0.2, 0.5)
    radius = height * rng.uniform(0.25, 0.5)
    neck = rng.uniform(0.4, 0.75) * radius
    points = [(rng.uniform(0.5, 0.9) * radius, 0.0), (radius, rng.uniform(0.35, 0.65) * height)]
    points += [(neck, 0.86 * height), (neck * rng.uniform(1.0, 1.3), height)]
    match rng.integers(4):
        case 0:
            section = Form(48, lobes=int(rng.choice([6, 8, 12])), relief=rng.uniform(0.04, 0.09))
        case 1:
            section = Form(48, lobes=6, relief=rng.uniform(0.06, 0.1), twist=rng.uniform(0.6, 1.6))
        case 2:
            section = Form(24, rng.uniform(5.0, 9.0), twist=rng.uniform(0.4, 1.2))
        case _:
            section = Form(roundness=rng.uniform(2.0, 4.0), lean=rng.uniform(0.15, 0.35))
    return hollow(smooth(points, 20), _wall(rng, height, radius), section)


def _moon_flask(rng: Generator) -> Mesh:
    """Flat from front to back, with a short neck and often two ears."""
    height = rng.uniform(0.2, 0.5)
    radius, neck, top = height * rng.uniform(0.3, 0.48), height * rng.uniform(0.09, 0.14), rng.uniform(0.68, 0.84)
    foot = rng.uniform(0.3, 0.65) * radius
    points = [(foot, 0.0), (rng.uniform(0.7, 1.0) * foot, 0.05), (radius, rng.uniform(0.48, 0.58) * top)]
    points += [(0.75 * radius, 0.85 * top), (neck, top), (neck, 0.95), (rng.uniform(1.0, 1.7) * neck, 1.0)]
    profile = smooth([(r, y * height) for r, y in points], 20)
    wall = 0.04 * height
    parts = [hollow(profile, wall, Form(depth=rng.uniform(0.4, 0.7)))]
    if rng.random() < 0.5:
        reach, rise = rng.uniform(0.02, 0.08) * height, rng.uniform(0.0, 0.05) * height
        parts.append(both_sides(handle(profile, wall, 0.84 * top * height, 0.9 * height, reach, 0.026 * height, rise)))
    return joined(*parts)


def _stepped(rng: Generator) -> Mesh:
    """A body of cones and cylinders with sharp edges between them."""
    height = rng.uniform(0.2, 0.5)
    radius = height * rng.uniform(0.25, 0.5)
    keel, neck = rng.uniform(0.25, 0.6), rng.uniform(0.35, 0.6) * radius
    points = [(rng.uniform(0.35, 0.7) * radius, 0.0), (radius, keel * height), (neck, (keel + 0.25) * height)]
    points += [(neck, rng.uniform(0.88, 0.93) * height), (rng.uniform(1.1, 1.8) * neck, height)]
    return hollow(straight(points), _wall(rng, height, radius), Form(int(rng.choice([6, 8, 24]))))


def _ring_flask(rng: Generator) -> Mesh:
    """A hollow ring that stands on a foot and opens in a neck."""
    radius, bar = rng.uniform(0.09, 0.14), rng.uniform(0.03, 0.05)
    foot, neck = rng.uniform(0.01, 0.03), rng.uniform(0.55, 0.8) * bar
    centre, angles = foot + radius + bar, np.linspace(0.02, 2 * np.pi - 0.02, 29)
    path = np.stack((radius * np.sin(angles), centre - radius * np.cos(angles), np.zeros(29)), 1)
    base = lathe([(1.5 * bar, 0.0), (1.3 * bar, 0.5 * foot), (bar, foot + 0.6 * bar)], 24)
    rise = rng.uniform(0.05, 0.09)
    throat = smooth([(neck, 0.0), (0.9 * neck, 0.5 * rise), (1.4 * neck, rise)], 8)
    return joined(tube(path, bar, 12), base, moved(hollow(throat, 0.4 * neck), (0.0, centre + radius + 0.8 * bar, 0.0)))
