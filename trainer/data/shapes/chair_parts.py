"""The parts of a chair: backs, arms, and what carries the seat.

Each part stands upright behind or under a seat whose upper face lies at `Seat.height`; the chair faces +Z.
"""

from typing import Literal, NamedTuple

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, cylinder, joined, lathe, loft, moved, tube, turned


class Seat(NamedTuple):
    """The measures that all parts share, metres."""

    width: float
    depth: float
    height: float
    """Of the face to sit on, above the floor."""
    thickness: float
    roundness: float
    """Of its outline: 2 is round, 10 nearly a rectangle."""


BackStyle = Literal["solid", "padded", "slatted", "ladder", "open", "spindles", "splat"]
BACK_STYLES: tuple[BackStyle, ...] = ("solid", "padded", "slatted", "ladder", "open", "spindles", "splat")


def seat_slab(rng: Generator, seat: Seat) -> Mesh:
    """The seat, at times with a cushion on it."""
    size, centre = (seat.width, seat.thickness, seat.depth), (0.0, seat.height - seat.thickness / 2, 0.0)
    slab = cushion(size, centre, min(0.02, 0.3 * seat.thickness), seat.roundness)
    if rng.random() < 0.3:
        pad = rng.uniform(0.03, 0.08)
        size = (0.94 * seat.width, pad, 0.92 * seat.depth)
        return joined(slab, cushion(size, (0.0, seat.height + pad / 2 - 0.01, 0.01), 0.4 * pad, seat.roundness))
    return slab


def back(rng: Generator, seat: Seat, style: BackStyle, height: float, recline: float, bar: float) -> Mesh:
    """A backrest of `height` metres that leans back by `recline` radians; `bar` is its posts' thickness."""
    width, low = seat.width * rng.uniform(0.82, 1.02), seat.height - 0.02
    curve, arch = rng.choice([0.0, 0.06, 0.12]) * rng.random(), rng.choice([0.0, 0.3]) * rng.random()
    top = low + height
    match style:
        case "solid" | "padded":
            thickness = rng.uniform(0.02, 0.05) if style == "solid" else rng.uniform(0.07, 0.16)
            gap = rng.choice([0.0, 0.3]) * rng.random() * height
            parts = [panel(width, low + gap, top, thickness, curve, arch)]
            if gap > 0.02:
                parts.append(_posts(width * 0.8, low, top - 0.3 * (height - gap), bar))
        case "slatted":
            rail = rng.uniform(0.05, 0.14)
            parts = [_posts(width, low, top - 0.02, bar), panel(width, top - rail, top, bar * 0.9, curve, arch)]
            parts.append(panel(width, low + 0.08, low + 0.12, bar * 0.8, curve, 0.0))
            count, share = int(rng.integers(2, 6)), rng.uniform(0.3, 0.65)
            slat = share * width / count
            for index in range(count):
                x = ((index + 0.5) / count - 0.5) * (width - bar)
                z = curve * (2 * x / width) ** 2
                parts.append(box((slat, height - rail - 0.06, 0.018), (x, low + (height - rail + 0.14) / 2, z)))
        case "ladder":
            parts = [_posts(width, low, top + rng.uniform(0.0, 0.05), bar)]
            count, share = int(rng.integers(2, 6)), rng.uniform(0.35, 0.6)
            pitch = height * 0.88 / count
            for index in range(count):
                end = top - index * pitch
                parts.append(panel(width, end - share * pitch, end, 0.025, curve, arch * 0.5))
        case "open":
            rail = rng.uniform(0.05, 0.12)
            parts = [_posts(width, low, top, bar), panel(width, top - rail, top, bar, curve, arch)]
            if rng.random() < 0.6:
                middle = low + height * rng.uniform(0.35, 0.6)
                parts.append(panel(width, middle - rail / 2, middle + rail / 2, bar * 0.8, curve, 0.0))
        case "spindles":
            angle = np.linspace(0.0, np.pi, 11)
            bow = np.stack((width / 2 * np.cos(angle), low + 0.55 * height * (1 + np.sin(angle) * 0.8), 0 * angle), -1)
            path = np.concatenate(([(width / 2 * 0.9, low, 0.0)], bow, [(-width / 2 * 0.9, low, 0.0)]))
            parts = [tube(path, 0.5 * bar, 8)]
            for share in np.linspace(-0.7, 0.7, int(rng.integers(4, 8))):
                x, reach = share * width / 2, 0.55 * height * (1 + 0.8 * np.sqrt(1 - share**2))
                parts.append(cylinder((0.85 * x, low, 0.0), (x, low + reach, 0.0), 0.25 * bar, 6))
        case "splat":
            rail = rng.uniform(0.06, 0.12)
            parts = [_posts(width, low, top - 0.02, bar), panel(width, top - rail, top, bar, curve, arch)]
            splat = width * rng.uniform(0.2, 0.4)
            waist = rng.uniform(0.5, 1.0)
            levels = np.linspace(low, top - rail / 2, 5)
            widths = splat * np.array([1.0, waist, 1.15, waist, 1.1]) / 2
            parts.append(
                loft(
                    np.stack(
                        [
                            np.stack(
                                (half * np.array([-1, 1, 1, -1]), np.full(4, y), np.array([-0.01, -0.01, 0.01, 0.01])),
                                -1,
                            )
                            for half, y in zip(widths, levels, strict=True)
                        ]
                    )
                )
            )
    upright = moved(joined(*parts), (0.0, 0.0, -seat.depth / 2 + bar / 2 + 0.005))
    return turned(upright, 0, -recline, (0.0, low, -seat.depth / 2))


