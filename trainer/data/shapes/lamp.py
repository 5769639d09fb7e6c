"""Lamps: table, floor, desk, hanging, wall and street lamps, chandeliers, lanterns, and one in eight unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.lamp_hanging import (
    make_chandelier,
    make_cluster,
    make_flush,
    make_linear,
    make_pendant,
    make_ring_chandelier,
    make_sconce,
)
from trainer.data.shapes.lamp_parts import (
    BODIES,
    STANDING,
    ShadeStyle,
    at_top,
    body,
    foot,
    hanging,
    lantern,
    rotated,
    shade,
    tripod,
)
from trainer.data.shapes.lamp_unusual import (
    make_hoop,
    make_lantern,
    make_lava,
    make_mushroom,
    make_rock,
    make_sputnik,
    make_stack,
)
from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, moved, prism, tube, turned


def make_lamp(rng: Generator) -> Mesh:
    """One lamp, metres, its lowest point at y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.22, _table),
        (0.09, _floor),
        (0.05, _tripod),
        (0.03, _torchiere),
        (0.03, _tower),
        (0.03, _arc),
        (0.09, _desk),
        (0.02, _banker),
        (0.09, make_pendant),
        (0.03, make_cluster),
        (0.03, make_flush),
        (0.02, make_linear),
        (0.05, make_chandelier),
        (0.02, make_ring_chandelier),
        (0.04, make_sconce),
        (0.06, _street),
        (0.03, make_lantern),
        (0.02, make_sputnik),
        (0.02, make_mushroom),
        (0.02, make_stack),
        (0.015, make_lava),
        (0.01, make_rock),
        (0.01, make_hoop),
    )
    shares = np.array([share for share, _ in builders])
    mesh = builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)
    # What hangs is built from the ceiling down.
    return moved(mesh, (0.0, -float(mesh.vertices[:, 1].min()), 0.0))


def _table(rng: Generator) -> Mesh:
    """A body with a shade on a short neck."""
    cover = shade(rng, STANDING[rng.integers(len(STANDING))], rng.uniform(0.11, 0.24), rng.uniform(0.14, 0.3))
    high, width = cover.height * rng.uniform(0.75, 1.8), cover.radius * rng.uniform(0.32, 0.7)
    stem = high + rng.uniform(0.02, 0.08) + cover.socket
    parts = [
        body(rng, BODIES[rng.integers(len(BODIES))], width, high),
        cylinder((0.0, 0.8 * high, 0.0), (0.0, stem, 0.0), rng.uniform(0.01, 0.018), 10),
        at_top(cover, stem),
    ]
    if rng.random() < 0.5:
        parts.append(foot(rng, width * rng.uniform(0.9, 1.25), rng.uniform(0.02, 0.04)))
    return joined(*parts)


def _floor(rng: Generator) -> Mesh:
    """A straight pole on a heavy foot, at times with a little table on the way, or with several heads."""
    high, reach, pole = rng.uniform(1.2, 1.65), rng.uniform(0.13, 0.22), rng.uniform(0.016, 0.035)
    parts = [foot(rng, reach, rng.uniform(0.03, 0.07)), cylinder((0.0, 0.01, 0.0), (0.0, high, 0.0), pole, 10)]
    if rng.random() < 0.15:
        count = int(rng.choice([2, 3, 5]))
        style: ShadeStyle = "cone" if rng.random() < 0.5 else "dome"
        head = shade(rng, style, rng.uniform(0.08, 0.13), rng.uniform(0.12, 0.2), 12)
        out, rise = rng.uniform(0.2, 0.35), rng.uniform(-0.1, 0.15)
        arm = tube([(0.0, high - 0.25, 0.0), (0.0, high - 0.05 + rise, 0.6 * out), (0.0, high + rise, out)], 0.012, 8)
        hung = moved(turned(hanging(head, 0.01, 0.02), 0, -rng.uniform(0.0, 0.9)), (0.0, high + rise, out))
        return joined(*parts, rotated(joined(arm, hung), count))
    cover = shade(rng, STANDING[rng.integers(len(STANDING))], rng.uniform(0.17, 0.3), rng.uniform(0.2, 0.42))
    if rng.random() < 0.15:
        level = rng.uniform(0.35, 0.5) * high
        parts.append(lathe([(rng.uniform(0.18, 0.24), level), (0.22, level + 0.03)], 20))
    return joined(*parts, at_top(cover, high))


