"""Rifles of less usual build: the magazine behind the grip or on top, a trumpet's mouth, and a toy."""

from numpy.random import Generator

from trainer.data.shapes.rifle_parts import (
    along,
    barrel,
    carrying_handle,
    down,
    drum,
    hammer,
    magazine,
    muzzle_device,
    pipe,
    pistol_grip,
    rail,
    red_dot,
    sights,
    trigger_guard,
)
from trainer.data.shapes.rifle_stocks import STOCK_STYLES, full_stock, shoulder_stock
from trainer.data.shapes.solid import Mesh, box, joined, tube


def make_bullpup(rng: Generator) -> Mesh:
    """The magazine behind the grip, in a body that is the stock as well."""
    pull, front = rng.uniform(0.3, 0.38), rng.uniform(0.1, 0.2)
    half, top, deep = rng.uniform(0.019, 0.026), rng.uniform(0.024, 0.04), rng.uniform(0.1, 0.14)
    muzzle, radius = front + rng.uniform(0.12, 0.3), rng.uniform(0.01, 0.013)
    sloped = rng.uniform(0.0, 0.03)
    body = along(
        [
            (-pull, top - 0.01 - deep, top - 0.012 - sloped, half),
            (-pull + 0.02, top - deep, top - sloped, 1.05 * half),
            (-pull + 0.12, top - 0.75 * deep, top, half),
            (-0.07, -0.05, top, half),
            (front - 0.05, -0.045, top, 0.95 * half),
            (front, -0.03, 0.75 * top, 0.8 * half),
        ],
        rng.uniform(3.0, 5.0),
        14,
    )
    parts = [
        body,
        barrel(front - 0.02, muzzle, (1.3 * radius, radius)),
        pistol_grip(-0.02, -0.04, rng.uniform(0.085, 0.1), rng.uniform(0.02, 0.05), 0.017),
        magazine(-rng.uniform(0.13, 0.18), -0.045, rng.uniform(0.1, 0.17), 0.066, 0.05, rng.choice([0.0, 0.4])),
    ]
    if rng.random() < 0.4:
        path = [(0.0, -0.035, front - 0.03), (0.0, -0.12, 0.06), (0.0, -0.13, -0.075)]
        parts.append(tube(path, 0.0095, 8))
    else:
        parts.append(trigger_guard(0.01, -0.042, 0.08))
    if rng.random() < 0.45:
        parts.append(carrying_handle(-0.12, front - 0.02, top, rng.uniform(0.045, 0.06)))
    else:
        parts += sights(rng, -0.14, 0.08, top, front - 0.02)
    if rng.random() < 0.35:
        foot = (-0.11, front - 0.06, front - 0.025, 0.014)
        parts.append(down([(-0.03, front - 0.075, front - 0.035, 0.014), foot], 2.6))
    if rng.random() < 0.5:
        parts.append(muzzle_device(rng, muzzle, radius))
    return joined(*parts)


def make_top_loader(rng: Generator) -> Mesh:
    """A compact bullpup with a thumbhole and its magazine lying on top."""
    pull, front, half = rng.uniform(0.24, 0.28), rng.uniform(0.16, 0.22), rng.uniform(0.022, 0.028)
    butt = along(
        [(-pull, -0.12, 0.03, half), (-pull + 0.02, -0.125, 0.034, 1.05 * half), (-0.14, -0.12, 0.034, half)], 4.0, 14
    )
    bridge = along(
        [(-0.15, -0.02, 0.034, half), (front - 0.08, -0.03, 0.03, half), (front, -0.02, 0.024, 0.8 * half)], 4.0
    )
    keel = along(
        [
            (-0.15, -0.12, -0.09, 0.85 * half),
            (-0.04, -0.13, -0.1, 0.8 * half),
            (front - 0.07, -0.11, -0.08, 0.8 * half),
        ],
        3.0,
    )
    return joined(
        butt,
        bridge,
        keel,
        pistol_grip(-0.03, -0.02, 0.1, 0.02, 0.8 * half),
        down([(-0.02, front - 0.1, front - 0.05, 0.8 * half), (-0.1, front - 0.12, front - 0.075, 0.8 * half)], 3.0),
        along([(-pull + 0.03, 0.03, 0.058, 0.9 * half), (front - 0.06, 0.026, 0.052, 0.9 * half)], 5.0),
        barrel(front - 0.02, front + rng.uniform(0.05, 0.2), (0.013, 0.01)),
        red_dot(front - 0.1, 0.05, 0.07),
    )


def make_blunderbuss(rng: Generator) -> Mesh:
    """A short musket with a trumpet's mouth."""
    pull, muzzle, mouth = rng.uniform(0.3, 0.36), rng.uniform(0.32, 0.5), rng.uniform(0.03, 0.045)
    half, throat = rng.uniform(0.024, 0.03), rng.uniform(0.015, 0.019)
    profile = [
        (1.25 * throat, -0.06),
        (throat, 0.6 * muzzle),
        (1.2 * throat, 0.8 * muzzle),
        (mouth, muzzle),
        (0.88 * mouth, muzzle),
        (0.7 * throat, 0.75 * muzzle),
    ]
    return joined(
        full_stock(rng, pull, 0.72 * muzzle, half, straight=True),
        pipe(profile, 0.01, points=18),
        trigger_guard(0.0, -0.05, 0.1),
        box((0.012, 0.036, 0.14), (-half, -0.02, 0.0)),
        hammer(half),
    )


def make_toy(rng: Generator) -> Mesh:
    """A blaster for foam darts: stout, a wide muzzle, a drum."""
    half, top, low = rng.uniform(0.03, 0.04), rng.uniform(0.045, 0.06), rng.uniform(-0.06, -0.045)
    front, pull, mouth = rng.uniform(0.2, 0.3), rng.uniform(0.24, 0.32), rng.uniform(0.03, 0.045)
    muzzle = front + rng.uniform(0.08, 0.2)
    profile = [
        (0.7 * mouth, front - 0.02),
        (0.75 * mouth, muzzle - 0.06),
        (mouth, muzzle - 0.05),
        (mouth, muzzle),
        (0.75 * mouth, muzzle),
        (0.7 * mouth, muzzle - 0.05),
    ]
    parts = [
        along(
            [
                (-0.12, low, 0.8 * top, 0.8 * half),
                (-0.06, low, top, half),
                (front - 0.06, 0.9 * low, top, half),
                (front, 0.7 * low, 0.7 * top, 0.8 * half),
            ],
            3.5,
            14,
        ),
        pipe(profile),
        pistol_grip(-0.03, low + 0.02, 0.12, 0.05, 0.6 * half),
        trigger_guard(0.01, low + 0.008, 0.08, 0.045),
        rail(-0.05, front - 0.06, top),
        along([(front - 0.02, -0.06, -0.02, 0.6 * half), (muzzle - 0.06, -0.07, -0.02, 0.6 * half)], 3.0),
    ]
    if rng.random() < 0.5:
        parts.append(drum(0.12, low - 0.04, rng.uniform(0.06, 0.085), 0.9 * half))
    else:
        parts.append(magazine(0.13, low + 0.01, rng.uniform(0.14, 0.2), 0.09, 0.0, 0.0, 0.6 * half))
    parts.append(shoulder_stock(rng, STOCK_STYLES[int(rng.integers(0, 3))], pull, -0.1, 0.0))
    return joined(*parts)
