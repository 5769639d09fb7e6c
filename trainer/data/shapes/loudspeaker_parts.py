"""The parts of a loudspeaker: drivers sunk into its baffle, cabinets stacked from one cell a driver, and feet.

A cabinet stands with its baffle at +z. Cells touch without overlapping, so that their fronts make one baffle.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, both_sides, box, joined, loft, turned

Kind = Literal["cone", "metal cone", "dome", "horn", "port", "grille"]

# (share of the radius, height above the baffle relative to the radius) from the rim inwards; a driver's depth scales
# what lies below the baffle.
_RECESSES: dict[Kind, tuple[tuple[float, float], ...]] = {
    "cone": (
        (1.0, 0.0),
        (0.99, 0.05),
        (0.9, 0.05),
        (0.87, -0.06),
        (0.81, 0.05),
        (0.74, -0.06),
        (0.33, -1.0),
        (0.28, -0.9),
        (0.1, -0.78),
    ),
    "metal cone": ((1.0, 0.0), (0.98, 0.06), (0.88, 0.06), (0.84, -0.08), (0.6, 0.1), (0.35, 0.2), (0.1, 0.24)),
    "dome": ((1.0, 0.0), (0.98, 0.05), (0.92, 0.05), (0.55, -0.6), (0.5, -0.5), (0.42, 0.0), (0.25, 0.2), (0.08, 0.26)),
    "horn": ((1.0, 0.0), (0.92, -0.15), (0.6, -0.5), (0.35, -0.85), (0.2, -1.1)),
    "port": ((1.0, 0.0), (0.88, -0.12), (0.8, -0.3), (0.78, -1.4)),
    "grille": ((1.0, 0.0), (0.99, 0.12), (0.94, 0.18)),
}


class Driver(NamedTuple):
    """What is sunk into the middle of a cell's front, metres."""

    kind: Kind
    radius: float
    """Half its width."""
    depth: float = 0.6
    """Of the recess, relative to the radius."""
    height: float = 1.0
    """Of its outline, relative to its width."""
    roundness: float = 2.0
    """Of its outline: 2 is round, 10 nearly a rectangle."""


def woofer_of(rng: Generator, radius: float) -> Driver:
    """A cone, or at times a metal one that bulges."""
    return Driver("cone" if rng.random() < 0.8 else "metal cone", radius, rng.uniform(0.45, 0.75))


def tweeter_of(rng: Generator, radius: float) -> Driver:
    """A dome, or at times a small horn."""
    if rng.random() < 0.2:
        return Driver("horn", radius, 0.6, rng.uniform(0.6, 0.9), 6.0)
    return Driver("dome", radius, rng.uniform(0.4, 0.9))


class Cell(NamedTuple):
    """One storey of a cabinet."""

    height: float
    driver: Driver | None = None


Plan = Sequence[tuple[float, float]]
"""Half the cabinet's width at each z, from its back to its baffle."""


def boxed(width: float, depth: float, chamfer: float = 0.0, back: float = 1.0) -> Plan:
    """A rectangular plan, or one whose front edges are cut off and whose back is narrower or wider than its front."""
    front, half = depth / 2, width / 2
    if not chamfer:
        return ((-front, back * half), (front, half))
    return ((-front, back * half), (front - chamfer, half), (front, half - chamfer))


def bowed(width: float, depth: float, back: float) -> Plan:
    """A plan whose sides bend inwards towards a back of `back` times the width."""
    along = np.linspace(0.0, 1.0, 6)
    half = width / 2 * (back + (1 - back) * np.sin(along * np.pi / 2) ** 0.8)
    return [(float(z), float(x)) for z, x in zip(depth * (along - 0.5), half, strict=True)]


def cabinet(plan: Plan, cells: Sequence[Cell], low: float = 0.0, middle: float = 0.0) -> Mesh:
    """Cells stacked from the height `low` upwards, about x = `middle`."""
    floors = low + np.cumsum([0.0, *(cell.height for cell in cells)])
    return joined(*(_storey(plan, floor, cell, middle) for floor, cell in zip(floors[:-1], cells, strict=True)))


