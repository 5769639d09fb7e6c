"""Cars that most people would call unusual: open, old, and made for racing."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.car_measures import ROADSTER, draw_measures, nose, tail
from trainer.data.shapes.car_parts import Frame, cabin, hull, rounded, wheel, wheels, windscreen
from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, joined, loft, ring, tube, turned


def make_roadster(rng: Generator) -> Mesh:
    draw = draw_measures(rng, ROADSTER)
    frame = draw.frame
    rear_foot = frame.length - draw.deck
    width, seat = 0.88 * frame.width, draw.hood + draw.windscreen + rng.uniform(0.55, 0.75)
    well = draw.belt - 0.16
    outline = [
        *nose(draw)[:-1],
        (draw.hood, draw.belt),
        (draw.hood + 0.12, well),
        (seat + 0.2, well),
        *tail(draw, max(rear_foot, seat + 0.35), draw.belt),
    ]
    parts = [
        hull(frame, outline, draw.rounding, draw.shoulder),
        windscreen(frame, draw.hood, draw.belt, frame.height, draw.windscreen, width),
        both_sides(
            box(
                (0.07, 0.2, seat + 0.2 - draw.hood),
                (0.46 * frame.width, draw.belt - 0.1, frame.z((seat + draw.hood + 0.2) / 2)),
            )
        ),
        both_sides(
            turned(
                cushion((0.45, 0.6, 0.16), (0.22 * frame.width, draw.belt, frame.z(seat)), 0.04),
                0,
                -0.25,
                (0.0, well, frame.z(seat)),
            )
        ),
        wheels(draw.frame),
    ]
    return joined(*parts)


def make_vintage(rng: Generator) -> Mesh:
    """Narrow hood, upright cabin, wings over free-standing wheels."""
    length, width, height = rng.uniform(3.6, 4.8), rng.uniform(1.6, 1.8), rng.uniform(1.7, 2.0)
    radius, hood = rng.uniform(0.36, 0.46), rng.uniform(1.2, 1.7)
    frame = Frame(length, width, height, 0.3, radius, 0.16, radius + 0.12, length - radius - rng.uniform(0.15, 0.5))
    belt, core = rng.uniform(1.05, 1.2), 0.62 * width
    tail = length - rng.uniform(0.1, 0.5)
    engine = loft(
        np.stack(
            [
                ring(share * core / 2, 0.32, 0.0, 16, 3.5)[:, [0, 2, 1]] + (0.0, 0.78, frame.z(station))
                for station, share in ((0.12, 0.62), (0.3, 0.7), (hood + 0.1, 1.0))
            ]
        )
    )
    roof = rounded(
        [(hood, belt), (hood + 0.12, height - 0.02), (hood + 0.9, height), (tail - 0.25, height - 0.05), (tail, belt)],
        1,
    )
    parts = [
        engine,
        cabin(frame, roof, belt, core * 1.25, 0.06),
        box((core * 1.25, belt - 0.35, tail - hood), (0.0, (belt + 0.35) / 2, frame.z((tail + hood) / 2)), (1.0, 1.0)),
        box((0.5 * width, 0.2, length - 0.5), (0.0, 0.5, 0.0)),
        both_sides(
            box(
                (0.3, 0.05, frame.rear_axle - frame.front_axle),
                (width / 2 - 0.17, 0.36, frame.z((frame.front_axle + frame.rear_axle) / 2)),
            )
        ),
    ]
    for axle in (frame.front_axle, frame.rear_axle):
        angles = np.linspace(-0.25, np.pi + 0.15, 8)
        arch = [
            (width / 2 - 0.15, radius + 1.2 * radius * np.sin(a), frame.z(axle) + 1.2 * radius * np.cos(a))
            for a in angles
        ]
        parts += [both_sides(tube(arch, 0.12, square=True)), wheel(frame, axle)]
    return joined(*parts)


def make_racer(rng: Generator) -> Mesh:
    """A single-seater with free wheels and wings."""
    length, width = rng.uniform(4.4, 5.4), rng.uniform(1.8, 2.0)
    frame = Frame(
        length,
        width,
        1.0,
        0.08,
        rng.uniform(0.3, 0.36),
        rng.uniform(0.3, 0.4),
        rng.uniform(0.9, 1.2),
        length - rng.uniform(0.6, 0.8),
    )
    spine = (
        (0.1, 0.1, 0.08, 0.22),
        (0.9, 0.2, 0.16, 0.34),
        (2.0, 0.36, 0.24, 0.36),
        (2.6, 0.42, 0.36, 0.45),
        (0.75 * length, 0.4, 0.34, 0.44),
        (length - 0.3, 0.16, 0.16, 0.36),
    )
    body = loft(
        np.stack(
            [
                ring(x, y, 0.0, 16, 2.6)[:, [0, 2, 1]] + (0.0, height, frame.z(station))
                for station, x, y, height in spine
            ]
        )
    )
    rear_wing = rng.uniform(0.75, 1.0)
    parts = [
        body,
        both_sides(cushion((0.42, 0.36, 0.32 * length), (0.55, 0.32, frame.z(0.62 * length)), 0.1, 4.0)),
        cushion((0.95 * width, 0.04, 0.4), (0.0, 0.14, frame.z(0.2)), 0.01),
        cushion((0.55 * width, 0.05, 0.35), (0.0, rear_wing, frame.z(length - 0.15)), 0.01),
        both_sides(box((0.03, rear_wing - 0.2, 0.35), (0.27 * width, (rear_wing + 0.3) / 2, frame.z(length - 0.15)))),
        box((0.2, 0.5, 0.7), (0.0, 0.68, frame.z(0.66 * length)), (0.7, 0.4)),
        box((width - 0.3, 0.06, 0.08), (0.0, frame.wheel_radius, frame.z(frame.front_axle))),
        box((width - 0.3, 0.06, 0.08), (0.0, frame.wheel_radius, frame.z(frame.rear_axle))),
        wheel(frame, frame.front_axle),
        wheel(frame, frame.rear_axle),
    ]
    return joined(*parts)
