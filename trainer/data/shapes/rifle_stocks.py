"""Stocks of rifles: what the shoulder takes, in wood, in plastic and in wire.

The frame is that of `rifle_parts`; `pull` is the distance from the trigger to the butt, metres.
"""

from typing import Literal

from numpy.random import Generator

from trainer.data.shapes.rifle_parts import along, down, pistol_grip
from trainer.data.shapes.solid import Mesh, box, cylinder, joined, tube

StockStyle = Literal["fixed", "sliding", "skeleton", "wire", "wooden", "thumbhole"]
STOCK_STYLES: tuple[StockStyle, ...] = ("fixed", "sliding", "skeleton", "wire", "wooden", "thumbhole")


def full_stock(rng: Generator, pull: float, tip: float, half: float, straight: bool) -> Mesh:
    """One piece of wood from the butt to the tip of the fore-end at z = `tip`; a `straight` one has no pistol grip."""
    drop, depth = rng.uniform(0.015, 0.05), rng.uniform(0.105, 0.14)
    hump = rng.choice([0.0, 0.0, 0.02])
    belly = rng.uniform(0.04, 0.06)
    knots = [
        (-pull, -drop - depth, -drop, 0.85 * half),
        (-pull + 0.01, -drop - depth, -drop + 0.002, 0.95 * half),
        (-0.62 * pull, -0.7 * drop - 0.72 * depth, -0.6 * drop + hump, half),
        (-0.38 * pull, -0.086, -0.5 * drop - 0.008 + 0.7 * hump, 0.92 * half),
        (-0.1, -0.07, -0.02, 0.78 * half),
        (-0.04, -0.062, -0.006, 0.85 * half),
        (0.03, -belly - 0.004, 0.0, half),
        (0.17, -belly, 0.0, half),
        (0.6 * tip, -0.92 * belly, -0.002, 0.92 * half),
        (tip - 0.02, -0.75 * belly, -0.004, 0.75 * half),
        (tip, -0.5 * belly, -0.008, 0.5 * half),
    ]
    wood = along(knots, 2.6, 14)
    if straight:
        return wood
    reach = rng.uniform(0.03, 0.05)
    swell = [
        (-0.04, -0.125, -0.045, 0.8 * half),
        (-0.07, -0.128, -0.06, 0.82 * half),
        (-0.07 - reach, -0.135, -0.083, 0.8 * half),
    ]
    return joined(wood, down(swell, 2.6))


def butt(rng: Generator, pull: float, half: float, front: float) -> Mesh:
    """A wooden butt that ends behind a receiver at z = `front`."""
    drop, depth, wrist = rng.uniform(0.02, 0.06), rng.uniform(0.105, 0.14), rng.uniform(0.036, 0.046)
    return along(
        [
            (-pull, -drop - depth, -drop, 0.85 * half),
            (-pull + 0.01, -drop - depth, -drop + 0.002, 0.95 * half),
            (-0.62 * pull, -0.8 * drop - 0.72 * depth, -0.7 * drop, half),
            (-0.12, -0.03 - wrist, -0.022, 0.78 * half),
            (front, -0.058, -0.004, 0.85 * half),
            (front + 0.02, -0.056, 0.0, 0.85 * half),
        ],
        2.6,
        14,
    )


def shoulder_stock(rng: Generator, style: StockStyle, pull: float, rear: float, y: float) -> Mesh:
    """What stands behind a receiver that ends at z = `rear` with its axis at the height `y`."""
    half, depth = rng.uniform(0.014, 0.021), rng.uniform(0.1, 0.135)
    low, high = y + 0.02 - depth, y + 0.02
    match style:
        case "fixed":
            return along(
                [
                    (-pull, low, high, half),
                    (-pull + 0.02, low, high, 1.05 * half),
                    (rear - 0.05, y - 0.035, high, half),
                    (rear + 0.01, y - 0.026, high, half),
                ],
                4.0,
            )
        case "sliding":
            body = along(
                [
                    (-pull, low, high, 0.9 * half),
                    (-pull + 0.025, low + 0.004, high, half),
                    (-pull + 0.08, y - 0.045, high, half),
                    (-pull + 0.15, y - 0.022, high - 0.004, 0.9 * half),
                ],
                4.0,
            )
            return joined(body, cylinder((0.0, y, -pull + 0.1), (0.0, y, rear + 0.02), 0.0165, 12))
        case "skeleton":
            plate = along([(-pull, low, high, half), (-pull + 0.024, low, high, half)], 4.0)
            upper = tube([(0.0, y, rear + 0.02), (0.0, high - 0.014, -pull + 0.01)], 0.0125, 8)
            lower = tube([(0.0, y - 0.03, rear + 0.01), (0.0, low + 0.016, -pull + 0.01)], 0.0105, 8)
            return joined(plate, upper, lower)
        case "wire":
            path = [
                (0.0, y, rear + 0.02),
                (0.0, y - 0.004, -pull + 0.012),
                (0.0, low, -pull),
                (0.0, low + 0.012, -pull + 0.045),
            ]
            return joined(tube(path, 0.0095, 8), box((0.04, depth, 0.016), (0.0, (low + high) / 2, -pull)))
        case "wooden":
            fall = rng.uniform(0.02, 0.05)
            return along(
                [
                    (-pull, low - fall, high - fall, half),
                    (-pull + 0.012, low - fall, high - fall + 0.002, 1.15 * half),
                    (0.5 * (rear - pull), y - 0.045 - 0.6 * fall, high - 0.5 * fall, 1.1 * half),
                    (rear + 0.015, y - 0.03, y + 0.012, 0.95 * half),
                ],
                2.8,
            )
        case "thumbhole":
            comb = along(
                [
                    (-pull, y - 0.03, high, half),
                    (-pull + 0.1, y - 0.02, high + 0.004, half),
                    (rear + 0.02, y - 0.026, y + 0.014, half),
                ],
                3.0,
            )
            toe = along(
                [
                    (-pull, low, y, half),
                    (-pull + 0.06, low + 0.012, y - 0.02, half),
                    (-0.06, -0.145, -0.105, 0.8 * half),
                ],
                3.0,
            )
            return joined(comb, toe, pistol_grip(-0.03, -0.045, 0.095, 0.035))
