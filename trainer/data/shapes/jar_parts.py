"""Turned vessels: a smooth profile, the wall that follows it inside, and the handles and lids that sit on it.

A profile is an array of (radius, y) pairs from the foot up to the lip, y rising throughout. It is swept around +Y with
the section that a `Form` describes, so that the same profile makes round, square, lobed and twisted vessels.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, lathe, loft, superellipse, tube

Profile = Float64[ndarray, "S 2"]


class Form(NamedTuple):
    """The section of a vessel; the default is round."""

    points: int = 24
    """Corners of the section: 24 looks round, 4, 6 and 8 have flat sides."""
    roundness: float = 2.0
    """Of the superellipse: 2 is round, 40 square."""
    depth: float = 1.0
    """Along z, relative to the width along x."""
    lobes: int = 0
    """Ribs around the vessel; 0 for none."""
    relief: float = 0.0
    """How far the ribs stand out, relative to the radius."""
    twist: float = 0.0
    """Turn of the section from foot to lip, radians."""
    lean: float = 0.0
    """How far the lip is moved towards +z, relative to the height."""
    spout: float = 0.0
    """How far the lip is drawn out towards +z, relative to its radius."""


ROUND = Form()


def smooth(points: Sequence[tuple[float, float]], steps: int = 16) -> Profile:
    """A profile through the given (radius, y) points that bends without overshooting."""
    # Here and not above: it takes a quarter of a second to load, and only jars bend.
    from scipy.interpolate import PchipInterpolator  # noqa: PLC0415

    knots = np.array(points)
    length = np.insert(np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1)), 0, 0.0)
    profile: Profile = PchipInterpolator(length, knots)(np.linspace(0.0, length[-1], steps))
    return profile


def straight(points: Sequence[tuple[float, float]]) -> Profile:
    """A profile of straight pieces with sharp edges between them."""
    profile: Profile = np.array(points, np.float64)
    return profile


def vase_profile(rng: Generator, height: float) -> Profile:
    """Baluster, egg, trumpet, cone, globe with a short neck, or double gourd."""
    u = rng.uniform
    match rng.choice(["baluster", "egg", "trumpet", "cone", "globe", "gourd"]):
        case "baluster":
            r = u(0.18, 0.42) * height
            foot, neck = u(0.35, 0.75) * r, u(0.35, 0.6) * r
            points = [(foot, 0.0), (max(u(0.35, 0.6) * r, 0.85 * foot), 0.12), (r, u(0.42, 0.68))]
            points += [(neck, u(0.82, 0.88)), (u(1.0, 1.5) * neck, 1.0)]
        case "egg":
            r = u(0.22, 0.5) * height
            points = [(u(0.4, 0.8) * r, 0.0), (r, u(0.4, 0.65)), (u(0.5, 0.85) * r, 1.0)]
        case "trumpet":
            r = u(0.16, 0.4) * height
            waist = u(0.35, 0.55) * r
            points = [(u(0.6, 1.0) * r, 0.0), (waist, u(0.2, 0.45)), (u(1.05, 1.3) * waist, 0.65), (r, 1.0)]
        case "cone":
            r = u(0.14, 0.38) * height
            foot = u(0.45, 1.0) * r
            points = [(0.92 * foot, 0.0), (foot, 0.05), (0.5 * (foot + r), 0.5), (r, 1.0)]
        case "globe":
            r, top = u(0.42, 0.6) * height, u(0.78, 0.92)
            neck = u(0.3, 0.5) * r
            points = [(u(0.35, 0.6) * r, 0.0), (r, 0.45 * top), (0.78 * r, 0.78 * top)]
            points += [(neck, top), (u(1.0, 1.4) * neck, 1.0)]
        case _:
            r = u(0.25, 0.4) * height
            upper = u(0.55, 0.8) * r
            points = [(0.55 * r, 0.0), (r, 0.28), (u(0.35, 0.5) * r, 0.56), (upper, 0.76), (u(0.4, 0.7) * upper, 1.0)]
    return smooth([(radius, y * height) for radius, y in points])


def shouldered_profile(rng: Generator, height: float) -> Profile:
    """Foot, belly, shoulder, neck and lip of a vessel to carry handles."""
    radius = height * rng.uniform(0.24, 0.42)
    foot, belly, shoulder = rng.uniform(0.22, 0.6), rng.uniform(0.45, 0.62), rng.uniform(0.72, 0.8)
    neck, lip = rng.uniform(0.28, 0.48), rng.uniform(1.05, 1.5)
    points = [(foot * radius, 0.0), (radius, belly * height), (0.8 * radius, shoulder * height)]
    points += [(neck * radius, (shoulder + 0.09) * height), (neck * radius, 0.95 * height)]
    return smooth([*points, (lip * neck * radius, height)], 18)


def solid(profile: Profile, form: Form = ROUND) -> Mesh:
    """The vessel without a cavity."""
    low, high = profile[0, 1], profile[-1, 1]
    radii, heights = profile.T
    return loft(_sections(radii, form.depth * radii, heights, low, high, form))


def hollow(profile: Profile, wall: float, form: Form = ROUND, floor: float = 0.0) -> Mesh:
    """The vessel as one closed wall of at least `wall` metres around an open cavity.

    The cavity ends `floor` metres above the foot, or higher, where a narrow stem leaves it no room.
    """
    low, high = profile[0, 1], profile[-1, 1]
    inside = _cavity(profile, wall, low + max(wall, floor))
    width = np.interp(inside[:, 1], profile[:, 1], profile[:, 0])
    # A flattened vessel's wall is as thick in front as at its sides.
    ratio = np.maximum((form.depth * width - (width - inside[:, 0])) / inside[:, 0], 0.3 * form.depth)
    lip = profile[-1, 0] - 0.35 * wall, inside[0, 0] + 0.25 * wall
    radii = np.concatenate((profile[:, 0], lip, inside[:, 0]))
    depths = np.concatenate((np.full(len(profile) + 1, form.depth), ratio[:1], ratio))
    heights = np.concatenate((profile[:, 1], np.full(2, high + 0.3 * wall), inside[:, 1]))
    return loft(_sections(radii, depths * radii, heights, low, high, form))


def _cavity(profile: Profile, wall: float, floor: float) -> Profile:
    """The inner profile from the lip down: at each height the largest radius that keeps `wall` from the outside."""
    dense_y = np.linspace(profile[0, 1], profile[-1, 1], 80)
    dense_r = np.interp(dense_y, profile[:, 1], profile[:, 0])
    lip, bottom = profile[-1, 1], min(floor, profile[-1, 1] - wall)
    heights = np.linspace(lip, bottom, int(np.clip((lip - bottom) / wall, 3, 14)))
    apart = np.abs(heights[:, None] - dense_y)
    reach = np.where(apart < wall, dense_r - np.sqrt(np.maximum(wall**2 - apart**2, 0.0)), np.inf)
    radii = reach.min(1)
    room = radii > 0.12 * dense_r.max()
    depth = len(room) if room.all() else max(int(np.argmin(room)), 2)
    radii = np.maximum(radii, 0.12 * dense_r.max())
    return np.stack((radii[:depth], heights[:depth]), 1)


def _sections(
    half_x: Float64[ndarray, "S"],
    half_z: Float64[ndarray, "S"],
    y: Float64[ndarray, "S"],
    low: float,
    high: float,
    form: Form,
) -> Float64[ndarray, "S N 3"]:
    """The section at each height, of the given half widths."""
    share = ((y - low) / (high - low))[:, None]
    angle = (np.arange(form.points) + 0.5) * 2 * np.pi / form.points
    reach, cosine, sine = superellipse(form.points, form.roundness)
    if form.lobes:
        # Counted from +z, so that a rib or a groove faces the front and both sides are alike.
        reach = reach * (1 + form.relief * np.cos(form.lobes * (angle - np.pi / 2)))
    if form.spout:
        aside = np.abs(angle - np.pi / 2)
        reach = reach * (1 + form.spout * np.exp(-((aside / 0.5) ** 2)) * np.clip((share - 0.75) / 0.25, 0.0, 1.2))
    if form.twist:
        cosine, sine = np.cos(angle + form.twist * share), np.sin(angle + form.twist * share)
    rings = np.empty((len(y), form.points, 3))
    rings[:, :, 0], rings[:, :, 1] = half_x[:, None] * reach * cosine, y[:, None]
    # Seeds name shapes to the last digit, and ** squares an array otherwise than a number.
    rings[:, :, 2] = half_z[:, None] * reach * sine + form.lean * np.float_power(share, 2) * (high - low)
    return rings


def radius_at(profile: Profile, y: float) -> float:
    """The outer radius at a height."""
    return float(np.interp(y, profile[:, 1], profile[:, 0]))


def handle(profile: Profile, wall: float, low: float, high: float, reach: float, bar: float, rise: float = 0.0) -> Mesh:
    """A bowed handle on the +x side from height `low` to `high`; both ends are sunk into the wall.

    It stands out by `reach` from the wider of its two feet and rises by `rise` above the upper one.
    """
    near, far = radius_at(profile, low) - 0.5 * wall, radius_at(profile, high) - 0.5 * wall
    out = max(near, far) + reach
    shoulder = high + rise
    points = np.array(
        [
            (near, low),
            (near + 0.6 * (out - near), low + 0.12 * (shoulder - low)),
            (out, low + 0.45 * (shoulder - low)),
            (out, low + 0.8 * (shoulder - low)),
            (far + 0.55 * (out - far), shoulder),
            (far, high),
        ]
    )
    from scipy.interpolate import CubicSpline  # noqa: PLC0415

    length = np.insert(np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)), 0, 0.0)
    curve = CubicSpline(length, points)(np.linspace(0.0, length[-1], 10))
    return tube(np.insert(curve, 2, 0.0, axis=1), bar, 8)


def lid(radius: float, y: float, height: float, knob: float) -> Mesh:
    """A domed lid whose edge lies at height `y`, with a knob of radius `knob`, or none at 0."""
    dome = [(radius, y), (radius, y + 0.15 * height), (0.93 * radius, y + 0.35 * height)]
    dome += [(0.75 * radius, y + 0.65 * height), (0.5 * radius, y + 0.87 * height), (0.22 * radius, y + height)]
    if knob:
        top = y + height
        dome += [(0.5 * knob, top + 0.1 * knob), (0.5 * knob, top + 0.6 * knob), (0.95 * knob, top + 1.1 * knob)]
        dome += [(knob, top + 1.6 * knob), (0.6 * knob, top + 2.1 * knob)]
    return lathe(dome, 24)
