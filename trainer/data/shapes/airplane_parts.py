"""The parts of an aeroplane: lifting surfaces and their outlines, bodies, engines, propellers, undercarriage.

It flies towards +Z. Parts that come in pairs are made for the left side, +X; whoever puts them together mirrors them.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, Point, both_sides, box, cylinder, joined, lathe, loft, moved, ring, turned

Station = tuple[float, float, float, float]
"""A place along a wing: x, y and z of the leading edge, and the chord behind it, metres."""

Knot = tuple[float, float, float, float]
"""A section of a body: z, half the width, half the height, and the height of its centre, metres."""

_BACK = (1 - np.cos(np.linspace(0.0, np.pi, 7))) / 2
# The four-digit NACA thickness, whose trailing edge is blunt.
_SMOOTH, _ROUND = np.polyval([-0.1015, 0.2843, -0.3516, -0.126, 0.0], _BACK), np.sqrt(_BACK)


def surface(stations: Sequence[Station], thickness: float, camber: float = 0.0) -> Mesh:
    """A wing, fin or tailplane through aerofoil sections from root to tip; `thickness` and `camber` are shares of the
    chord.

    Sections stand across the leading edge as it is seen from the front: the same call makes a wing and a fin.
    """
    table: Float64[ndarray, "S 4"] = np.array(stations, np.float64)
    runs = np.diff(table[:, :2], axis=0)
    runs /= np.linalg.norm(runs, axis=1, keepdims=True)
    along = np.concatenate((runs[:1], runs[:-1] + runs[1:], runs[-1:]))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    above = np.stack((-along[:, 1], along[:, 0]), -1)
    half = 5 * thickness * _SMOOTH
    half += 5 * thickness * 0.2969 * _ROUND
    mean = 4 * camber * _BACK * (1 - _BACK)
    behind = np.concatenate((_BACK, _BACK[:0:-1]))
    height = np.concatenate((mean + half, (mean - half)[:0:-1]))
    rings = np.empty((len(table), len(behind), 3))
    rings[..., :2] = table[:, None, :2] + (table[:, 3:] * height)[..., None] * above[:, None]
    rings[..., 2] = table[:, 2:3] - table[:, 3:] * behind
    return loft(rings)


def tapered(
    root: Point, reach: float, chords: tuple[float, float], sweep: float, dihedral: float = 0.0, kink: float = 0.0
) -> list[Station]:
    """The outline of half a wing of span `reach`: straight edges from root to tip chord, and a rounded tip.

    `sweep` of the leading edge and `dihedral` are radians. With a `kink`, a share of the span, the trailing edge runs
    straight across inside of it, so that the root chord grows, as on airliners.
    """
    x, y, z = root
    chord, tip = chords
    lead, rise = np.tan(sweep), np.tan(dihedral)

    def at(share: float) -> Station:
        out = share * reach
        return (x + out, y + rise * out, z - lead * out, chord + share * (tip - chord))

    first, last = at(0.0), at(1.0)
    stations = [first]
    if kink:
        broken = at(kink)
        stations = [(x, y, z, z - broken[2] + broken[3]), broken]
    rounding = min(0.16 * tip, 0.08 * reach)
    end = (last[0] + rounding, last[1] + rise * rounding, last[2] - lead * rounding - 0.25 * tip, 0.55 * tip)
    return [*stations, last, end]


def station_at(stations: Sequence[Station], x: float) -> Station:
    """The wing at the distance `x` from the plane of symmetry."""
    table = np.array(stations)
    _, y, z, chord = (float(np.interp(x, table[:, 0], column)) for column in table.T)
    return (x, y, z, chord)


def with_winglet(stations: list[Station], height: float) -> list[Station]:
    """The outline with its rounded tip bent upwards."""
    x, y, z, chord = stations[-2]
    bend = (x + 0.25 * height, y + 0.2 * height, z - 0.25 * chord, 0.75 * chord)
    return [*stations[:-1], bend, (x + 0.45 * height, y + height, z - 0.75 * chord, 0.35 * chord)]


def elliptical(root: Point, reach: float, chord: float, dihedral: float) -> list[Station]:
    """The outline of half a wing whose chord falls as an ellipse about its quarter-chord line."""
    x, y, z = root
    shares = np.sin(np.array([0.0, 0.2, 0.4, 0.6, 0.78, 0.92, 0.985]) * np.pi / 2)
    chords = chord * np.sqrt(1 - shares**2)
    rise = np.tan(dihedral)
    return [
        (float(x + s * reach), float(y + rise * s * reach), float(z - 0.25 * (chord - c)), float(c))
        for s, c in zip(shares, chords, strict=True)
    ]


def fin(base: Point, height: float, chords: tuple[float, float], sweep: float, cant: float = 0.0) -> list[Station]:
    """The outline of an upright surface that leans to its side by `cant` radians."""
    flat = tapered((0.0, 0.0, base[2]), height, chords, sweep)
    return [
        (base[0] + out * float(np.sin(cant)), base[1] + out * float(np.cos(cant)), z, chord)
        for out, _, z, chord in flat
    ]


def body(
    knots: Sequence[Knot] | Float64[ndarray, "K 4"], roundness: float = 2.0, steps: int = 1, points: int = 16
) -> Mesh:
    """A fuselage, canopy or float through superellipse sections; `steps` times its corners are cut off."""
    table: Float64[ndarray, "K 4"] = np.array(knots, np.float64)
    for _ in range(steps):
        near, far = 0.75 * table[:-1] + 0.25 * table[1:], 0.25 * table[:-1] + 0.75 * table[1:]
        table = np.concatenate((table[:1], np.stack((near, far), 1).reshape(-1, 4)[1:-1], table[-1:]))
    unit = ring(1.0, 1.0, 0.0, points, roundness)
    rings = np.empty((len(table), points, 3))
    rings[..., 0] = unit[:, 0] * table[:, 1:2]
    rings[..., 1] = unit[:, 2] * table[:, 2:3] + table[:, 3:]
    rings[..., 2] = table[:, :1]
    return loft(rings)


def canopy(front: float, length: float, half_width: float, height: float, base: float, peak: float = 0.4) -> Mesh:
    """A bubble of glass: it starts at z = `front` and is highest at the share `peak` of its length."""
    shares = (0.0, 0.4 * peak, peak, peak + 0.45 * (1 - peak), 1.0)
    sizes = (0.12, 0.75, 1.0, 0.75, 0.1)
    return body([(front - s * length, k * half_width, k * height, base) for s, k in zip(shares, sizes, strict=True)])


def nacelle(centre: Point, radius: float, length: float) -> Mesh:
    """A jet engine's cowling with an open intake and a cone behind."""
    profile = [
        (0.7 * radius, 0.3 * length),
        (0.82 * radius, 0.47 * length),
        (0.9 * radius, 0.5 * length),
        (radius, 0.4 * length),
        (0.98 * radius, 0.1 * length),
        (0.72 * radius, -0.32 * length),
        (0.5 * radius, -0.34 * length),
        (0.15 * radius, -0.5 * length),
    ]
    return moved(turned(lathe(profile, 16), 0, np.pi / 2), centre)


