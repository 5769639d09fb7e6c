"""Loudspeakers that are not a box for the living room: on stage, in the hand, round, flat, or with a horn."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.loudspeaker_parts import Cell, Driver, arranged, boxed, cabinet, lying, woofer_of
from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, cylinder, joined, lathe, loft, moved, tube, turned


def make_guitar_stack(rng: Generator) -> Mesh:
    """Four cones in a framed box, or one or two in a smaller one, with an amplifier's head on top or a second box."""
    columns = int(rng.choice([1, 2, 2]))
    width, depth = 0.38 * columns * rng.uniform(0.85, 1.0), rng.uniform(0.25, 0.4)
    rows = columns if columns == 2 else int(rng.integers(1, 3))
    height, frame = 0.37 * rows * rng.uniform(0.9, 1.0), rng.uniform(0.03, 0.05)
    cells = arranged([woofer_of(rng, 0.43 * width / columns)] * rows, height, 0.0)
    middles = [0.0] if columns == 1 else [-width / 4, width / 4]
    parts = [cabinet(boxed(width / columns, depth), cells, frame, middle) for middle in middles]
    outer = (width + 2 * frame, height + 2 * frame)
    shell, forward = depth + rng.uniform(0.02, 0.05), 0.015
    parts.append(both_sides(box((frame, outer[1], shell), ((width + frame) / 2, outer[1] / 2, forward))))
    parts += [box((outer[0], frame, shell), (0.0, y, forward)) for y in (frame / 2, outer[1] - frame / 2)]
    body = joined(*parts)
    top, second = outer[1], moved(body, (0.0, outer[1], 0.0))
    if rng.random() < 0.3:
        body, top = joined(body, second), 2 * top
    if rng.random() < 0.65:
        amplifier = rng.uniform(0.18, 0.25)
        head = box(
            (rng.uniform(0.85, 1.0) * outer[0], amplifier, 0.8 * shell), (0.0, top + amplifier / 2, -0.05 * shell)
        )
        panel = box((0.8 * outer[0], 0.35 * amplifier, 0.06), (0.0, top + 0.35 * amplifier, 0.33 * shell))
        return joined(body, head, panel)
    return body


def make_portable(rng: Generator) -> Mesh:
    """A cone at either end of a long box, a panel between them, a handle above."""
    height = rng.uniform(0.14, 0.25)
    plan = boxed(height, height * rng.uniform(0.4, 0.8), rng.uniform(0.03, 0.12) * height)
    end = Cell(height, woofer_of(rng, 0.94 * plan[-1][1] * rng.uniform(0.8, 1.0)))
    width = rng.uniform(0.4, 1.4) * height
    panel = Driver("grille", 0.34 * height, height=1.2 * width / height, roundness=12.0)
    body = lying(plan, [end, Cell(width, panel), end])
    if rng.random() < 0.75:
        x, bar, rise = rng.uniform(0.5, 0.9) * (height + width / 2), 0.05 * height, height * rng.uniform(1.15, 1.45)
        grip = [(-x, 0.95 * height, 0.0), (-x, rise, 0.0), (x, rise, 0.0), (x, 0.95 * height, 0.0)]
        return joined(body, tube(grip, bar, 8))
    return body


def make_cylinder(rng: Generator) -> Mesh:
    """A round portable one: upright with raised buttons in front, or lying with a cone in either end."""
    radius = rng.uniform(0.04, 0.08)
    length = radius * rng.uniform(3.0, 5.5)
    if rng.random() < 0.5:
        half = [(0.25, 0.72), (0.75, 0.82), (0.82, 1.0), (0.95, 1.0), (1.0, 0.94)]
        profile = [(r * radius, -y * length / 2) for r, y in half] + [
            (r * radius, y * length / 2) for r, y in half[::-1]
        ]
        roll = moved(turned(lathe(profile, 24), 2, np.pi / 2), (0.0, radius, 0.0))
        plate = cushion((0.5 * length, 0.8 * radius, 0.3 * radius), (0.0, 1.0 * radius, 0.92 * radius), 0.08 * radius)
        foot = box((0.7 * length, 0.3 * radius, 0.9 * radius), (0.0, 0.15 * radius, 0.0))
        return joined(roll, plate, foot)
    edge = rng.uniform(0.1, 0.5) * radius
    bottom, top = (0.9 * radius, 0.0), (radius, 0.06 * length)
    round_off = [(radius - edge * (1 - np.cos(a)), length - edge * (1 - np.sin(a))) for a in np.linspace(0.0, 1.3, 5)]
    across, along = box((0.5 * radius, 0.14 * radius, 0.2 * radius)), box((0.14 * radius, 0.5 * radius, 0.2 * radius))
    plus, minus = (0.0, 0.72 * length, radius), (0.0, 0.3 * length, radius)
    strap = [
        (0.0, 0.85 * length, -0.9 * radius),
        (0.0, 0.8 * length, -1.5 * radius),
        (0.0, 0.5 * length, -1.6 * radius),
    ]
    strap += [(0.0, 0.2 * length, -1.5 * radius), (0.0, 0.15 * length, -0.9 * radius)]
    buttons = [moved(across, plus), moved(along, plus), moved(across, minus)]
    return joined(lathe([bottom, top, *round_off], 24), *buttons, tube(strap, 0.11 * radius, 6))