def panel(width: float, low: float, high: float, thickness: float, curve: float, arch: float) -> Mesh:
    """A board across the back: `curve` metres of bend around the sitter, upper edge lowered at the sides by `arch`."""
    rings = []
    for share in np.linspace(-1.0, 1.0, 9 if curve or arch else 2):
        top, front = high - arch * (high - low) * share**4, curve * share**2
        y, z = np.array([low, low, top, top]), front + thickness / 2 * np.array([-1, 1, 1, -1])
        rings.append(np.stack((np.full(4, share * width / 2), y, z), -1))
    return loft(np.stack(rings))


def _posts(width: float, low: float, top: float, bar: float) -> Mesh:
    return both_sides(box((bar, top - low, bar), ((width - bar) / 2, (low + top) / 2, 0.0)))


def arms(rng: Generator, seat: Seat, bar: float, closed: bool) -> Mesh:
    """Armrests: boards on front posts, or closed sides down to the seat."""
    height, reach = rng.uniform(0.17, 0.27), seat.depth * rng.uniform(0.75, 1.0)
    breadth, x = rng.uniform(0.035, 0.08), seat.width / 2
    centre = -seat.depth / 2 + reach / 2
    y = seat.height + height
    rest = cushion((breadth, 0.035, reach), (x, y, centre), 0.01, 6.0)
    if closed:
        side = box(
            (0.6 * breadth, height + seat.thickness, reach * 0.95), (x, y - (height + seat.thickness) / 2, centre)
        )
        return both_sides(joined(rest, side))
    front = centre + reach / 2 - bar / 2 - rng.choice([0.0, 0.4]) * rng.random() * reach
    post = tube(
        [(x - 0.01, seat.height - 0.8 * seat.thickness, front), (x, y, front)], 0.45 * bar, 8, square=rng.random() < 0.5
    )
    return both_sides(joined(rest, post))


