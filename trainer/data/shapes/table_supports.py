"""What carries a table's top; every support stands on y = 0 and ends inside the top."""

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, lathe, loft, tube, turned
from trainer.data.shapes.table_parts import LEGS, Top, board, front_and_back, leg, outline, rectangle


def legs(rng: Generator, top: Top, bar: float) -> Mesh:
    """Four legs, with or without an apron under the top, stretchers or a shelf between them."""
    style = LEGS[rng.integers(len(LEGS))]
    inset = rng.choice([0.0, 1.0]) * rng.uniform(0.02, 0.12) * top.depth + (0.7 * bar if style == "plank" else 0.0)
    x, z = top.spot(bar, inset)
    splay = rng.choice([0.0, 1.0]) * rng.uniform(0.03, 0.14) * top.height if style in ("round", "tapered") else 0.0
    parts = [front_and_back(both_sides(leg(rng, style, (x + splay, z + splay), (x, z), top.under, bar)))]
    if rng.random() < 0.65:
        drop = rng.uniform(0.05, 0.16) * min(1.0, top.height / 0.6)
        y, thick = top.height - top.thickness - drop / 2 + 0.005, 0.5 * bar
        parts.append(front_and_back(box((2 * x, drop, thick), (0.0, y, z))))
        parts.append(both_sides(box((thick, drop, 2 * z), (x, y, 0.0))))
    level = rng.uniform(0.12, 0.4)
    at, to, y, rail = x + splay * (1 - level), z + splay * (1 - level), level * top.under, 0.36 * bar
    match int(rng.integers(8)) if style not in ("cabriole", "plank") else 0:
        case 1 | 2:
            parts.append(
                board(
                    outline(rng, "rectangle", 2 * at + rail, 2 * to + rail),
                    [(y - 0.4 * bar, 0.0), (y + 0.2 * bar, 0.0)],
                )
            )
        case 3:
            parts.append(both_sides(tube([(at, y, -to), (at, y, to)], rail, square=True)))
            parts.append(tube([(-at, y, 0.0), (at, y, 0.0)], rail, square=True))
        case 4:
            parts.append(both_sides(tube([(at, y, -to), (at, y, to)], rail, square=True)))
            parts.append(front_and_back(tube([(-at, y, to), (at, y, to)], rail, square=True)))
        case _:
            pass
    return joined(*parts)


def panels(rng: Generator, top: Top) -> Mesh:
    """Two upright boards, plumb or leaning, perhaps with a board or a shelf between them."""
    thick, depth = rng.uniform(0.03, 0.08), top.depth * rng.uniform(0.75, 1.0)
    x = top.width / 2 - thick / 2 - rng.choice([0.0, 1.0]) * rng.uniform(0.05, 0.2) * top.width
    lean = rng.choice([0.0, 0.0, 1.0]) * rng.uniform(-0.12, 0.12) * top.width
    side = loft(
        np.stack(
            [
                rectangle(a, y, 0.0, thick, depth)
                for a, y in ((x - max(lean, 0.0), 0.0), (x + min(lean, 0.0), top.under))
            ]
        )
    )
    inner = x - abs(lean)
    parts = [both_sides(side)]
    match int(rng.integers(4)):
        case 0:
            y = top.height * rng.uniform(0.25, 0.6)
            parts.append(box((2 * inner, 0.6 * thick + 0.01, 0.9 * depth), (0.0, y, 0.0)))
        case 1:
            low = top.height * rng.uniform(0.1, 0.6)
            parts.append(
                box((2 * inner, top.under - low, 0.03), (0.0, (top.under + low) / 2, -rng.uniform(0.0, 0.45) * depth))
            )
        case 2:
            y = top.height * rng.uniform(0.3, 0.7)
            parts.append(box((2 * inner, rng.uniform(0.08, 0.16), 0.045), (0.0, y, 0.0)))
        case _:
            pass
    return joined(*parts)


def trestles(rng: Generator, top: Top, bar: float) -> Mesh:
    """Two trestles of posts, crosses or splayed pairs, and a beam between them."""
    x, reach = top.width / 2 * rng.uniform(0.55, 0.85), top.depth / 2 * rng.uniform(0.7, 0.9) * top.corner**0.5
    y, foot = top.under, rng.uniform(0.8, 1.3) * bar
    level = top.height * rng.uniform(0.25, 0.55)
    match int(rng.integers(3)):
        case 0:
            parts = [
                box((1.1 * bar, foot, 2 * reach), (x, foot / 2, 0.0), (1.0, 0.8)),
                box((bar, foot, 1.7 * reach), (x, y - foot / 2, 0.0)),
                box((bar, y, rng.uniform(1.2, 3.0) * bar), (x, y / 2, 0.0)),
            ]
        case 1:
            parts = [tube([(x, 0.0, -end), (x, y, end)], bar / 2, square=True) for end in (-reach, reach)]
            level = y / 2
        case _:
            head = rng.uniform(0.3, 0.6) * reach
            parts = [tube([(x, 0.0, end * reach), (x, y, end * head)], bar / 2, square=True) for end in (-1, 1)]
            parts.append(box((bar, 0.8 * bar, 2 * (reach + (head - reach) * level / y)), (x, level, 0.0)))
            parts.append(box((bar, bar, 1.8 * reach), (x, y - bar / 2, 0.0)))
    beam = box((2 * x + bar, rng.uniform(0.7, 1.8) * bar, 0.7 * bar), (0.0, level, 0.0))
    return joined(both_sides(joined(*parts)), beam)


