"""Sofas without the usual box: a bed to sit on, a bow, and a back that bends around the sitters."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.sofa_parts import rounded_rectangle, soft, swept
from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, loft, ring, tube


def make_daybed(rng: Generator) -> Mesh:
    """A flat bed to sit on, with a low rail or bolsters behind."""
    length, depth, seat = rng.uniform(1.45, 1.85), rng.uniform(0.75, 1.0), rng.uniform(0.36, 0.46)
    pad, roll = rng.uniform(0.12, 0.2), rng.uniform(0.08, 0.12)
    frame, under = rng.uniform(0.06, 0.1), seat - pad
    mattress = soft((0.98 * length, pad, 0.96 * depth), (0.0, under + pad / 2, 0.0), 0.04, 0.02)
    parts = [mattress, box((length, frame, depth), (0.0, under - frame / 2 + 0.01, 0.0))]
    x, z, y = 0.46 * length, 0.43 * depth, under - 0.5 * frame
    parts.append(both_sides(joined(*(tube([(x, 0.0, end), (x, y, end)], (0.025, 0.035), 8) for end in (-z, z)))))
    rear = -depth / 2 + roll
    parts.append(cylinder((-0.48 * length, seat + 0.9 * roll, rear), (0.48 * length, seat + 0.9 * roll, rear), roll))
    if rng.random() < 0.6:
        rail, thick = seat + rng.uniform(0.15, 0.35), 0.05
        parts.append(box((length, rail - under + frame, thick), (0.0, (rail + under - frame) / 2, -depth / 2)))
        if rng.random() < 0.6:
            end = box((thick, rail - under + frame, depth), (length / 2, (rail + under - frame) / 2, 0.0))
            parts.append(both_sides(end))
    return joined(*parts)


def make_curved(rng: Generator) -> Mesh:
    """A bow around its middle, towards the front."""
    radius, half = rng.uniform(1.3, 2.4), rng.uniform(0.45, 0.85)
    depth, seat, top = rng.uniform(0.75, 0.95), rng.uniform(0.36, 0.46), rng.uniform(0.66, 0.9)
    back, lift = rng.uniform(0.14, 0.26), rng.choice([0.0, 0.1])
    angles = np.linspace(-half, half, 15)
    level = np.ones(15)
    base = rounded_rectangle(depth / 2, (seat - lift) / 2, 0.04, (0.0, (seat + lift) / 2))
    rest = rounded_rectangle(back / 2, (top - lift) / 2, 0.45 * back, ((depth - back) / 2, (top + lift) / 2))
    around = (radius, radius)
    parts = [swept(base, angles, around, level), swept(rest, angles, around, level)]
    if lift:
        for angle in (0.85 * half, 0.25 * half):
            for reach in (radius - 0.38 * depth, radius + 0.38 * depth):
                x, z = reach * np.sin(angle), -reach * np.cos(angle)
                parts.append(both_sides(cylinder((x, 0.0, z), (x, lift + 0.03, z), 0.035, 10)))
    return joined(*parts)


def make_tub(rng: Generator) -> Mesh:
    """A back that bends around both ends and falls towards the front."""
    across, deep = rng.uniform(0.65, 0.95), rng.uniform(0.42, 0.55)
    seat, top, lift = rng.uniform(0.38, 0.46), rng.uniform(0.72, 1.0), rng.choice([0.0, 0.12])
    wall, half = rng.uniform(0.12, 0.2), rng.uniform(1.45, 1.75)
    angles = np.linspace(-half, half, 21)
    fall = 1 - rng.uniform(0.15, 0.45) * (1 - np.cos(np.pi * angles / half)) / 2
    shell = rounded_rectangle(wall / 2, (top - lift) / 2, 0.45 * wall, (0.0, (top + lift) / 2))
    plan = ring(across, deep, 0.0, 20, 2.6)
    # A base, and a thick cushion that stands out over it.
    levels = (
        (0.93, lift),
        (0.93, seat - 0.17),
        (0.99, seat - 0.15),
        (1.02, seat - 0.08),
        (1.0, seat),
        (0.9, seat + 0.02),
    )
    block = loft(np.stack([plan * (share, 1.0, share) + (0.0, y, 0.03) for share, y in levels]))
    if lift < 0.04:
        return joined(swept(shell, angles, (across, deep), fall), block)
    x, z = 0.6 * across, 0.5 * deep
    feet = [cylinder((x, 0.0, end), (x, lift + 0.02, end), 0.035, 10) for end in (-z, z)]
    return joined(swept(shell, angles, (across, deep), fall), block, both_sides(joined(*feet)))