def _tripod(rng: Generator) -> Mesh:
    """A shade on three or four straight legs, on the floor or on a table."""
    high = rng.choice([rng.uniform(1.0, 1.3), rng.uniform(0.25, 0.4)])
    style = STANDING[rng.integers(len(STANDING))]
    cover = shade(rng, style, high * rng.uniform(0.2, 0.34), high * rng.uniform(0.24, 0.4))
    stem = high * 1.02 + cover.socket
    neck = cylinder((0.0, high * 0.97, 0.0), (0.0, stem, 0.0), 0.02 * high, 8)
    under = tripod(rng, high, high * rng.uniform(0.25, 0.4), high * rng.uniform(0.016, 0.03))
    return joined(under, neck, at_top(cover, stem))


def _torchiere(rng: Generator) -> Mesh:
    """A pole that carries a bowl open to the ceiling."""
    high, pole = rng.uniform(1.4, 1.8), rng.uniform(0.018, 0.035)
    bowl = shade(rng, "bowl", rng.uniform(0.16, 0.28), rng.uniform(0.09, 0.2))
    parts = [foot(rng, rng.uniform(0.13, 0.2), 0.05), cylinder((0.0, 0.01, 0.0), (0.0, high, 0.0), pole, 10)]
    parts.append(moved(bowl.mesh, (0.0, high - 0.02, 0.0)))
    if rng.random() < 0.4:
        reach, level = rng.uniform(0.2, 0.3), rng.uniform(0.55, 0.7) * high
        reader = turned(hanging(shade(rng, "cone", 0.07, 0.13), 0.01, 0.018), 0, -0.7)
        path = [(0.0, level, 0.0), (0.0, level + 0.12, 0.5 * reach), (0.0, level + 0.12, reach)]
        parts += [tube(path, 0.012, 8), moved(reader, path[-1])]
    return joined(*parts)


def _tower(rng: Generator) -> Mesh:
    """A tall shade close over the floor or the table."""
    high, radius = rng.uniform(0.45, 1.4), rng.uniform(0.09, 0.17)
    styles: tuple[ShadeStyle, ...] = ("drum", "drum", "square", "facets")
    cover = shade(rng, styles[rng.integers(4)], radius, high)
    gap, reach = rng.uniform(0.05, 0.14), radius * rng.uniform(0.8, 1.1)
    stem = cylinder((0.0, 0.01, 0.0), (0.0, gap + cover.socket, 0.0), 0.2 * radius, 10)
    return joined(foot(rng, reach, rng.uniform(0.03, 0.06)), stem, moved(cover.mesh, (0.0, gap, 0.0)))


def _arc(rng: Generator) -> Mesh:
    """A bow from a heavy foot at the back to a shade that hangs in front."""
    high, reach, bar = rng.uniform(1.3, 1.7), rng.uniform(0.7, 1.2), rng.uniform(0.016, 0.03)
    straight, angle = rng.uniform(0.3, 0.6) * high, np.linspace(0.0, rng.uniform(0.75, 0.95) * np.pi, 12)
    radius = reach / (1 - np.cos(angle[-1]))
    arc = np.stack((0 * angle, straight + (high - straight) * np.sin(angle), radius * (1 - np.cos(angle))), -1)
    path = np.concatenate(([(0.0, 0.02, 0.0)], arc))
    styles: tuple[ShadeStyle, ...] = ("dome", "drum", "globe", "cone")
    head = shade(rng, styles[rng.integers(4)], rng.uniform(0.16, 0.26), rng.uniform(0.16, 0.28))
    hung = moved(hanging(head, rng.uniform(0.0, 0.12), 0.8 * bar), arc[-1])
    return joined(foot(rng, rng.uniform(0.15, 0.22), rng.uniform(0.05, 0.12)), tube(path, bar, 8), hung)