def legs(rng: Generator, seat: Seat, bar: float, square: bool) -> Mesh:
    """Four legs, plumb or splayed, straight or tapered, with or without stretchers."""
    foot, splay = bar * rng.uniform(0.45, 1.0), rng.choice([0.0, 1.0]) * rng.uniform(0.0, 0.1)
    rake = splay * rng.uniform(0.3, 1.2)
    inset = 0.5 * bar + (0.0 if seat.roundness > 4 else 0.14 * seat.width)
    x, z, y = seat.width / 2 - inset, seat.depth / 2 - inset, seat.height - 0.6 * seat.thickness
    front = tube([(x + splay, 0.0, z + rake), (x, y, z)], (foot / 2, bar / 2), 8, square)
    rear = tube([(x + splay, 0.0, -z - rake), (x, y, -z)], (foot / 2, bar / 2), 8, square)
    parts = [front, rear]
    if rng.random() < 0.5:
        level = rng.uniform(0.2, 0.6)
        at, to = x + splay * (1 - level), z + rake * (1 - level)
        parts.append(tube([(at, level * y, -to), (at, level * y, to)], 0.3 * bar, 6, square))
        if rng.random() < 0.5:
            parts.append(tube([(0.0, level * y, 0.0), (at, level * y, 0.0)], 0.3 * bar, 6, square))
        else:
            parts += [tube([(0.0, level * y, end), (at, level * y, end)], 0.3 * bar, 6, square) for end in (-to, to)]
    return both_sides(joined(*parts))


def pedestal(rng: Generator, seat: Seat) -> Mesh:
    """One column on a star of castors, a disc, or a flared foot."""
    y, column = seat.height - 0.5 * seat.thickness, rng.uniform(0.02, 0.045)
    reach = rng.uniform(0.2, 0.32)
    match int(rng.integers(0, 3)):
        case 0:
            count = int(rng.choice([4, 5, 5]))
            spokes = [
                cylinder((0.0, 0.11, 0.0), (reach * np.sin(a), 0.06, reach * np.cos(a)), 0.022, 6)
                for a in np.arange(count) * 2 * np.pi / count
            ]
            castors = [
                cylinder(
                    (reach * np.sin(a) - 0.018, 0.032, reach * np.cos(a)),
                    (reach * np.sin(a) + 0.018, 0.032, reach * np.cos(a)),
                    0.032,
                    8,
                )
                for a in np.arange(count) * 2 * np.pi / count
            ]
            return joined(
                lathe([(column * 1.3, 0.07), (column * 1.3, 0.2), (column * 0.8, 0.21), (column * 0.8, y)], 10),
                *spokes,
                *castors,
            )
        case 1:
            return lathe([(reach, 0.0), (reach, 0.02), (column * 1.2, 0.04), (column, 0.06), (column, y)], 20)
        case _:
            heights = np.linspace(0.0, 1.0, 8)
            radii = column + (reach - column) * (1 - heights) ** 4 + 0.5 * reach * heights**6
            return lathe([(float(r), float(h * y)) for r, h in zip(radii, heights, strict=True)], 20)


def sled(rng: Generator, seat: Seat, bar: float, square: bool) -> Mesh:
    """Two runners: closed loops, or a cantilever that leaves the rear free."""
    x, z, y = seat.width / 2 - bar, seat.depth / 2 - bar, seat.height - 0.5 * seat.thickness
    foot = bar / 2
    if rng.random() < 0.5:
        lean = rng.uniform(0.0, 0.08)
        path = [(x, y, -z), (x, foot, -z - lean), (x, foot, z + lean), (x, y, z)]
        return both_sides(tube(path, bar / 2, 8, square))
    path = [(x, y, -z), (x, y, z), (x, foot, z - rng.uniform(0.0, 0.06)), (x, foot, -z)]
    runner = tube(path, bar / 2, 8, square)
    across = tube([(0.0, foot, -z), (x, foot, -z)], bar / 2, 8, square)
    return both_sides(joined(runner, across))


def rockers(rng: Generator, seat: Seat, bar: float) -> Mesh:
    """Four legs on two bent runners."""
    x, z, y = seat.width / 2 - bar / 2, seat.depth / 2 - bar / 2, seat.height - 0.5 * seat.thickness
    reach, radius = rng.uniform(1.3, 1.6) * seat.depth / 2 + 0.1, rng.uniform(0.8, 1.3)
    bend = [(x, radius - np.sqrt(radius**2 - s**2) + bar / 2, s) for s in np.linspace(-reach - 0.08, reach, 9)]
    posts = [tube([(x, 0.06, end), (x, y, end)], 0.5 * bar, 8) for end in (-z, z)]
    return both_sides(joined(tube(bend, 0.5 * bar, square=True), *posts))
