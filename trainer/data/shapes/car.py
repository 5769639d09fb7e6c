"""Cars: sedans, coupés, hatchbacks, estates, off-roaders, vans, pickups, and about one in six that is unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.car_measures import (
    BUS,
    COUPE,
    ESTATE,
    HATCHBACK,
    LIMOUSINE,
    MICROCAR,
    OFF_ROADER,
    PICKUP,
    SEDAN,
    TRUCK,
    VAN,
    Kind,
    Measures,
    draw_measures,
    nose,
    roof,
    tail,
)
from trainer.data.shapes.car_parts import bed, bumpers, cabin, hull, mirrors, wheels
from trainer.data.shapes.car_unusual import make_racer, make_roadster, make_vintage
from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, joined, lathe, moved, tube, turned


def make_car(rng: Generator) -> Mesh:
    """One car, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.12, lambda rng: _closed(rng, SEDAN)),
        (0.10, lambda rng: _closed(rng, COUPE)),
        (0.12, lambda rng: _closed(rng, HATCHBACK)),
        (0.06, lambda rng: _closed(rng, ESTATE)),
        (0.13, lambda rng: _closed(rng, OFF_ROADER)),
        (0.15, lambda rng: _closed(rng, VAN)),
        (0.15, _pickup),
        (0.045, _truck),
        (0.025, lambda rng: _closed(rng, BUS)),
        (0.01, lambda rng: _closed(rng, LIMOUSINE)),
        (0.02, lambda rng: _closed(rng, MICROCAR)),
        (0.03, make_roadster),
        (0.025, make_vintage),
        (0.015, make_racer),
    )
    shares = np.array([share for share, _ in builders])
    return builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)


def _closed(rng: Generator, kind: Kind) -> Mesh:
    """A car with a roof from windscreen to rear window."""
    draw = draw_measures(rng, kind)
    frame, rear_foot = draw.frame, draw.frame.length - draw.deck
    lid = draw.belt * rng.uniform(0.94, 1.06) if draw.deck > 0.3 else draw.belt
    tumble = rng.uniform(0.05, 0.26) if kind is not BUS and kind is not VAN else rng.uniform(0.02, 0.14)
    width = frame.width * rng.uniform(0.9, 0.97)
    outline = [*nose(draw), *tail(draw, max(rear_foot - 0.05, draw.hood + 0.6), lid)]
    parts = [
        hull(frame, outline, draw.rounding, draw.shoulder),
        cabin(frame, roof(rng, draw, rear_foot, lid), min(draw.belt, lid), width, tumble),
        wheels(draw.frame),
    ]
    if rng.random() < 0.5:
        parts.append(mirrors(frame, draw.hood + 0.35 * draw.windscreen + 0.1, draw.belt + 0.08))
    if rng.random() < 0.4:
        parts.append(bumpers(frame, frame.clearance + 0.2, rng.uniform(0.0, 0.08)))
    if kind is OFF_ROADER and rng.random() < 0.3:
        spare = turned(
            lathe([(0.7 * frame.wheel_radius, -0.1), (frame.wheel_radius, -0.07), (frame.wheel_radius, 0.1)], 14),
            0,
            np.pi / 2,
        )
        parts.append(moved(spare, (0.0, 0.85 * draw.belt, -frame.length / 2 - 0.06)))
    if kind in (OFF_ROADER, ESTATE, VAN) and rng.random() < 0.3:
        rail = box(
            (0.05, 0.1, 0.3 * frame.length),
            (width / 2 - tumble - 0.1, frame.height + 0.03, frame.z(0.65 * frame.length)),
        )
        parts.append(both_sides(rail))
    if kind in (COUPE, SEDAN, HATCHBACK) and rng.random() < 0.2:
        height = (frame.height if draw.deck < 0.2 else lid + 0.12) + 0.02
        wing = cushion((0.85 * frame.width, 0.04, 0.3), (0.0, height, frame.z(frame.length - 0.12)), 0.01)
        post = box((0.06, 0.24, 0.12), (0.3 * frame.width, height - 0.12, frame.z(frame.length - 0.16)))
        parts += [wing, both_sides(post)]
    return joined(*parts)


def _cab(rng: Generator, kind: Kind, floor_share: float) -> tuple[Measures, float, float, list[Mesh]]:
    """Hull, cab and wheels of a car that carries its load behind: measures, cab's rear station, floor height, parts."""
    draw = draw_measures(rng, kind)
    frame = draw.frame
    rear_foot = max(frame.length - draw.deck, draw.hood + draw.windscreen + draw.rear_window + 0.7)
    floor = max(floor_share * draw.belt, 2.2 * frame.wheel_radius + 0.06)
    outline = [*nose(draw), (rear_foot, draw.belt), *tail(draw, rear_foot + 0.02, floor)]
    parts = [
        hull(frame, outline, draw.rounding, draw.shoulder),
        cabin(frame, roof(rng, draw, rear_foot, draw.belt), draw.belt, 0.94 * frame.width, rng.uniform(0.04, 0.18)),
        wheels(draw.frame),
    ]
    return draw, rear_foot, floor, parts


def _pickup(rng: Generator) -> Mesh:
    draw, rear_foot, floor, parts = _cab(rng, PICKUP, 0.72)
    frame = draw.frame
    rim = max(draw.belt * rng.uniform(0.92, 1.04), floor + 0.18)
    parts.append(bed(frame, rear_foot + 0.04, frame.length, floor, rim))
    if rng.random() < 0.15:
        length = frame.length - rear_foot - 0.1
        canopy = box(
            (0.92 * frame.width, frame.height - rim + 0.05, length),
            (0.0, (frame.height + rim) / 2, frame.z(rear_foot + length / 2 + 0.05)),
            (0.88, 0.95),
        )
        parts.append(canopy)
    elif rng.random() < 0.25:
        x, z = 0.42 * frame.width, frame.z(rear_foot + 0.2)
        parts.append(tube([(-x, floor, z), (-x, frame.height, z), (x, frame.height, z), (x, floor, z)], 0.05, 6))
    if rng.random() < 0.5:
        parts.append(bumpers(frame, frame.clearance + 0.22, rng.uniform(0.02, 0.1)))
    return joined(*parts)


def _truck(rng: Generator) -> Mesh:
    draw, rear_foot, floor, parts = _cab(rng, TRUCK, 0.7)
    frame = draw.frame
    start, end = rear_foot + rng.uniform(0.05, 0.3), frame.length + 0.02
    if rng.random() < 0.7:
        height = rng.uniform(1.3, 2.3)
        size = (frame.width * rng.uniform(0.98, 1.1), height, end - start)
        parts.append(box(size, (0.0, floor + height / 2, frame.z((start + end) / 2))))
    else:
        parts.append(bed(frame, start, end, floor, floor + rng.uniform(0.25, 0.6)))
    return joined(*parts)
