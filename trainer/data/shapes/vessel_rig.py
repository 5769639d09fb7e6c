"""Masts, spars and sails."""

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, Point, joined, loft, tube
from trainer.data.shapes.vessel_hull import Hull
from trainer.data.shapes.vessel_parts import mast


def sail(
    luff: tuple[Point, Point], leech: tuple[Point, Point], belly: float, thickness: float, roach: float = 0.0
) -> Mesh:
    """Cloth between two edges, each from foot to head; it bellies to the left of the way from luff to leech by shares
    of its breadth, and its leech is rounded by `roach`."""
    shares = np.linspace(0.0, 1.0, 7)[:, None]
    front: Float64[ndarray, "7 3"] = np.asarray(luff[0]) * (1 - shares) + np.asarray(luff[1]) * shares
    rear: Float64[ndarray, "7 3"] = np.asarray(leech[0]) * (1 - shares) + np.asarray(leech[1]) * shares
    rear = rear + roach * np.sin(np.pi * shares) * (rear - front)[:1]
    chords = rear - front
    across = np.cross((0.0, 1.0, 0.0), chords)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    breadth = np.linalg.norm(chords, axis=1, keepdims=True)
    depth = belly * np.sin(np.pi * shares) * breadth
    rings = []
    for share in (0.0, 0.2, 0.5, 0.8, 1.0):
        rings.append(front + share * chords + 4 * share * (1 - share) * depth * across)
    middle = np.stack(rings, 1)
    offset = thickness / 2 * across[:, None]
    return loft(np.concatenate((middle + offset, (middle - offset)[:, ::-1]), 1))


def square_sail(z: float, low: float, high: float, half: float, belly: float, thickness: float) -> Mesh:
    """A sail across the ship, with its yard."""
    bulge = 0.5 * thickness
    return joined(
        sail(
            ((half, low, z + bulge), (0.88 * half, high, z + bulge)),
            ((-half, low, z + bulge), (-0.88 * half, high, z + bulge)),
            belly,
            thickness,
        ),
        tube([(-0.98 * half, high, z), (0.98 * half, high, z)], 0.03 * half + 0.4 * thickness, 6),
    )


def rig(rng: Generator, hull: Hull, height: float, two_masts: bool = False) -> list[Mesh]:
    """Mast, boom, main sail and jib; with `two_masts` a smaller set behind. One in six has its sails down."""
    cloth, furled = 0.008 * height + 0.01, rng.random() < 0.17
    swing = float(rng.choice([0.0, 1.0])) * rng.uniform(-0.35, 0.35)
    belly = float(rng.choice([-1.0, 1.0])) * rng.uniform(0.03, 0.1)
    step = rng.uniform(0.54, 0.64)
    reach = hull.length * rng.uniform(0.36, 0.46)
    parts = _main(hull, step, height, reach, swing, 0.0 if furled else belly, cloth)
    if two_masts:
        size = rng.uniform(0.6, 0.75)
        parts += _main(
            hull, rng.uniform(0.14, 0.2), size * height, size * reach, swing, 0.0 if furled else belly, cloth
        )
    if rng.random() < 0.85 and not furled:
        share, overlap = rng.uniform(0.7, 0.98), rng.uniform(0.0, 0.25)
        z, bow, deck = hull.z(step), hull.z(0.985), hull.deck(step)
        run = bow - z
        top = deck + share * height
        head = z + 0.02 * hull.length + 0.012 * height
        clew = (0.3 * run * float(np.sin(swing)), deck + 0.1 * height, z - overlap * run + 0.03 * height)
        luff = ((0.0, hull.deck(0.98) + 0.02 * height, bow), (0.0, top, head))
        parts.append(sail(luff, (clew, (0.0, top - 0.04 * height, head - 0.03 * run)), belly, cloth))
    return parts


def _main(
    hull: Hull, station: float, height: float, reach: float, swing: float, belly: float, cloth: float
) -> list[Mesh]:
    """A mast at a station and what its boom carries: a sail, or, where `belly` is 0, the sail rolled up."""
    z, deck = hull.z(station), hull.deck(station)
    foot = deck + 0.075 * height + 0.02 * hull.length
    out, back = reach * float(np.sin(swing)), reach * float(np.cos(swing))
    pole, boom = mast((0.0, 0.4 * deck, z), 0.6 * deck + height, 0.011 * height), (out, foot, z - back)
    parts = [pole, tube([(0.0, foot, z), boom], 0.008 * height, 6)]
    if not belly:
        roll = [(0.0, foot + 0.02 * height, z - 0.02 * height), (out, foot + 0.012 * height, z - back)]
        return [*parts, tube(roll, 0.022 * height, 8)]
    low, top, head = foot + 0.012 * height, deck + 0.97 * height, 0.12
    tack, throat = (0.0, low, z - 0.008 * height), (0.0, top - 0.3 * head * reach, z - 0.008 * height)
    clew, peak = (out, low, z - 0.98 * back), (head * out, top, z - head * back)
    return [*parts, sail((tack, throat), (clew, peak), belly, cloth, 0.08)]
