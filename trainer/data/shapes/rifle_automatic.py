"""Rifles that load themselves: assault rifles, submachine guns, machine guns."""

from numpy.random import Generator

from trainer.data.shapes.rifle_parts import (
    along,
    barrel,
    bipod,
    down,
    drum,
    iron_sight,
    magazine,
    muzzle_device,
    pipe,
    pistol_grip,
    rail,
    red_dot,
    sights,
    trigger_guard,
)
from trainer.data.shapes.rifle_stocks import STOCK_STYLES, shoulder_stock
from trainer.data.shapes.solid import Mesh, box, joined, tube


def make_assault(rng: Generator) -> Mesh:
    """Receiver, pistol grip, magazine before the trigger, handguard, short barrel."""
    half, low, top = rng.uniform(0.017, 0.023), rng.uniform(-0.062, -0.048), rng.uniform(0.022, 0.032)
    rear, front = rng.uniform(-0.13, -0.1), rng.uniform(0.11, 0.15)
    guard = front + rng.uniform(0.14, 0.32)
    muzzle = guard + rng.uniform(0.05, 0.22)
    pull, girth = rng.uniform(0.27, 0.37), rng.uniform(0.022, 0.031)
    radius = rng.uniform(0.009, 0.0125)
    receiver = along(
        [(rear, low + 0.012, top - 0.004, half), (rear + 0.03, low, top, half), (front, low, top, half)], 5.0
    )
    well = down([(low + 0.02, 0.035, 0.12, half), (low - 0.025, 0.04, 0.115, 0.95 * half)], 6.0)
    style = STOCK_STYLES[int(rng.integers(0, 5))]
    curved = rng.random() < 0.6
    depth, bend = rng.uniform(0.09, 0.19), rng.uniform(0.25, 0.85) if curved else 0.0
    parts = [
        receiver,
        well,
        _handguard(rng, front - 0.01, guard, girth),
        barrel(front, muzzle, (radius + 0.002, radius)),
        shoulder_stock(rng, style, pull, rear, -0.004),
        pistol_grip(-0.025, low + 0.01, rng.uniform(0.085, 0.105), rng.uniform(0.025, 0.06)),
        magazine(0.078, low - 0.005, depth, rng.uniform(0.058, 0.078), rng.uniform(0.0, 0.2), bend),
        trigger_guard(0.0, low + 0.003, 0.07),
        *sights(rng, rear, front, top, min(guard + 0.03, muzzle - 0.03)),
    ]
    if rng.random() < 0.55:
        parts.append(muzzle_device(rng, muzzle, radius))
    if rng.random() < 0.4:
        parts.append(pipe([(0.0115, front - 0.01), (0.0115, guard + 0.03)], 0.026))
        parts.append(along([(guard + 0.01, -0.008, 0.036, 0.012), (guard + 0.04, -0.008, 0.034, 0.012)], 4.0))
    match int(rng.integers(0, 10)):
        case 0 | 1:
            foot = (-girth - 0.09, guard - 0.098, guard - 0.068, 0.015)
            parts.append(down([(-0.8 * girth, guard - 0.1, guard - 0.06, 0.014), foot], 2.6))
        case 2:
            launcher = [
                (0.02, front + 0.01),
                (0.023, front + 0.03),
                (0.023, guard),
                (0.02, guard + 0.01),
                (0.015, guard),
            ]
            parts.append(pipe(launcher, -girth - 0.016))
        case 3:
            parts.append(bipod(guard - 0.02, -0.8 * girth, rng.uniform(0.16, 0.22), 0.08, 0.02))
    return joined(*parts)


def _handguard(rng: Generator, start: float, end: float, girth: float) -> Mesh:
    """Round, square, or bellied around barrel and gas tube."""
    match int(rng.integers(0, 3)):
        case 0:
            rows = ((start, 1.0), (end - 0.02, 0.9), (end, 0.7))
            return along([(z, -k * girth, k * girth, k * girth) for z, k in rows], 2.0)
        case 1:
            rails = [box((0.018, 0.008, end - start - 0.02), (0.0, y, (start + end) / 2)) for y in (-girth, girth)]
            tunnel = along([(z, -girth, girth, 0.9 * girth) for z in (start, end)], 5.0, 16)
            return joined(tunnel, *rails)
        case _:
            belly = 1.35 * girth
            return along(
                [
                    (start, -belly, girth, 0.8 * girth),
                    ((start + end) / 2, -1.1 * belly, 0.95 * girth, 0.95 * girth),
                    (end, -0.8 * girth, 0.8 * girth, 0.75 * girth),
                ],
                2.8,
            )