def _desk(rng: Generator) -> Mesh:
    """Two jointed arms, or one bent neck, from a weighted foot to a head that looks down and forward."""
    lower, upper, bar = rng.uniform(0.2, 0.36), rng.uniform(0.2, 0.36), rng.uniform(0.009, 0.017)
    start, base = np.array([0.0, 0.02, 0.0]), rng.uniform(0.08, 0.13)
    lean, raise_by = rng.uniform(-0.1, 0.6), rng.uniform(0.1, 1.0)
    elbow = start + lower * np.array([0.0, np.cos(lean), -np.sin(lean)])
    wrist = elbow + upper * np.array([0.0, np.sin(raise_by), np.cos(raise_by)])
    if rng.random() < 0.35:
        share = np.linspace(0.0, 1.0, 9)[:, None]
        control = elbow + (elbow - (start + wrist) / 2)
        necks = [tube((1 - share) ** 2 * start + 2 * share * (1 - share) * control + share**2 * wrist, bar, 8)]
    else:
        twin, pin = rng.random() < 0.4, np.array([2 * bar, 0.0, 0.0])
        bars = [tube(pair, 0.7 * bar if twin else bar, 8) for pair in ((start, elbow), (elbow, wrist))]
        necks = [both_sides(moved(single, (1.1 * bar, 0.0, 0.0))) if twin else single for single in bars]
        necks += [cylinder(joint - pin, joint + pin, 1.7 * bar, 10) for joint in (elbow, wrist)]
    styles: tuple[ShadeStyle, ...] = ("cone", "dome", "bell", "drum", "trumpet")
    head = shade(rng, styles[rng.integers(5)], rng.uniform(0.06, 0.1), rng.uniform(0.1, 0.18))
    hung = moved(turned(hanging(head, -0.06 * head.height, 1.3 * bar), 0, -rng.uniform(0.0, 0.9)), wrist)
    stand = foot(rng, base, rng.uniform(0.02, 0.045))
    if rng.random() < 0.15:
        stand = joined(box((0.05, 0.1, 0.06), (0.0, 0.0, 0.0)), box((0.05, 0.02, 0.12), (0.0, -0.06, 0.03)))
    return joined(stand, hung, *necks)


def _banker(rng: Generator) -> Mesh:
    """A half cylinder across a short stem."""
    length, radius, high = rng.uniform(0.22, 0.36), rng.uniform(0.06, 0.09), rng.uniform(0.26, 0.38)
    angle, wall = np.linspace(-0.05, np.pi + 0.05, 11), 0.012
    # Solid: its open side looks down, on the bulb that fills it.
    section = radius * np.stack((np.sin(angle), rng.uniform(1.0, 1.3) * np.cos(angle)), -1)
    trough = prism(section, -length / 2, length / 2)
    reach = rng.uniform(0.0, 0.06)
    stem = tube([(0.0, 0.02, 0.0), (0.0, 0.7 * high, 0.0), (0.0, high + 0.02, reach)], wall, 8)
    return joined(foot(rng, rng.uniform(0.08, 0.11), 0.035), stem, moved(trough, (0.0, high, reach)))


def _street(rng: Generator) -> Mesh:
    """A post with a lantern or globes on it, or a mast with one or two arms over the road."""
    high, pole = rng.uniform(1.7, 3.2), rng.uniform(0.055, 0.1)
    plinth = [(2.6 * pole, 0.0), (2.6 * pole, 0.1), (1.9 * pole, 0.16), (1.8 * pole, 0.2 * high), (pole, 0.25 * high)]
    mast = lathe([*plinth, (0.75 * pole, high)], 10)
    match int(rng.integers(4)):
        case 0:
            glazed = lantern(rng, rng.uniform(0.2, 0.34), rng.uniform(0.5, 0.8))
            return joined(mast, moved(glazed, (0.0, high - 0.02, 0.0)))
        case 1:
            style: ShadeStyle = "globe" if rng.random() < 0.6 else "dome"
            ball = shade(rng, style, rng.uniform(0.18, 0.28), rng.uniform(0.34, 0.5), 14)
            top = moved(ball.mesh, (0.0, high - 0.03, 0.0))
            if rng.random() < 0.6:
                out, count = rng.uniform(0.35, 0.55), int(rng.choice([2, 2, 3, 4]))
                level = high - rng.uniform(0.3, 0.6)
                bend = [(0.0, level - 0.2, 0.0), (0.0, level - 0.2, 0.7 * out), (0.0, level + 0.05, out)]
                side = joined(tube(bend, 0.6 * pole, 8), moved(ball.mesh, (0.0, level, out)))
                return joined(mast, top, rotated(side, count, np.pi / 2))
            return joined(mast, top)
        case _:
            out, rise = rng.uniform(0.6, 1.4), rng.uniform(0.1, 0.5)
            angle = np.linspace(0.0, np.pi / 2, 7)
            path = np.stack((0 * angle, high - 0.05 + rise * np.sin(angle), out * (1 - np.cos(angle))), -1)
            style = "dome" if rng.random() < 0.5 else "bell"
            head = hanging(shade(rng, style, rng.uniform(0.2, 0.32), rng.uniform(0.2, 0.35)), -0.02, 0.7 * pole)
            if rng.random() < 0.5:
                head = box((0.26, 0.12, rng.uniform(0.5, 0.75)), (0.0, -0.02, 0.2), (0.7, 0.85))
            side = joined(tube(path, 0.7 * pole, 8), moved(head, path[-1]))
            return joined(mast, rotated(side, 2, np.pi / 2) if rng.random() < 0.35 else side)