def make_sphere(rng: Generator) -> Mesh:
    """A ball or an egg with a cone in its front, on a ring, a stem or three legs."""
    radius, length = rng.uniform(0.08, 0.2), rng.uniform(1.0, 1.5)
    opening = rng.uniform(0.5, 0.85)
    shell = [
        (np.cos(a), length * np.sin(a) if a < 0 else np.sin(a)) for a in np.linspace(-1.45, np.arccos(opening), 12)
    ]
    front = shell[-1][1]
    cone = [(0.9, 0.04), (0.85, -0.08), (0.78, 0.03), (0.7, -0.05), (0.32, -0.5), (0.26, -0.4), (0.1, -0.32)]
    profile = [*shell, *((r * opening, front + z * opening) for r, z in cone)]
    ball = turned(lathe([(r * radius, z * radius) for r, z in profile], 24), 0, np.pi / 2)
    match rng.integers(3):
        case 0:
            ring = lathe([(0.75 * radius, 0.0), (0.6 * radius, 0.35 * radius)], 20)
            return joined(moved(ball, (0.0, 1.1 * radius, 0.0)), ring)
        case 1:
            lift = rng.uniform(0.2, 1.0)
            stem = lathe(
                [
                    (0.9 * radius, 0.0),
                    (0.85 * radius, 0.02),
                    (0.15 * radius, 0.05),
                    (0.15 * radius, lift + 0.1 * radius),
                ],
                20,
            )
            return joined(moved(ball, (0.0, lift + radius, 0.0)), stem)
        case _:
            lift = rng.uniform(0.5, 0.9) * radius
            legs = [
                cylinder(
                    (0.5 * radius * np.sin(a), lift + 0.4 * radius, 0.5 * radius * np.cos(a)),
                    (radius * np.sin(a), 0.0, radius * np.cos(a)),
                    0.08 * radius,
                    8,
                )
                for a in (np.pi, np.pi / 3, -np.pi / 3)
            ]
            return joined(moved(ball, (0.0, lift + radius, 0.0)), *legs)


def make_gramophone(rng: Generator) -> Mesh:
    """A horn that rises from behind a box with a turntable."""
    width, height = rng.uniform(0.3, 0.42), rng.uniform(0.12, 0.22)
    mouth, rise = rng.uniform(0.2, 0.32), rng.uniform(0.4, 0.55)
    along = np.linspace(0.0, 1.0, 14)[:, None]
    start, bend, end = np.array(
        [(height - 0.02, -0.38 * width), (height + 1.1 * rise, -0.62 * width), (height + rise, 0.5 * width)]
    )
    path = (1 - along) ** 2 * start + 2 * along * (1 - along) * bend + along**2 * end
    forward = 2 * (1 - along) * (bend - start) + 2 * along * (end - bend)
    upward = np.stack((forward[:, 1], -forward[:, 0]), 1) / np.linalg.norm(forward, axis=1, keepdims=True)
    radii = 0.035 + (mouth - 0.035) * along[:, 0] ** rng.uniform(2.5, 4.0)
    angle = np.arange(20) * 2 * np.pi / 20
    rings = [
        np.concatenate(((radius * np.cos(angle))[:, None], centre + np.outer(radius * np.sin(angle), up)), 1)
        for reach in (0.0, 0.022)
        for centre, up, radius in list(zip(path, upward, radii - reach, strict=True))[:: 1 if reach == 0.0 else -1]
    ]
    parts = [
        loft(np.stack(rings)),
        box((width, 0.8 * height, width), (0.0, 0.55 * height, 0.0)),
        box((1.12 * width, 0.2 * height, 1.12 * width), (0.0, 0.1 * height, 0.0)),
        box((1.08 * width, 0.12 * height, 1.08 * width), (0.0, 0.9 * height, 0.0)),
        lathe([(0.42 * width, height - 0.06 * height), (0.42 * width, height + 0.12 * height)], 24),
    ]
    return joined(*parts)


def make_panel(rng: Generator) -> Mesh:
    """A tall thin membrane in a frame, bent around the listener, on a box with a cone."""
    width, height, base = rng.uniform(0.3, 0.5), rng.uniform(1.0, 1.5), rng.uniform(0.25, 0.4)
    depth, bulge, thickness = width * rng.uniform(0.7, 1.1), rng.uniform(0.02, 0.08), rng.uniform(0.05, 0.08)
    plan = boxed(width, depth, back=rng.uniform(0.6, 1.0))
    woofer = woofer_of(rng, min(0.42 * width, 0.42 * base))
    sheet = [
        [(x, base - 0.02, z - thickness), (x, base - 0.02, z), (x, height, z), (x, height, z - thickness)]
        for x in np.linspace(-0.48 * width, 0.48 * width, 9)
        for z in [0.3 * depth - bulge * (2 * x / width) ** 2]
    ]
    return joined(cabinet(plan, [Cell(base, woofer)]), loft(np.array(sheet)))
