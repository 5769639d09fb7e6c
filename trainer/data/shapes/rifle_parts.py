"""The parts of a rifle: spars that run along it, grips and magazines that hang from it, barrels, sights, bipods.

The muzzle points to +Z, the bore's axis is the line x = y = 0, and the trigger is at z = 0.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, loft, moved, ring, tube, turned

Knot = tuple[float, float, float, float]
"""A section: its place, its two ends across, and half its width, metres."""


def along(knots: Sequence[Knot], roundness: float = 3.0, points: int = 12) -> Mesh:
    """A spar through upright sections (z, low, high, half width): stock, receiver, handguard."""
    table: Float64[ndarray, "K 4"] = np.array(knots, np.float64)
    return loft(_sections(table, roundness, points)[..., [0, 2, 1]])


def down(knots: Sequence[Knot], roundness: float = 4.0, points: int = 12) -> Mesh:
    """A body through level sections (y, rear, front, half width): grip, magazine, sight."""
    table: Float64[ndarray, "K 4"] = np.array(knots, np.float64)
    return loft(_sections(table, roundness, points))


def _sections(table: Float64[ndarray, "K 4"], roundness: float, points: int) -> Float64[ndarray, "K N 3"]:
    """Superellipses across the second axis: half width along the first, from end to end along the third."""
    unit = ring(1.0, 1.0, 0.0, points, roundness)
    rings = np.empty((len(table), points, 3))
    rings[..., 0] = unit[:, 0] * table[:, 3:]
    rings[..., 1] = table[:, :1]
    rings[..., 2] = (table[:, 1:2] + table[:, 2:3]) / 2 + unit[:, 2] * (table[:, 2:3] - table[:, 1:2]) / 2
    return rings


def pipe(profile: Sequence[tuple[float, float]], y: float = 0.0, x: float = 0.0, points: int = 12) -> Mesh:
    """A solid of revolution along the bore: (radius, z) pairs."""
    return moved(turned(lathe(profile, points), 0, np.pi / 2), (x, y, 0.0))


def barrel(start: float, end: float, radius: tuple[float, float], y: float = 0.0, x: float = 0.0) -> Mesh:
    """A barrel that tapers from its chamber to an open muzzle."""
    first, last = radius
    return pipe(
        [(first, start), (first, start + 0.05), (last, end), (0.6 * last, end), (0.55 * last, end - 0.03)], y, x
    )


def muzzle_device(rng: Generator, end: float, radius: float) -> Mesh:
    """A flash hider, a brake with two steps, or a silencer."""
    match int(rng.integers(0, 3)):
        case 0:
            return pipe([(1.2 * radius, end - 0.01), (1.5 * radius, end), (1.7 * radius, end + 0.05)])
        case 1:
            high, low, z = 2.2 * radius, 1.3 * radius, end - 0.01
            return pipe(
                [(high, z), (high, z + 0.02), (low, z + 0.025), (low, z + 0.035), (high, z + 0.04), (high, z + 0.065)]
            )
        case _:
            length = rng.uniform(0.12, 0.22)
            return pipe(
                [(0.017, end - 0.03), (0.021, end - 0.02), (0.021, end - 0.02 + length), (0.017, end - 0.01 + length)]
            )


def scope(rng: Generator, centre: float, base: float, size: float) -> Mesh:
    """A telescopic sight on two mounts that stand at the height `base`; `size` 1 is a hunter's."""
    half, bell = rng.uniform(0.13, 0.19) * size, rng.uniform(0.021, 0.03) * size
    radius, y = 0.0155 * size, base + bell + rng.uniform(0.002, 0.008)
    profile = [
        (1.25 * radius, centre - half),
        (1.35 * radius, centre - 0.72 * half),
        (radius, centre - 0.55 * half),
        (radius, centre + 0.35 * half),
        (bell, centre + 0.65 * half),
        (bell, centre + half),
        (0.85 * bell, centre + half),
        (0.8 * bell, centre + 0.9 * half),
    ]
    turret = 1.9 * radius
    parts = [
        pipe(profile, y),
        cylinder((0.0, y, centre), (0.0, y + turret + 0.006, centre), 0.75 * radius, 10),
        cylinder((-turret, y, centre), (turret, y, centre), 0.75 * radius, 10),
    ]
    for z in (centre - 0.38 * half, centre + 0.28 * half):
        parts.append(box((1.5 * radius, y - base + 0.01, 0.02), (0.0, (y + base - 0.01) / 2, z)))
    return joined(*parts)


def red_dot(centre: float, base: float, length: float) -> Mesh:
    """A short sight on a rail."""
    body = pipe([(0.02, centre - length / 2), (0.023, centre), (0.02, centre + length / 2)], base + 0.03)
    return joined(body, box((0.024, 0.03, 0.7 * length), (0.0, base + 0.01, centre)))


def iron_sight(z: float, base: float, height: float) -> Mesh:
    """A post on a foot."""
    return down([(base - 0.01, z - 0.022, z + 0.018, 0.009), (base + height, z - 0.007, z + 0.005, 0.007)])


def carrying_handle(rear: float, front: float, base: float, height: float) -> Mesh:
    """A bridge over the receiver that holds the rear sight."""
    top = base + height
    bridge = along([(rear, top - 0.018, top, 0.011), (front, top - 0.018, top - 0.004, 0.011)], 6.0)
    posts = [
        down([(base - 0.01, z - 0.022, z + 0.022, 0.012), (top - 0.004, z - 0.016, z + 0.016, 0.011)])
        for z in (rear + 0.016, front - 0.016)
    ]
    return joined(bridge, *posts)