def arranged(drivers: Sequence[Driver], height: float, below: float) -> list[Cell]:
    """The cells that hold the drivers, from the lowest up, in a cabinet of that height.

    Drivers that need more room than there is shrink together. Of the room that is left, a share `below` lies under
    them all, the rest around them.
    """
    needed = sum(2.1 * driver.radius * driver.height for driver in drivers)
    scale = min(1.0, height / needed)
    spare = height - scale * needed
    cells = [Cell(below * spare)] if below * spare > 0.02 * height else []
    around = (height - sum(cell.height for cell in cells) - scale * needed) / len(drivers)
    for driver in drivers:
        fitted = driver._replace(radius=scale * driver.radius)
        cells.append(Cell(2.1 * fitted.radius * fitted.height + around, fitted))
    return cells


def _storey(plan: Plan, floor: float, cell: Cell, middle: float) -> Mesh:
    half_y, (front, half_x) = cell.height / 2, plan[-1]
    centre = (middle, floor + half_y)
    if cell.driver is None:
        corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        return loft(np.stack([_ring(corners * (x, half_y), centre, z) for z, x in plan]))
    corner = np.arctan2(half_y, half_x)
    angle = np.sort(
        np.concatenate(
            ((np.arange(20) + 0.5) * np.pi / 10, (corner, np.pi - corner, np.pi + corner, 2 * np.pi - corner))
        )
    )
    direction = np.stack((np.cos(angle), np.sin(angle)), -1)
    edge = direction / np.maximum(np.abs(direction[:, :1]) / half_x, np.abs(direction[:, 1:]) / half_y)
    rings = [_ring(edge * (x / half_x, 1.0), centre, z) for z, x in plan]
    driver = cell.driver
    outline = direction * (np.abs(direction) ** driver.roundness).sum(1, keepdims=True) ** (-1 / driver.roundness)
    for share, above in _RECESSES[driver.kind]:
        z = front + driver.radius * above * (driver.depth if above < 0 else 1.0)
        rings.append(_ring(outline * (share * driver.radius, share * driver.radius * driver.height), centre, z))
    return loft(np.stack(rings))


def _ring(points: Float64[ndarray, "N 2"], centre: tuple[float, float], z: float) -> Float64[ndarray, "N 3"]:
    ring = np.empty((len(points), 3))
    ring[:, :2], ring[:, 2] = points + centre, z
    return ring


def lying(plan: Plan, cells: Sequence[Cell]) -> Mesh:
    """A cabinet on its side: its cells stand in a row along x, and its lower side lies flat on y = 0."""
    length = sum(cell.height for cell in cells)
    standing = cabinet(plan, cells, -length / 2)
    x, y, z = turned(standing, 2, np.pi / 2).vertices.T
    (back, narrow), (front, _) = plan[0], plan[-1]
    y = y - (max(half for _, half in plan) - narrow) * (front - z) / (front - back)
    return Mesh(np.stack((x, y - y.min(), z), -1), standing.faces)


def slanted(mesh: Mesh, slope: float) -> Mesh:
    """The baffle leans back by `slope` metres a metre; the back stays where it is."""
    x, y, z = mesh.vertices.T
    share = (z - z.min()) / np.ptp(z)
    return Mesh(np.stack((x, y, z - slope * share * y), -1), mesh.faces)


def tapered(mesh: Mesh, top: float) -> Mesh:
    """The upper end is `top` times as wide and as deep as the lower one; the baffle stays plumb."""
    x, y, z = mesh.vertices.T
    share = 1 - (1 - top) * (y - y.min()) / np.ptp(y)
    return Mesh(np.stack((x * share, y, z.max() + (z - z.max()) * share), -1), mesh.faces)


def leaning(mesh: Mesh, slope: float) -> Mesh:
    """The whole is sheared backwards by `slope` metres a metre."""
    x, y, z = mesh.vertices.T
    return Mesh(np.stack((x, y, z - slope * y), -1), mesh.faces)


def feet(x: float, z: float, height: float, size: float) -> Mesh:
    """Four blocks under a cabinet that stands `height` above the floor."""
    ends = [box((size, 1.1 * height, size), (x, 0.55 * height, end)) for end in (-z, z)]
    return both_sides(joined(*ends))
