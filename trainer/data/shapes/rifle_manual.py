"""Rifles and shotguns that a hand loads for each shot: bolt, lever, pump, hinge, flint."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.rifle_parts import (
    along,
    barrel,
    bipod,
    bolt_handle,
    down,
    hammer,
    iron_sight,
    magazine,
    muzzle_device,
    pipe,
    pistol_grip,
    rail,
    scope,
    trigger_guard,
)
from trainer.data.shapes.rifle_stocks import StockStyle, butt, full_stock, shoulder_stock
from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, tube


def make_hunting(rng: Generator) -> Mesh:
    """A bolt action in a wooden stock, mostly under a telescopic sight."""
    pull, tip, half = rng.uniform(0.33, 0.39), rng.uniform(0.36, 0.52), rng.uniform(0.021, 0.028)
    muzzle, radius = tip + rng.uniform(0.08, 0.32), rng.uniform(0.0095, 0.0135)
    if rng.random() < 0.2:
        tip = muzzle - rng.uniform(0.02, 0.1)
    parts = [
        full_stock(rng, pull, tip, half, straight=rng.random() < 0.25),
        pipe([(0.013, -0.075), (0.0185, -0.06), (0.0185, 0.16), (radius + 0.003, 0.18)], 0.008),
        barrel(0.14, muzzle, (radius + 0.003, radius), 0.008),
        bolt_handle(-0.03, 0.016),
        trigger_guard(0.0, -0.05),
    ]
    if rng.random() < 0.35:
        parts.append(magazine(0.1, -0.03, rng.uniform(0.045, 0.08), 0.07, 0.0, 0.0))
    if rng.random() < 0.68:
        parts.append(scope(rng, 0.06, 0.024, rng.uniform(0.9, 1.2)))
    else:
        parts += [iron_sight(muzzle - 0.03, radius + 0.008, 0.02), iron_sight(0.22, 0.018, 0.018)]
    if rng.random() < 0.1:
        parts.append(bipod(tip - 0.04, -0.03, rng.uniform(0.16, 0.22), 0.08, 0.02))
    return joined(*parts)


def make_sniper(rng: Generator) -> Mesh:
    """A heavy barrel, a large telescopic sight, most on a bipod."""
    heavy = rng.random() < 0.3
    size = rng.uniform(1.15, 1.35) if heavy else rng.uniform(0.95, 1.1)
    pull, front = rng.uniform(0.34, 0.4), rng.uniform(0.3, 0.46) * size
    muzzle, radius = front + rng.uniform(0.2, 0.42) * size, rng.uniform(0.012, 0.017) * size
    low, half = -0.05 * size, rng.uniform(0.023, 0.028) * size
    chassis = along(
        [
            (-0.13, low, 0.018 * size, 0.8 * half),
            (-0.1, low, 0.026 * size, half),
            (0.18, low, 0.026 * size, half),
            (0.2, 0.9 * low, 0.012, half),
            (front, 0.7 * low, 0.01, 0.9 * half),
        ],
        4.5,
    )
    styles: tuple[StockStyle, ...] = ("thumbhole", "skeleton", "fixed", "sliding")
    style = styles[int(rng.integers(0, 4))]
    parts = [chassis, shoulder_stock(rng, style, pull, -0.12, -0.012)]
    if style != "thumbhole":
        parts.append(pistol_grip(-0.03, low + 0.005, rng.uniform(0.085, 0.1), rng.uniform(0.02, 0.05)))
    if rng.random() < 0.6:
        cheek = rng.uniform(0.02, 0.035)
        parts.append(along([(-pull + 0.04, -0.01, cheek, 0.016), (-pull + 0.16, -0.01, cheek, 0.016)], 3.0))
    parts += [
        barrel(0.17, muzzle, (1.15 * radius, radius), 0.004),
        magazine(0.11, low + 0.01, rng.uniform(0.05, 0.11) * size, 0.08 * size, 0.0, 0.0, 0.6 * half),
        trigger_guard(0.0, low),
        bolt_handle(-0.05, 0.8 * half),
        rail(-0.08, 0.16, 0.026 * size),
        scope(rng, 0.05, 0.036 * size, rng.uniform(1.1, 1.4)),
    ]
    if rng.random() < 0.75:
        reach = rng.uniform(0.17, 0.26) * size
        parts.append(bipod(front - 0.03, 0.7 * low, reach, rng.uniform(0.07, 0.13), rng.uniform(-0.02, 0.06)))
    if rng.random() < 0.7:
        parts.append(muzzle_device(rng, muzzle, radius))
    return joined(*parts)


def make_lever(rng: Generator) -> Mesh:
    """A flat receiver with a finger lever, and a tube of cartridges under the barrel."""
    pull, muzzle, radius = rng.uniform(0.33, 0.37), rng.uniform(0.5, 0.78), rng.uniform(0.011, 0.0135)
    half, wood = rng.uniform(0.02, 0.025), rng.uniform(0.3, 0.42)
    under = -0.028
    receiver = along([(-0.09, -0.05, 0.0, 0.8 * half), (-0.05, -0.055, 0.02, half), (0.12, -0.05, 0.022, half)], 6.0)
    fore_end = along(
        [(0.11, -0.05, 0.002, 1.15 * half), (0.5 * wood, -0.052, 0.002, 1.2 * half), (wood, -0.044, 0.0, half)], 2.6
    )
    loop = rng.uniform(0.04, 0.07)
    lever = [
        (0.0, -0.045, 0.04),
        (0.0, -0.085, 0.03),
        (0.0, -0.09, -0.02),
        (0.0, -0.075 - 0.3 * loop, -0.05),
        (0.0, -0.06 - loop, -0.1),
        (0.0, -0.055 - 0.8 * loop, -0.15),
        (0.0, -0.058, -0.14),
    ]
    eight_sided = pipe(
        [(radius, 0.1), (0.95 * radius, muzzle), (0.6 * radius, muzzle), (0.55 * radius, muzzle - 0.03)], points=8
    )
    parts = [
        butt(rng, pull, half * 1.15, -0.09),
        receiver,
        fore_end,
        eight_sided if rng.random() < 0.5 else barrel(0.1, muzzle, (1.1 * radius, radius)),
        pipe([(0.0095, 0.1), (0.0095, muzzle - rng.choice([0.02, 0.2]))], under + 0.004),
        tube(lever, 0.006, 6),
        down([(-0.04, 0.0, 0.008, 0.004), (-0.075, 0.004, 0.01, 0.004)]),
        down([(0.0, -0.08, -0.055, 0.006), (0.035, -0.1, -0.08, 0.006)]),
        iron_sight(muzzle - 0.025, radius, 0.018),
    ]
    if rng.random() < 0.25:
        parts.append(scope(rng, 0.03, 0.022, 0.95))
    else:
        parts.append(iron_sight(0.2, radius, 0.016))
    return joined(*parts)


def make_pump(rng: Generator) -> Mesh:
    """A shotgun with a tube under the barrel and a fore-end that slides on it."""
    pull, muzzle, radius = rng.uniform(0.33, 0.38), rng.uniform(0.5, 0.8), rng.uniform(0.0125, 0.015)
    half, start, length = rng.uniform(0.02, 0.025), rng.uniform(0.2, 0.28), rng.uniform(0.14, 0.2)
    under, reach = -0.033, muzzle - rng.choice([0.03, rng.uniform(0.15, 0.25)])
    receiver = along([(-0.09, -0.05, 0.004, 0.8 * half), (-0.06, -0.056, 0.02, half), (0.15, -0.054, 0.022, half)], 4.0)
    ribs = np.linspace(start, start + length, 8)
    slide = along([(z, under - 0.024, 0.0, (1.1 if i % 2 else 1.2) * half) for i, z in enumerate(ribs)], 2.6)
    parts = [
        receiver,
        slide,
        barrel(0.13, muzzle, (1.2 * radius, radius), 0.002),
        pipe([(0.0125, 0.12), (0.0125, max(reach, start + length + 0.02))], under),
        trigger_guard(0.0, -0.052),
        iron_sight(muzzle - 0.02, radius, 0.014),
    ]
    choice = rng.random()
    if choice < 0.6:
        parts += [
            butt(rng, pull, half, -0.09),
            down([(-0.04, -0.12, -0.05, 0.8 * half), (-0.1, -0.135, -0.085, 0.75 * half)]),
        ]
    else:
        parts.append(pistol_grip(-0.045, -0.045, 0.1, 0.05, 0.017))
        if choice < 0.85:
            parts.append(shoulder_stock(rng, "sliding" if choice < 0.75 else "wire", pull, -0.09, -0.02))
    return joined(*parts)


def make_double(rng: Generator) -> Mesh:
    """A shotgun with two barrels, side by side or one over the other, hinged at the receiver."""
    pull, muzzle, radius = rng.uniform(0.34, 0.38), rng.uniform(0.62, 0.82), rng.uniform(0.0115, 0.0135)
    over, half, wood = rng.random() < 0.5, rng.uniform(0.023, 0.028), rng.uniform(0.26, 0.34)
    if rng.random() < 0.15:
        muzzle = wood + rng.uniform(0.04, 0.1)
    low = -0.062 if over else -0.045
    receiver = along([(-0.1, -0.05, -0.004, 0.7 * half), (-0.06, low, 0.01, half), (0.06, low, 0.014, half)], 4.0)
    fore_end = along(
        [
            (0.06, low - 0.004, -0.004, half),
            (0.5 * wood, low - 0.004, -0.006, 1.05 * half),
            (wood, low + 0.018, -0.01, 0.7 * half),
        ],
        2.6,
    )
    if over:
        barrels = joined(*(barrel(0.04, muzzle, (1.15 * radius, radius), y) for y in (0.0, -1.95 * radius)))
    else:
        barrels = both_sides(barrel(0.04, muzzle, (1.1 * radius, 0.95 * radius), 0.0, 0.98 * radius))
    parts = [butt(rng, pull, half, -0.1), receiver, fore_end, barrels, trigger_guard(0.0, low + 0.004, 0.085)]
    parts.append(box((0.006, 0.008, muzzle - 0.05), (0.0, 0.95 * radius, 0.04 + (muzzle - 0.05) / 2)))
    if rng.random() < 0.6:
        parts.append(down([(-0.04, -0.13, -0.06, 0.75 * half), (-0.095, -0.138, -0.1, 0.7 * half)]))
    if not over and rng.random() < 0.4:
        parts.append(both_sides(tube([(0.012, -0.005, -0.05), (0.012, 0.028, -0.075)], (0.007, 0.004), 6)))
    return joined(*parts)


def make_musket(rng: Generator) -> Mesh:
    """A long muzzle loader, stocked almost to the muzzle, with a lock on its right side; at times a bayonet."""
    pull, muzzle = rng.uniform(0.34, 0.4), rng.uniform(0.6, 0.92)
    half, radius = rng.uniform(0.027, 0.032), rng.uniform(0.0135, 0.017)
    tip = muzzle - rng.choice([0.04, 0.08, 0.35 * muzzle])
    parts = [
        full_stock(rng, pull, tip, half, straight=True),
        barrel(-0.06, muzzle, (1.3 * radius, radius), 0.008),
        trigger_guard(0.0, -0.05, 0.1),
        box((0.012, 0.034, 0.15), (-half - 0.001, -0.022, 0.0)),
        hammer(half),
        cylinder((0.0, 0.003 - radius, 0.15), (0.0, 0.003 - radius, muzzle - 0.01), 0.005, 6),
    ]
    if rng.random() < 0.5:
        parts.append(box((0.012, 0.05, 0.012), (-half, 0.018, 0.04), (1.0, 0.4)))
    for share in (0.45, 0.7, 0.95)[: int(rng.integers(1, 4))]:
        z = share * tip
        parts.append(along([(z, -0.05, 0.026, 1.02 * half), (z + 0.022, -0.05, 0.026, 1.0 * half)], 2.6))
    if rng.random() < 0.25:
        long = rng.uniform(0.22, 0.34)
        parts.append(along([(muzzle - 0.06, -0.008, 0.026, 0.018), (muzzle + 0.01, -0.008, 0.026, 0.018)], 2.0))
        blade = [(0.0, 0.0, muzzle - 0.02), (0.0, -0.03, muzzle + 0.02), (0.0, -0.03, muzzle + long)]
        parts.append(tube(blade, (0.011, 0.003), 6))
    return joined(*parts)
