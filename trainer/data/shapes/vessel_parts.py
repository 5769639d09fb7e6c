"""What stands on hulls: deckhouses, masts, funnels, cranes, guns, windscreens; and what hangs from them."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, Point, box, cylinder, joined, lathe, loft, moved, ring, tube, turned

_WALLS = np.array([(0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0), (0, 1, 2, 3), (7, 6, 5, 4)])
_HOUSE_FACES = np.concatenate((_WALLS[:, :3], _WALLS[:, [0, 2, 3]]))


def house(
    base: float,
    height: float,
    span: tuple[float, float],
    half: float,
    lean: tuple[float, float] = (0.0, 0.0),
    tumble: float = 0.0,
) -> Mesh:
    """A deckhouse between two z: at its top, rear and front walls `lean` inwards by so much, its sides by `tumble`."""
    rear, front = span
    top, upper, behind, ahead = base + height, half - tumble, rear + lean[0], front - lean[1]
    low = ((-half, base, rear), (half, base, rear), (half, base, front), (-half, base, front))
    high = ((-upper, top, behind), (upper, top, behind), (upper, top, ahead), (-upper, top, ahead))
    return Mesh(np.array((*low, *high)), _HOUSE_FACES)


def storeys(
    count: int,
    base: float,
    height: float,
    span: tuple[float, float],
    half: float,
    shrink: tuple[float, float],
    lean: float,
) -> Mesh:
    """Decks one above the other, each under a slab that stands out; every deck is shorter at both ends by `shrink`."""
    rear, front = span
    parts = []
    for index in range(count):
        low, narrow = base + index * height, half * (1 - 0.07 * index)
        ends = (rear + index * shrink[0], front - index * shrink[1])
        slab = (0.12 * height, 0.03 * half)
        parts.append(house(low - 0.05 * height, 0.95 * height, ends, narrow, (0.0, lean * height), 0.03 * narrow))
        over = (ends[0] - 0.5 * abs(shrink[0]), ends[1] - lean * height + 0.25 * height)
        parts.append(house(low + height - slab[0], slab[0], over, narrow + slab[1]))
    return joined(*parts)


def mast(foot: Point, height: float, radius: float, rake: float = 0.0) -> Mesh:
    x, y, z = foot
    return tube([(x, y, z), (x, y + height, z - rake)], (radius, 0.6 * radius), 8)


def funnel(z: float, base: float, height: float, radius: float, rake: float, length: float = 1.4) -> Mesh:
    """An oval chimney with a rim, open on top."""
    rows = ((0.0, 1.05), (0.82, 1.0), (0.82, 1.08), (1.0, 1.08), (1.0, 0.86), (0.85, 0.86))
    rings = [
        ring(k * radius, length * k * radius, base + s * height, 14) + np.array((0.0, 0.0, z - s * rake))
        for s, k in rows
    ]
    return loft(np.stack(rings))


def crane(x: float, z: float, base: float, height: float, reach: float, radius: float) -> Mesh:
    """A post with a jib that reaches forward; backward where `reach` is negative."""
    top = base + height
    jib = tube([(x, base + 0.55 * height, z), (x, top + 0.1 * height, z + reach)], (0.55 * radius, 0.35 * radius), 6)
    cab = box((3.0 * radius, 2.4 * radius, 3.0 * radius), (x, base + 0.6 * height, z))
    stay = tube([(x, top, z), (x, top + 0.1 * height, z + reach)], 0.25 * radius, 6)
    return joined(cylinder((x, base - radius, z), (x, top, z), radius, 10), cab, jib, stay)


def turret(z: float, base: float, size: float, barrels: int, forward: bool) -> Mesh:
    """A gun house on a drum; `size` is its breadth, metres."""
    gun_house = house(0.15, 0.42, (-0.55, 0.5), 0.5, (0.1, 0.3), 0.08)
    parts = [
        moved(lathe([(0.5 * size, -0.2 * size), (0.5 * size, 0.15 * size)], 14), (0.0, base, 0.0)),
        Mesh(gun_house.vertices * size + (0.0, base, 0.0), gun_house.faces),
    ]
    for index in range(barrels):
        x = (index - (barrels - 1) / 2) * 0.25 * size
        start = (x, base + 0.35 * size, 0.3 * size)
        parts.append(tube([start, (x, base + 0.5 * size, 1.5 * size)], (0.075 * size, 0.05 * size), 8))
    gun = joined(*parts) if forward else turned(joined(*parts), 1, np.pi)
    return moved(gun, (0.0, 0.0, z))


def arch(half: float, z: float, low: float, high: float, rake: float, radius: float, square: bool = False) -> Mesh:
    """A hoop across the vessel that leans back by `rake`: a roll bar, a radar's stand, a gallows."""
    side = [(half, low, z), (0.8 * half, high, z - rake)]
    return tube([*side, *((-x, y, z) for x, y, z in side[::-1])], radius, 8, square)