def frames(rng: Generator, top: Top, bar: float) -> Mesh:
    """A closed frame of square bars under each end, alone, on a beam, or as two faces of a cage."""
    x, z = top.spot(bar, rng.uniform(0.0, 0.1) * top.depth)
    foot = z * rng.choice([1.0, 1.0, rng.uniform(0.55, 1.0), rng.uniform(0.5, 0.8)])
    head = z if foot < z else z * rng.choice([1.0, rng.uniform(0.5, 1.0)])
    rails = [box((bar, bar, 2 * end + bar), (x, y, 0.0)) for end, y in ((foot, bar / 2), (head, top.under - bar / 2))]
    post = tube([(x, bar / 2, foot), (x, top.under - bar / 2, head)], bar / 2, square=True)
    parts = [both_sides(joined(*rails, front_and_back(post)))]
    match int(rng.integers(4)):
        case 0:
            parts.append(box((2 * x, bar, bar), (0.0, rng.choice([bar / 2, top.under - bar / 2]), 0.0)))
        case 1:
            rails = [box((2 * x, bar, bar), (0.0, y, z)) for z, y in ((foot, bar / 2), (head, top.under - bar / 2))]
            parts.append(front_and_back(joined(*rails)))
        case _:
            pass
    return joined(*parts)


def pedestal(rng: Generator, high: float, reach: float, column: float) -> Mesh:
    """One foot of `reach` metres about the y axis that ends at height `high`; `column` is the radius of its shaft."""
    match int(rng.integers(6)):
        case 0:
            return lathe([(reach, 0.0), (reach, 0.02), (1.5 * column, 0.045), (column, 0.06), (column, high)], 20)
        case 1:
            levels = np.linspace(0.0, 1.0, 10)
            radii = column + (reach - column) * (1 - levels) ** 4 + 0.6 * reach * levels**7
            return lathe([(float(r), float(y * high)) for r, y in zip(radii, levels, strict=True)], 20)
        case 2:
            bulge = column * rng.uniform(1.2, 1.9)
            swell = (bulge, bulge, 0.8 * column, column, bulge, bulge, column, 0.8 * column, 1.4 * column, 1.4 * column)
            levels = np.array([0.18, 0.28, 0.32, 0.4, 0.5, 0.62, 0.74, 0.9, 0.94, 1.0]) * high
            count, drop = int(rng.choice([3, 4, 4])), 0.24 * high
            share = np.linspace(0.0, 1.0, 6)
            sweep = np.stack((0.0 * share, column + drop * (1 - share) ** 1.6 - 0.2 * column, reach * share), -1)
            claw = tube(sweep, (1.1 * column, 0.6 * column), 8)
            feet = [turned(claw, 1, angle) for angle in np.pi / count + np.arange(count) * 2 * np.pi / count]
            return joined(lathe([(r, float(y)) for r, y in zip(swell, levels, strict=True)], 14), *feet)
        case 3:
            cross = box((2 * reach, 0.07, 2.4 * column), (0.0, 0.035, 0.0), (0.9, 0.7))
            shaft = box((2.4 * column, high, 2.4 * column), (0.0, high / 2, 0.0))
            bearer = box((1.5 * reach, 0.06, 2 * column), (0.0, high - 0.03, 0.0))
            return joined(shaft, *(turned(bar, 1, angle) for bar in (cross, bearer) for angle in (0.0, np.pi / 2)))
        case 4:
            waist = rng.uniform(0.25, 0.6)
            return lathe([(0.9 * reach, 0.0), (waist * reach, high * rng.uniform(0.35, 0.65)), (0.9 * reach, high)], 20)
        case _:
            side = 1.8 * reach
            plate = box((side, 0.04, side), (0.0, 0.02, 0.0))
            return joined(
                plate, box((4 * column, high, 4 * column), (0.0, high / 2, 0.0), (rng.uniform(0.6, 1.0),) * 2)
            )