def nozzle(centre: Point, radius: float, length: float) -> Mesh:
    """A jet pipe that narrows towards its open end, at `centre`."""
    profile = [(radius, length), (radius, 0.6 * length), (0.8 * radius, 0.0), (0.62 * radius, 0.0)]
    return moved(turned(lathe([*profile, (0.6 * radius, 0.35 * length)], 14), 0, np.pi / 2), centre)


def store(nose: tuple[float, float, float], length: float, radius: float) -> Mesh:
    """A missile or drop tank on a pylon under the wing's point `nose`."""
    x, y, z = nose
    low = y - 2.4 * radius
    sizes = ((0.5, 0.1), (0.38, 0.8), (0.2, 1.0), (-0.3, 1.0), (-0.5, 0.4))
    round_body = body([(z + s * length, k * radius, k * radius, low) for s, k in sizes], points=8)
    return joined(
        moved(round_body, (x, 0.0, 0.0)), box((0.5 * radius, 2.4 * radius, 0.35 * length), (x, y - 1.2 * radius, z))
    )


def propeller(centre: Point, radius: float, blades: int, phase: float, pusher: bool = False) -> Mesh:
    """Spinner and twisted blades; `phase` is the first blade's angle from upright, radians."""
    hub, width = 0.15 * radius, 0.17 * radius
    cone = lathe([(hub, -hub), (hub, 0.0), (0.8 * hub, 0.9 * hub), (0.15 * hub, 2.0 * hub)], 10)
    parts = [turned(cone, 0, -np.pi / 2 if pusher else np.pi / 2)]
    blade = turned(box((width, radius, 0.045 * radius), (0.0, radius / 2, 0.0), (0.55, 0.6)), 1, 0.5)
    parts += [turned(blade, 2, phase + turn) for turn in np.arange(blades) * 2 * np.pi / blades]
    return moved(joined(*parts), centre)


