"""Chairs: on four legs, on a pedestal, on a sled, upholstered armchairs, and one in eight that is unusual."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.chair_parts import (
    BACK_STYLES,
    Seat,
    arms,
    back,
    legs,
    panel,
    pedestal,
    rockers,
    seat_slab,
    sled,
)
from trainer.data.shapes.solid import Mesh, both_sides, box, cushion, joined, lathe, loft, moved, tube, turned


def make_chair(rng: Generator) -> Mesh:
    """One chair, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.44, _four_legged),
        (0.15, _pedestal_chair),
        (0.13, _sled_chair),
        (0.16, _armchair),
        (0.03, _rocking_chair),
        (0.03, _tub_chair),
        (0.03, _bar_chair),
        (0.02, _throne),
        (0.02, _folded_board),
    )
    shares = np.array([share for share, _ in builders])
    return builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)


def _seat(rng: Generator, height: tuple[float, float] = (0.4, 0.5)) -> Seat:
    width = rng.uniform(0.36, 0.58)
    depth = width * rng.uniform(0.85, 1.1)
    roundness = float(rng.choice([2.0, 4.0, 10.0, 10.0]))
    return Seat(width, depth, rng.uniform(*height), rng.uniform(0.025, 0.09), roundness)


def _upper(rng: Generator, seat: Seat, bar: float, arm_share: float) -> list[Mesh]:
    """Seat, back and perhaps arms."""
    height, recline = rng.uniform(0.25, 0.75), rng.uniform(0.0, 0.32)
    style = BACK_STYLES[rng.integers(len(BACK_STYLES))]
    parts = [seat_slab(rng, seat), back(rng, seat, style, height, recline, bar)]
    if rng.random() < arm_share and height > 0.3:
        parts.append(arms(rng, seat, bar, closed=rng.random() < 0.25))
    return parts


def _four_legged(rng: Generator) -> Mesh:
    seat, bar = _seat(rng), rng.uniform(0.025, 0.065)
    return joined(*_upper(rng, seat, bar, 0.35), legs(rng, seat, bar, square=rng.random() < 0.6))


def _pedestal_chair(rng: Generator) -> Mesh:
    seat, bar = _seat(rng), rng.uniform(0.02, 0.04)
    return joined(*_upper(rng, seat, bar, 0.5), pedestal(rng, seat))


def _sled_chair(rng: Generator) -> Mesh:
    seat, bar = _seat(rng), rng.uniform(0.02, 0.045)
    return joined(*_upper(rng, seat, bar, 0.4), sled(rng, seat, bar, square=rng.random() < 0.4))


def _armchair(rng: Generator) -> Mesh:
    """Upholstered: a thick seat between thick arms, low on the floor."""
    arm, inner, depth = rng.uniform(0.08, 0.22), rng.uniform(0.48, 0.66), rng.uniform(0.6, 0.85)
    seat, arm_height = rng.uniform(0.34, 0.46), rng.uniform(0.5, 0.68)
    rest, top, recline = rng.uniform(0.12, 0.24), rng.uniform(0.68, 1.1), rng.uniform(0.0, 0.25)
    gap = rng.choice([0.0, 1.0]) * rng.uniform(0.06, 0.16)
    width, bevel = inner + 2 * arm, rng.uniform(0.01, 0.06)
    outline = float(rng.choice([5.0, 12.0]))
    base = cushion((inner + 0.02, seat - gap, depth), (0.0, (seat + gap) / 2, 0.0), 0.02, 14.0)
    lying = cushion((top - gap, rest, width - 0.4 * arm), (0.0, 0.0, 0.0), min(bevel, 0.05), outline)
    upright = moved(turned(turned(lying, 0, np.pi / 2), 2, np.pi / 2), (0.0, (top + gap) / 2, (rest - depth) / 2))
    parts = [base, turned(upright, 0, -recline, (0.0, gap + 0.1, (rest - depth) / 2))]
    with_arms = rng.random() < 0.85
    if with_arms:
        side = cushion((arm, arm_height - gap, depth), ((inner + arm) / 2, (arm_height + gap) / 2, 0.0), bevel, 14.0)
        parts.append(both_sides(side))
    if gap:
        reach = 0.46 * width if with_arms else 0.46 * inner
        post = tube([(reach, 0.0, 0.44 * depth), (0.96 * reach, gap + 0.05, 0.41 * depth)], (0.018, 0.03), 8)
        parts += [both_sides(post), both_sides(Mesh(post.vertices * (1.0, 1.0, -1.0), post.faces[:, ::-1]))]
    if rng.random() < 0.3:
        pad = rng.uniform(0.08, 0.14)
        parts.append(cushion((inner, pad, depth - rest), (0.0, seat + pad / 2 - 0.02, rest / 2), 0.04, 8.0))
    return joined(*parts)


