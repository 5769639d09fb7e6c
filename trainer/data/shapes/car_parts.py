"""The parts of a car: hull with wheel arches, cabin, wheels, bed, trim.

Distances along a car are given as `station`: metres behind the tip of its nose. `Frame.z` turns them into the object
frame, where the car drives towards +Z.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray

from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, joined, lathe, loft, moved, turned


class Frame(NamedTuple):
    """The measures that all parts share, metres."""

    length: float
    width: float
    height: float
    clearance: float
    """From the ground to the sill."""
    wheel_radius: float
    wheel_width: float
    front_axle: float
    """Station of the front axle."""
    rear_axle: float
    """Station of the rear axle."""

    def z(self, station: float) -> float:
        return self.length / 2 - station


def hull(frame: Frame, top: list[tuple[float, float]], rounding: float, shoulder: float) -> Mesh:
    """The lower body: (station, height) of its upper edge from nose to tail; arches cut over the wheels.

    `rounding` 0..1 narrows the ends in plan, `shoulder` 0..1 bevels the upper edge.
    """
    first, last = top[0][0], top[-1][0]
    arch = 1.14 * frame.wheel_radius
    cuts = [
        station + side * arch * reach
        for station in (frame.front_axle, frame.rear_axle)
        for side in (-1, 1)
        for reach in (1.004, 0.996, 0.8, 0.35)
    ]
    ends = [first + 0.1, first + 0.3, last - 0.25, last - 0.08]
    stations = np.unique([station for station in [*(s for s, _ in top), *cuts, *ends] if first <= station <= last])
    upper_edge = np.array(top)
    high = np.interp(stations, upper_edge[:, 0], upper_edge[:, 1])
    plan = np.interp(
        stations,
        (first, first + 0.1, first + 0.3, first + 0.7, last - 0.6, last - 0.25, last - 0.08, last),
        1 - rounding * np.array([0.34, 0.18, 0.06, 0.0, 0.0, 0.04, 0.12, 0.24]),
    )
    rise = np.interp(stations, (first, first + 0.25, last - 0.3, last), (0.35, 0.0, 0.0, 0.35)) * frame.wheel_radius
    low = frame.clearance + rise
    for axle in (frame.front_axle, frame.rear_axle):
        inside = np.abs(stations - axle) < arch
        over = frame.wheel_radius + np.sqrt(np.maximum(arch**2 - (stations - axle) ** 2, 0.0))
        low = np.where(inside, np.maximum(low, over), low)
    low = np.minimum(low, high - 0.06)
    outline = ((0.93, 0.0), (0.985, 0.1), (1.0, 0.45), (0.985, 0.8), (1 - 0.12 * shoulder, 0.95), (0.72, 1.0))
    sides = np.array([*outline, *((-x, y) for x, y in outline[::-1])])
    rings = np.empty((len(stations), len(sides), 3))
    rings[..., 0] = sides[:, 0] * (plan * frame.width / 2)[:, None]
    rings[..., 1] = low[:, None] + sides[:, 1] * (high - low)[:, None]
    rings[..., 2] = (frame.length / 2 - stations)[:, None]
    inner = frame.width - 2.3 * frame.wheel_width
    floor = (frame.front_axle - 0.5 * arch, frame.rear_axle + 0.5 * arch)
    size = (inner, frame.wheel_radius * 1.3, floor[1] - floor[0])
    centre = (0.0, frame.clearance + size[1] / 2, frame.z(sum(floor) / 2))
    return joined(loft(rings), box(size, centre))


def cabin(frame: Frame, roof: list[tuple[float, float]], belt: float, width: float, tumble: float) -> Mesh:
    """What stands on the hull: (station, height) of its outline from windscreen foot to rear window foot.

    `width` is its width at the height `belt`; it loses 2·`tumble` of that up to the roof.
    """
    top = max(height for _, height in roof)
    rings = []
    for station, height in roof:
        share = max(height - belt, 0.0) / max(top - belt, 1e-6)
        foot, head = width / 2, width / 2 - tumble * share
        edge = min(0.06, 0.3 * max(height - belt, 0.0)) + 1e-3
        half = [(foot, belt - 0.2), (foot, belt), (head, max(height - edge, belt + 1e-3)), (head - 0.12, height + 2e-3)]
        z = frame.z(station)
        rings.append([*((x, y, z) for x, y in half), *((-x, y, z) for x, y in half[::-1])])
    return loft(np.array(rings))


def wheel(frame: Frame, station: float) -> Mesh:
    """A pair of wheels on one axle, with recessed rims."""
    radius, width, outer = frame.wheel_radius, frame.wheel_width, frame.width / 2 - 0.01
    profile = (
        (0.86 * radius, 0.0),
        (radius, 0.12 * width),
        (radius, 0.88 * width),
        (0.88 * radius, width),
        (0.68 * radius, width),
        (0.6 * radius, 0.8 * width),
    )
    tyre = turned(lathe(profile, 14), 2, -np.pi / 2)
    return both_sides(moved(tyre, (outer - width, radius, frame.z(station))))


def wheels(frame: Frame) -> Mesh:
    """The wheels on both axles."""
    return joined(wheel(frame, frame.front_axle), wheel(frame, frame.rear_axle))


def bed(frame: Frame, start: float, end: float, floor: float, rim: float) -> Mesh:
    """The walls of an open cargo bed between two stations."""
    wall, length, height = 0.07, end - start, rim - floor + 0.1
    middle = (rim + floor - 0.1) / 2
    side = box((wall, height, length), ((frame.width - wall) / 2 - 0.01, middle, frame.z((start + end) / 2)))
    across = frame.width - 0.04
    gates = [box((across, height, wall), (0.0, middle, frame.z(s))) for s in (start + wall / 2, end - wall / 2)]
    return joined(both_sides(side), *gates)


def windscreen(frame: Frame, foot: float, belt: float, top: float, run: float, width: float) -> Mesh:
    """A free-standing screen that leans back by `run` over its height."""
    corners = np.array([(-width / 2, belt - 0.05), (width / 2, belt - 0.05), (0.43 * width, top), (-0.43 * width, top)])
    lean = np.array([0.0, 0.0, run, run])
    rings = [np.stack((corners[:, 0], corners[:, 1], frame.z(foot + offset) - lean), -1) for offset in (0.0, 0.06)]
    return loft(np.stack(rings))


def mirrors(frame: Frame, station: float, height: float) -> Mesh:
    """A wing mirror on either side."""
    return both_sides(box((0.2, 0.14, 0.1), (frame.width / 2 + 0.06, height, frame.z(station))))


def bumpers(frame: Frame, height: float, reach: float) -> Mesh:
    """Bars across both ends that stand out by `reach`."""
    size = (0.9 * frame.width, 0.16, 0.3)
    ends = (frame.length / 2 - 0.15 + reach, -frame.length / 2 + 0.15 - reach)
    return joined(*(cushion(size, (0.0, height, end), 0.03, 6.0) for end in ends))


def rounded(points: list[tuple[float, float]], steps: int = 2) -> list[tuple[float, float]]:
    """An open outline with its inner corners cut off (Chaikin), so that it bends instead of folding."""
    outline: Float64[ndarray, "N 2"] = np.array(points)
    for _ in range(steps):
        near, far = 0.8 * outline[:-1] + 0.2 * outline[1:], 0.2 * outline[:-1] + 0.8 * outline[1:]
        inner = np.stack((near, far), 1).reshape(-1, 2)[1:-1]
        outline = np.concatenate((outline[:1], inner, outline[-1:]))
    return [(float(station), float(height)) for station, height in outline]