def trigger_guard(z: float, y: float, length: float = 0.075, depth: float = 0.034) -> Mesh:
    """A bow below the height `y`, and the trigger inside it."""
    front, rear = z + 0.6 * length, z - 0.4 * length
    path = [(0.0, y + 0.01, front), (0.0, y - 0.8 * depth, front - 0.012), (0.0, y - depth, z), (0.0, y + 0.01, rear)]
    hook = down([(y + 0.005, z - 0.006, z + 0.006, 0.004), (y - 0.7 * depth, z + 0.002, z + 0.01, 0.004)])
    return joined(tube(path, 0.0055, 6), hook)


def pistol_grip(z: float, y: float, height: float, rake: float, half: float = 0.016) -> Mesh:
    """A grip whose front edge starts at the point (y, z) and runs back by `rake` metres."""
    rows = ((0.02, 0.0, 0.046, 1.0), (-0.2, 0.15, 0.042, 1.0), (-0.75, 0.8, 0.044, 1.1), (-1.0, 1.0, 0.05, 1.0))
    return down(
        [(y + up * height, z - back * rake - deep, z - back * rake, wide * half) for up, back, deep, wide in rows], 2.8
    )


def magazine(z: float, y: float, depth: float, length: float, rake: float, bend: float, half: float = 0.0135) -> Mesh:
    """A box magazine centred under the point (y, z); `rake` and `bend`, radians, lean and curve its foot forward."""
    rings = []
    steps = np.linspace(0.0, 1.0, 6 if bend else 2)
    angles = rake + bend * steps
    places = np.concatenate(([0.0], np.cumsum(np.diff(steps) * depth * np.sin((angles[1:] + angles[:-1]) / 2))))
    heights = np.concatenate(([0.0], np.cumsum(np.diff(steps) * depth * np.cos((angles[1:] + angles[:-1]) / 2))))
    section = ring(half, length / 2, 0.0, 12, 6.0)
    for angle, place, height in zip(angles, places, heights, strict=True):
        lifted = section[:, 2] * np.sin(angle)
        rings.append(np.stack((section[:, 0], y - height + lifted, z + place + section[:, 2] * np.cos(angle)), -1))
    return loft(np.stack(rings))


def drum(z: float, y: float, radius: float, half: float) -> Mesh:
    """A round magazine across the bore."""
    profile = [(0.85 * radius, -half), (radius, -0.8 * half), (radius, 0.8 * half), (0.85 * radius, half)]
    return moved(turned(lathe(profile, 18), 2, -np.pi / 2), (0.0, y, z))


def bipod(z: float, y: float, height: float, spread: float, forward: float) -> Mesh:
    """Two legs with feet, under a block at the point (y, z)."""
    foot = (spread, y - height, z + forward)
    legs = joined(
        tube([(0.012, y, z), foot], (0.009, 0.0065), 8), box((0.024, 0.012, 0.034), (foot[0], foot[1] + 0.006, foot[2]))
    )
    return joined(box((0.04, 0.026, 0.04), (0.0, y, z)), both_sides(legs))


def bolt_handle(z: float, half: float, reach: float = 0.055) -> Mesh:
    """The bolt's lever, on the right side, with a knob."""
    end = (-half - reach, -0.55 * reach, z - 0.25 * reach)
    knob = pipe([(0.005, -0.01), (0.0105, -0.003), (0.0105, 0.003), (0.005, 0.01)], points=8)
    return joined(tube([(-0.5 * half, 0.006, z), (-half - 0.012, 0.003, z), end], 0.006, 6), moved(knob, end))


def hammer(half: float) -> Mesh:
    """A flintlock's cock on the right side of a stock `half` as wide."""
    x = -half - 0.004
    return tube([(x, -0.02, -0.03), (x, 0.035, -0.045), (x, 0.042, -0.01)], 0.0085, 6)


def rail(rear: float, front: float, y: float) -> Mesh:
    """A toothed rail on top."""
    count = max(3, round((front - rear) / 0.035))
    pitch = (front - rear) / count
    teeth = [box((0.02, 0.007, 0.5 * pitch), (0.0, y + 0.008, rear + (i + 0.5) * pitch)) for i in range(count)]
    return joined(box((0.02, 0.012, front - rear), (0.0, y, (rear + front) / 2)), *teeth)


def sights(rng: Generator, rear: float, front: float, top: float, post: float) -> list[Mesh]:
    """What one aims with on a receiver `top` high from `rear` to `front`; `post` is the z of the front sight."""
    middle = (rear + front) / 2
    match int(rng.integers(0, 4)):
        case 0:
            return [
                carrying_handle(rear + 0.02, min(front, rear + 0.2), top, rng.uniform(0.045, 0.065)),
                iron_sight(post, 0.0, top + 0.045),
            ]
        case 1:
            size = rng.uniform(0.75, 1.1)
            return [rail(rear + 0.01, front, top + 0.004), scope(rng, middle, top + 0.014, size)]
        case 2:
            sight = red_dot(middle, top + 0.014, rng.uniform(0.06, 0.11))
            return [rail(rear + 0.01, front, top + 0.004), sight, iron_sight(post, 0.0, top + 0.03)]
        case _:
            return [iron_sight(rear + 0.06, top, 0.022), iron_sight(post, 0.0, top + 0.025)]