def wheel(centre: Point, radius: float, width: float) -> Mesh:
    """A tyre that rolls along z."""
    half = width / 2
    profile = [(0.6 * radius, -half), (0.9 * radius, -half), (radius, -0.5 * half)]
    profile += [(r, -y) for r, y in profile[::-1]]
    return moved(turned(lathe(profile, 14), 2, -np.pi / 2), centre)


def leg(top: Point, ground: Point, radius: float, strut: float, spat: bool = False) -> Mesh:
    """A strut from `top` to a wheel that stands on the point `ground`, at times under a fairing."""
    axle = (ground[0], ground[1] + radius, ground[2])
    parts = [cylinder(top, axle, strut, 8), wheel(axle, radius, 0.55 * radius)]
    if spat:
        sizes = ((1.5, 0.15), (1.1, 0.75), (0.0, 1.0), (-1.2, 0.7), (-2.2, 0.12))
        fairing = body([(a * radius, 0.42 * k * radius, 0.72 * k * radius, 0.2 * radius) for a, k in sizes])
        parts.append(moved(fairing, axle))
    return joined(*parts)


def light_tail(rng: Generator, length: float, base: float, span: float, t_tail: bool = False) -> list[Mesh]:
    """Fin and tailplane at the end of a body of `length` that is centred on z = 0."""
    chord, height = length * rng.uniform(0.11, 0.15), length * rng.uniform(0.13, 0.18)
    upright = fin((0.0, base, -0.49 * length + chord), height, (chord, 0.55 * chord), rng.uniform(0.15, 0.75))
    root = (0.0, base, -0.48 * length + 0.9 * chord)
    if t_tail:
        _, y, z, _ = upright[-2]
        root = (0.0, y, z + 0.1 * chord)
    level = tapered(root, span, (0.85 * chord, 0.55 * chord), rng.uniform(0.0, 0.3))
    return [surface(upright, 0.12), both_sides(surface(level, 0.12))]


def fixed_gear(rng: Generator, length: float, half: float, low: float) -> Mesh:
    """Two legs under the cabin and a third wheel under nose or tail."""
    radius, spat = length * rng.uniform(0.026, 0.036), rng.random() < 0.4
    ground, nose_wheel = low - length * rng.uniform(0.06, 0.09), rng.random() < 0.65
    x, z = half * rng.uniform(1.5, 2.1), (0.02 if nose_wheel else 0.2) * length
    main = both_sides(leg((0.5 * half, low + 0.3 * half, z), (x, ground, z), radius, 0.007 * length, spat))
    if nose_wheel:
        top, foot = (0.0, low + 0.3 * half, 0.36 * length), (0.0, ground, 0.37 * length)
        third = leg(top, foot, 0.85 * radius, 0.007 * length, spat)
    else:
        third = leg((0.0, 0.0, -0.44 * length), (0.0, 0.35 * low, -0.47 * length), 0.4 * radius, 0.006 * length)
    return joined(main, third)


def propeller_pod(x: float, y: float, z: float, radius: float, length: float, blades: int, phase: float) -> Mesh:
    """A propeller and the pod behind it, whose nose is at (x, y, z)."""
    sizes = ((0.0, 0.55), (0.1, 0.95), (0.4, 1.0), (0.75, 0.7), (1.0, 0.15))
    pod = body([(z - s * length, k * radius, 1.1 * k * radius, y) for s, k in sizes], 2.3)
    return joined(moved(pod, (x, 0.0, 0.0)), propeller((x, y, z + 0.02 * length), 2.7 * radius, blades, phase))