def _rocking_chair(rng: Generator) -> Mesh:
    seat, bar = _seat(rng), rng.uniform(0.03, 0.05)
    return joined(*_upper(rng, seat, bar, 0.8), rockers(rng, seat, bar))


def _tub_chair(rng: Generator) -> Mesh:
    """A shell that runs around the sitter and falls towards the front."""
    radius, seat, top = rng.uniform(0.28, 0.4), rng.uniform(0.36, 0.44), rng.uniform(0.72, 1.05)
    front, thickness, flare = seat + rng.uniform(0.02, 0.2), rng.uniform(0.03, 0.1), rng.uniform(1.0, 1.15)
    low = rng.choice([0.04, seat - 0.1])
    open_half = rng.uniform(0.6, 0.95)
    rings = []
    for angle in np.linspace(open_half, 2 * np.pi - open_half, 21):
        share = (1 - np.cos(angle)) / 2
        height = front + (top - front) * share**1.5
        outer = radius * np.array([1.0, flare, flare, 1.0]) + thickness * np.array([-0.5, -0.5, 0.5, 0.5])
        rings.append(np.stack((outer * np.sin(angle), np.array([low, height, height, low]), outer * np.cos(angle)), -1))
    round_seat = lathe([(radius, max(low, seat - 0.14)), (radius, seat - 0.02), (radius - 0.03, seat)], 24)
    support = Seat(1.5 * radius, 1.5 * radius, seat - 0.05, 0.06, 10.0)
    if low < 0.1:
        under = box((radius, seat - 0.1, radius), (0.0, (seat - 0.1) / 2, 0.0))
    else:
        under = pedestal(rng, support) if rng.random() < 0.5 else legs(rng, support, 0.035, square=False)
    return joined(loft(np.stack(rings)), round_seat, under)


def _bar_chair(rng: Generator) -> Mesh:
    """High, with a low back."""
    seat, bar = _seat(rng, (0.62, 0.8)), rng.uniform(0.025, 0.045)
    style = BACK_STYLES[rng.integers(len(BACK_STYLES))]
    rest = back(rng, seat, style, rng.uniform(0.18, 0.4), rng.uniform(0.0, 0.2), bar)
    under = pedestal(rng, seat) if rng.random() < 0.3 else legs(rng, seat, bar, square=rng.random() < 0.5)
    return joined(seat_slab(rng, seat), rest, under)


def _throne(rng: Generator) -> Mesh:
    """A solid block with a tall back."""
    width, depth, seat = rng.uniform(0.5, 0.7), rng.uniform(0.45, 0.6), rng.uniform(0.42, 0.52)
    top, side = rng.uniform(1.2, 1.7), rng.uniform(0.06, 0.12)
    rest = moved(panel(width, 0.0, top, 0.08, 0.0, rng.uniform(0.0, 0.35)), (0.0, 0.0, -depth / 2 + 0.04))
    block = box((width, seat, depth), (0.0, seat / 2, 0.0))
    arm = box((side, rng.uniform(0.2, 0.3), depth), ((width - side) / 2, seat + 0.1, 0.0))
    return joined(block, rest, both_sides(arm))


def _folded_board(rng: Generator) -> Mesh:
    """One bent board: foot, front, seat and back in a single run."""
    width, depth, seat = rng.uniform(0.38, 0.5), rng.uniform(0.38, 0.48), rng.uniform(0.4, 0.46)
    thickness, lean = rng.uniform(0.025, 0.05), rng.uniform(0.0, 0.3)
    foot = rng.uniform(-0.5, 0.45) * depth
    top = (seat + rng.uniform(0.35, 0.5), -depth / 2 - rng.uniform(0.02, 0.15))
    run = [(0.0, -depth / 2), (0.0, depth / 2 - lean * 0.1), (seat, foot), (seat + 0.02, depth / 2)]
    path = run if rng.random() < 0.4 else [(0.0, -depth / 2), (0.0, depth / 2), (seat, depth / 2)]
    path = [*path[:3], (seat - 0.02, -depth / 2), top]
    boards = []
    for (y0, z0), (y1, z1) in pairwise(path):
        along = np.array([y1 - y0, z1 - z0])
        along = along / np.linalg.norm(along)
        across = thickness / 2 * np.array([along[1], -along[0]])
        start, end = np.array([y0, z0]) - thickness / 2 * along, np.array([y1, z1]) + thickness / 2 * along
        outline = np.stack((start + across, end + across, end - across, start - across))
        boards.append(loft(np.stack([np.insert(outline, 0, x, axis=1) for x in (-width / 2, width / 2)])))
    return joined(*boards)