def make_submachine(rng: Generator) -> Mesh:
    """Short: a tube or box with a long straight magazine, or a drum."""
    boxy, half = rng.random() < 0.5, rng.uniform(0.017, 0.022)
    low, top = (-0.045, 0.03) if boxy else (-0.035, 0.024)
    rear, front = rng.uniform(-0.15, -0.09), rng.uniform(0.12, 0.24)
    muzzle, radius = front + rng.uniform(0.04, 0.2), rng.uniform(0.009, 0.012)
    body = along([(rear, low, top, half), (front, low, top, half)], 6.0 if boxy else 2.2, 14)
    frame = along([(-0.09, low - 0.03, low + 0.02, 0.85 * half), (0.1, low - 0.03, low + 0.02, 0.85 * half)], 5.0)
    z = float(rng.choice([-0.045, rng.uniform(0.06, 0.1), rng.uniform(0.06, 0.1)]))
    parts = [body, frame, barrel(front - 0.02, muzzle, (1.2 * radius, radius)), trigger_guard(0.01, low - 0.026, 0.07)]
    grip, depth = rng.uniform(0.085, 0.105), rng.uniform(0.13, 0.22)
    if z < 0:
        # The grip is the magazine's well.
        parts.append(pistol_grip(-0.022, low - 0.025, grip, 0.008, 0.018))
        parts.append(magazine(z, low - 0.04, depth, 0.032, 0.05, 0.0))
    else:
        parts.append(pistol_grip(-0.025, low - 0.025, grip, rng.uniform(0.02, 0.05)))
        if rng.random() < 0.3:
            parts.append(drum(z, low - 0.065, rng.uniform(0.055, 0.08), rng.uniform(0.02, 0.028)))
        else:
            rake, bend = rng.uniform(-0.1, 0.15), rng.choice([0.0, 0.35])
            parts.append(magazine(z, low - 0.01, depth, rng.uniform(0.034, 0.046), rake, bend))
    choice = rng.random()
    if choice < 0.9:
        style = STOCK_STYLES[int(rng.integers(0, 5))]
        parts.append(shoulder_stock(rng, style, rng.uniform(0.25, 0.36), rear, -0.004))
    if rng.random() < 0.4 and front > z + 0.12:
        fore = (low - 0.01, front - 0.07, front - 0.03, 0.016)
        parts.append(down([fore, (low - 0.1, front - 0.075, front - 0.035, 0.016)], 2.6))
    elif not boxy:
        parts.append(along([(z + 0.03, low - 0.012, 0.0, 1.1 * half), (front + 0.02, low - 0.008, 0.0, half)], 2.6))
    if rng.random() < 0.3:
        parts += [rail(rear + 0.02, front - 0.02, top + 0.004), red_dot(0.0, top + 0.014, rng.uniform(0.05, 0.08))]
    else:
        parts += [iron_sight(rear + 0.04, top, 0.02), iron_sight(front - 0.02, top, 0.025)]
    if rng.random() < 0.35:
        parts.append(muzzle_device(rng, muzzle, radius))
    return joined(*parts)


def make_machine_gun(rng: Generator) -> Mesh:
    """Belt-fed from a box, a heavy barrel over a gas tube, on a bipod."""
    half, low, top = rng.uniform(0.024, 0.03), rng.uniform(-0.075, -0.06), rng.uniform(0.032, 0.042)
    rear, front, pull = -0.12, rng.uniform(0.14, 0.2), rng.uniform(0.32, 0.4)
    muzzle, radius = front + rng.uniform(0.36, 0.55), rng.uniform(0.012, 0.016)
    style = STOCK_STYLES[int(rng.choice([0, 2, 4]))]
    guard = front + rng.uniform(0.1, 0.2)
    deep, wide = rng.uniform(0.08, 0.14), rng.uniform(0.03, 0.045)
    parts = [
        along([(rear, low + 0.015, top - 0.006, half), (rear + 0.04, low, top, half), (front, low, top, half)], 5.0),
        along([(front - 0.01, -0.048, 0.018, half), (guard, -0.044, 0.014, 0.9 * half)], 3.0),
        barrel(front, muzzle, (1.3 * radius, radius)),
        pipe([(0.0125, front), (0.0125, muzzle - 0.16), (0.009, muzzle - 0.14)], -0.034),
        box((0.03, 0.06, 0.03), (0.0, -0.018, muzzle - 0.16)),
        shoulder_stock(rng, style, pull, rear, -0.012),
        pistol_grip(-0.03, low + 0.01, 0.095, rng.uniform(0.02, 0.05), 0.018),
        trigger_guard(0.0, low + 0.003, 0.07),
        box((2 * wide, deep, 0.1), (0.3 * wide, low - deep / 2 + 0.01, 0.09)),
        bipod(muzzle - rng.uniform(0.12, 0.3), -0.03, rng.uniform(0.2, 0.27), rng.uniform(0.09, 0.14), 0.03),
        tube([(0.0, 0.01, front + 0.05), (0.0, 0.075, front + 0.04), (0.0, 0.075, front + 0.13)], 0.009, 8),
        iron_sight(muzzle - 0.05, radius, 0.045),
        iron_sight(0.0, top, 0.025),
    ]
    if rng.random() < 0.5:
        parts.append(muzzle_device(rng, muzzle, radius))
    return joined(*parts)