def lattice_mast(z: float, base: float, height: float, foot: float) -> Mesh:
    """A tapering tower with yards and a radar."""
    yard = 0.9 * foot
    return joined(
        house(base, 0.75 * height, (z - foot / 2, z + foot / 2), foot / 2, (0.3 * foot, 0.3 * foot), 0.3 * foot),
        tube([(0.0, base + 0.7 * height, z), (0.0, base + height, z)], (0.09 * foot, 0.05 * foot), 6),
        box((2.4 * yard, 0.12 * foot, 0.12 * foot), (0.0, base + 0.72 * height, z)),
        box((1.3 * yard, 0.25 * foot, 0.12 * foot), (0.0, base + 0.56 * height, z + 0.3 * foot)),
    )


def screen(z: float, base: float, height: float, half: float, lean: float, thickness: float) -> Mesh:
    """A windscreen across the boat with wings that run back."""
    path = [(-half, -0.7 * half), (-0.8 * half, 0.0), (0.8 * half, 0.0), (half, -0.7 * half)]
    bottom = np.array([(x, base, z + run) for x, run in path])
    top = np.array([(0.86 * x, base + height, z + run - lean) for x, run in path])
    inward = np.array(
        [(-np.sign(x) * thickness * (abs(x) == half), 0.0, -thickness * (abs(x) < half)) for x, _ in path]
    )
    return loft(np.stack((bottom, top, top + inward, bottom + inward), 1))


def fin_keel(z: float, top: float, depth: float, chord: float, thickness: float, bulb: bool) -> Mesh:
    """A ballast fin that ends `depth` below `top`, at times in a torpedo."""
    half = thickness / 2
    upper, lower = ring(half, chord / 2, top, 12), ring(0.8 * half, 0.36 * chord, top - depth, 12)
    lower[:, 2] -= 0.12 * chord
    blade = moved(loft(np.stack((upper, lower))), (0.0, 0.0, z))
    if not bulb:
        return blade
    profile = [(k * half, s * chord) for k, s in ((0.3, -0.6), (1.3, -0.25), (1.7, 0.2), (0.4, 0.55))]
    return joined(blade, moved(turned(lathe(profile, 12), 0, np.pi / 2), (0.0, top - depth, z - 0.12 * chord)))


def outboard(x: float, y: float, z: float, size: float) -> Mesh:
    """A motor that hangs at the stern: hood, leg and propeller's hub."""
    rows = ((0.0, 0.8), (0.15, 1.0), (0.6, 1.0), (0.8, 0.7))
    hood = loft(np.stack([ring(0.3 * size * k, 0.42 * size * k, up * size, 12, 3.0) for up, k in rows]))
    leg = box((0.18 * size, 1.5 * size, 0.3 * size), (x, y - 0.65 * size, z - 0.3 * size))
    hub = cylinder((x, y - 1.3 * size, z - 0.7 * size), (x, y - 1.3 * size, z), 0.12 * size, 8)
    return joined(
        moved(hood, (x, y, z - 0.3 * size)),
        leg,
        hub,
        box((0.2 * size, 0.2 * size, 0.5 * size), (x, y + 0.05 * size, z - 0.05 * size)),
    )


def oar(rng: Generator, pivot: Point, length: float) -> Mesh:
    """An oar that rests in the gunwale at `pivot` and dips its blade on the left."""
    x, y, z = pivot
    swing, dip = rng.uniform(-0.5, 0.3), rng.uniform(0.25, 0.4)
    way = np.array([np.cos(swing) * np.cos(dip), -np.sin(dip), np.sin(swing) * np.cos(dip)])
    inner, outer = np.array([x, y, z]) - 0.28 * length * way, np.array([x, y, z]) + 0.55 * length * way
    blade = tube([outer, outer + 0.2 * length * way], (0.02 * length, 0.035 * length), 8)
    return joined(tube([inner, outer], 0.011 * length + 0.006, 6), blade)
