"""Loudspeakers: bookshelf and floor-standing boxes, subwoofers, soundbars, stage and portable ones, and rarer forms."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.loudspeaker_parts import (
    Cell,
    Driver,
    Plan,
    arranged,
    bowed,
    boxed,
    cabinet,
    feet,
    leaning,
    lying,
    slanted,
    tapered,
    tweeter_of,
    woofer_of,
)
from trainer.data.shapes.loudspeaker_unusual import (
    make_cylinder,
    make_gramophone,
    make_guitar_stack,
    make_panel,
    make_portable,
    make_sphere,
)
from trainer.data.shapes.solid import Mesh, both_sides, box, cylinder, joined, lathe, moved, turned


def make_loudspeaker(rng: Generator) -> Mesh:
    """One loudspeaker, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.08, _bookshelf),
        (0.23, _tower),
        (0.06, _column),
        (0.04, _subwoofer),
        (0.15, _bar),
        (0.12, _on_a_stand),
        (0.04, _monitor),
        (0.09, _stage),
        (0.025, make_guitar_stack),
        (0.05, make_portable),
        (0.025, make_cylinder),
        (0.02, make_sphere),
        (0.035, make_gramophone),
        (0.04, make_panel),
    )
    shares = np.array([share for share, _ in builders])
    return builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)


def _plan(rng: Generator, width: float, depth: float) -> Plan:
    match rng.choice(["box", "chamfered", "bowed"], p=[0.5, 0.3, 0.2]):
        case "box":
            return boxed(width, depth)
        case "chamfered":
            return boxed(width, depth, rng.uniform(0.06, 0.14) * width)
        case _:
            return bowed(width, depth, rng.uniform(0.3, 0.7))


def _two_way(rng: Generator, plan: Plan, height: float) -> list[Cell]:
    """Woofer below and tweeter above, or the other way round, and perhaps a port."""
    room = 0.94 * plan[-1][1]
    woofer = woofer_of(rng, min(rng.uniform(0.75, 0.98) * room, 0.34 * height))
    drivers = [woofer, tweeter_of(rng, woofer.radius * rng.uniform(0.4, 0.62))]
    if rng.random() < 0.1:
        drivers.reverse()
    if rng.random() < 0.35:
        port = Driver("port", 0.25 * room) if rng.random() < 0.6 else Driver("port", 0.7 * room, 0.3, 0.2, 8.0)
        drivers.insert(0, port)
    return arranged(drivers, height, rng.uniform(0.0, 0.4))


def _bookshelf(rng: Generator) -> Mesh:
    width = rng.uniform(0.14, 0.3)
    height, depth = width * rng.uniform(1.2, 2.8), width * rng.uniform(0.5, 1.7)
    plan = _plan(rng, width, depth)
    if rng.random() < 0.12:
        cover = Driver("grille", 0.9 * plan[-1][1], height=0.46 * height / plan[-1][1], roundness=12.0)
        return cabinet(plan, [Cell(height, cover)])
    cells = _two_way(rng, plan, height)
    if rng.random() < 0.12:
        return lying(plan, cells)
    body = cabinet(plan, cells)
    return tapered(body, rng.uniform(0.7, 0.95)) if rng.random() < 0.15 else body


def _tower(rng: Generator) -> Mesh:
    """Drivers one above the other, on a plinth, feet or the floor; one in six has its tweeter in a pod on top."""
    width = rng.uniform(0.16, 0.32)
    height, depth = width * rng.uniform(3.4, 7.0), width * rng.uniform(0.9, 1.9)
    plan = _plan(rng, width, depth)
    room = 0.94 * plan[-1][1]
    woofer = woofer_of(rng, room * rng.uniform(0.7, 1.0))
    drivers = [woofer] * int(rng.integers(1, 5))
    tweeter, pod = tweeter_of(rng, room * rng.uniform(0.3, 0.5)), rng.random() < 0.16
    if not pod:
        drivers.insert(len(drivers) - int(rng.random() < 0.3 and len(drivers) > 1), tweeter)
    if rng.random() < 0.4:
        drivers.insert(len(drivers) - 1, woofer._replace(radius=woofer.radius * rng.uniform(0.55, 0.75)))
    body = cabinet(plan, arranged(drivers, height, rng.uniform(0.3, 1.0)))
    if pod:
        body = joined(body, moved(_pod(0.34 * width), (0.0, height + 0.27 * width, 0.12 * depth)))
    match rng.integers(4):
        case 0:
            body = tapered(body, rng.uniform(0.6, 0.9))
        case 1:
            body = leaning(body, rng.uniform(0.03, 0.12))
    match rng.integers(3):
        case 0:
            lift, size = rng.uniform(0.03, 0.06), rng.uniform(1.1, 1.4)
            foot = box((size * width, lift, size * depth), (0.0, lift / 2, 0.0))
        case 1:
            lift = rng.uniform(0.03, 0.06)
            foot = feet(0.42 * width, 0.42 * depth, lift, 0.04)
        case _:
            return body
    return joined(moved(body, (0.0, 0.98 * lift, 0.0)), foot)


def _pod(radius: float) -> Mesh:
    """A small teardrop with a dome in its front."""
    profile = [(0.1, -2.2), (0.55, -1.4), (0.9, -0.5), (1.0, 0.2), (0.85, 0.75), (0.6, 0.75), (0.5, 0.4), (0.2, 0.6)]
    return turned(lathe([(r * radius, z * radius) for r, z in profile], 16), 0, np.pi / 2)


def _column(rng: Generator) -> Mesh:
    """A slim satellite with small drivers, on a round plate."""
    width = rng.uniform(0.06, 0.11)
    height, lift = rng.uniform(0.7, 1.2), rng.uniform(0.02, 0.35)
    plan = boxed(width, width * rng.uniform(0.8, 1.5), rng.choice([0.0, 0.15]) * width)
    driver = woofer_of(rng, 0.88 * plan[-1][1])
    body = cabinet(plan, arranged([driver] * int(rng.integers(2, 7)), height, rng.choice([0.0, 1.0])), lift)
    reach = width * rng.uniform(1.2, 1.8)
    # The plate reaches forward, so that the column stands on its rear half.
    plate = moved(lathe([(reach, 0.0), (reach, 0.02), (0.8 * reach, 0.03)], 24), (0.0, 0.0, 0.35 * reach))
    return joined(body, plate, cylinder((0.0, 0.01, 0.0), (0.0, lift + 0.02, 0.0), 0.25 * width))


def _subwoofer(rng: Generator) -> Mesh:
    """Nearly a cube around one large cone."""
    width = rng.uniform(0.25, 0.5)
    height, depth = width * rng.uniform(0.85, 1.2), width * rng.uniform(0.85, 1.3)
    plan = boxed(width, depth, rng.choice([0.0, 0.08]) * width)
    woofer = woofer_of(rng, min(0.94 * plan[-1][1], 0.45 * height) * rng.uniform(0.75, 1.0))
    drivers = [woofer]
    if rng.random() < 0.25:
        woofer = woofer._replace(radius=0.8 * woofer.radius)
        drivers = [Driver("port", 0.4 * width, 0.4, 0.15, 8.0), woofer]
    lift = rng.choice([0.0, 1.0, 1.0]) * rng.uniform(0.02, 0.06)
    body = moved(cabinet(plan, arranged(drivers, height, 0.2)), (0.0, lift, 0.0))
    return joined(body, feet(0.38 * width, 0.38 * depth, lift, 0.12 * width)) if lift else body


def _bar(rng: Generator) -> Mesh:
    """A soundbar or a centre speaker, with a row of drivers that is alike on both sides."""
    flat = rng.random() < 0.5
    height = rng.uniform(0.06, 0.1) if flat else rng.uniform(0.12, 0.2)
    length = height * (rng.uniform(6.0, 12.0) if flat else rng.uniform(2.2, 3.6))
    plan = boxed(height, height * rng.uniform(0.7, 1.4), rng.choice([0.0, 0.1]) * height, rng.uniform(0.6, 0.85))
    woofer = woofer_of(rng, 0.94 * plan[-1][1] * rng.uniform(0.75, 1.0))
    half = [woofer] * int(rng.integers(1, 4 if flat else 3))
    middle = [tweeter_of(rng, 0.55 * woofer.radius)] if rng.random() < 0.7 else []
    cells = arranged([*half, *middle, *half], (1.0 if flat else 0.92) * length, 0.0)
    if flat:
        gap = [Cell(rng.uniform(0.1, 0.3) * length)]
        cells = [
            *cells[: len(half)],
            *gap,
            *cells[len(half) : len(cells) - len(half)],
            *gap,
            *cells[len(cells) - len(half) :],
        ]
    body = lying(plan, cells)
    if rng.random() < 0.4:
        span, lift = np.ptp(body.vertices[:, 0]), 0.12 * height
        return joined(moved(body, (0.0, lift, 0.0)), feet(0.4 * span, 0.2 * height, lift, 0.25 * height))
    return body


def _on_a_stand(rng: Generator) -> Mesh:
    """A bookshelf speaker on one or two columns."""
    body = _bookshelf(rng)
    width, depth = np.ptp(body.vertices[:, 0]), np.ptp(body.vertices[:, 2])
    top, bar, plate = rng.uniform(0.4, 0.8), rng.uniform(0.025, 0.05), rng.uniform(0.02, 0.035)
    base = box((width * rng.uniform(1.0, 1.5), plate, depth * rng.uniform(1.0, 1.4)), (0.0, plate / 2, 0.1 * depth))
    shelf = box((0.9 * width, plate, 0.9 * depth), (0.0, top - plate / 2, 0.0))
    if rng.random() < 0.4:
        column = both_sides(box((bar, top - plate, 1.4 * bar), (0.3 * width, top / 2, 0.0)))
    elif rng.random() < 0.5:
        column = box((2 * bar, top - plate, 2 * bar), (0.0, top / 2, 0.0))
    else:
        column = cylinder((0.0, 0.5 * plate, 0.0), (0.0, top - 0.5 * plate, 0.0), bar)
    return joined(moved(body, (0.0, top, 0.0)), base, shelf, column)


def _monitor(rng: Generator) -> Mesh:
    """For a studio: cut edges, a baffle that leans back or not, an amplifier behind; upright or lying."""
    width = rng.uniform(0.18, 0.32)
    height, depth = width * rng.uniform(1.35, 1.7), width * rng.uniform(0.85, 1.3)
    plan = boxed(width, depth, rng.uniform(0.08, 0.16) * width, rng.uniform(0.8, 1.0))
    cells = _two_way(rng, plan, height)
    if rng.random() < 0.25:
        return lying(plan, [*cells, Cell(0.02 * height)])
    slope = rng.choice([0.0, 1.0, 1.0]) * rng.uniform(0.08, 0.3)
    fins = box((0.7 * width, 0.6 * height, 0.12 * width), (0.0, 0.4 * height, -depth / 2))
    return slanted(joined(cabinet(plan, cells), fins), slope)


def _stage(rng: Generator) -> Mesh:
    """Narrower behind, a horn above a large cone: on the floor, on a tripod, or a wedge that looks up."""
    width = rng.uniform(0.35, 0.6)
    height, depth = width * rng.uniform(1.4, 2.0), width * rng.uniform(0.75, 1.05)
    plan = boxed(width, depth, back=rng.uniform(0.45, 0.8))
    woofer = Driver("cone", 0.47 * width * rng.uniform(0.75, 1.0), rng.uniform(0.4, 0.6))
    horn = Driver("horn", 0.46 * width * rng.uniform(0.7, 1.0), 0.5, rng.uniform(0.4, 0.7), rng.choice([2.0, 10.0]))
    body = cabinet(plan, arranged([woofer, horn], height, 0.1))
    match rng.choice(["floor", "tripod", "wedge"], p=[0.35, 0.4, 0.25]):
        case "tripod":
            lift, bar, spread = rng.uniform(0.8, 1.3), 0.022, rng.uniform(0.35, 0.55)
            legs = [
                cylinder((0.0, 0.55, 0.0), (spread * np.sin(azimuth), 0.02, spread * np.cos(azimuth)), bar, 8)
                for azimuth in (np.pi, np.pi / 3, -np.pi / 3)
            ]
            return joined(
                moved(body, (0.0, lift, 0.0)), cylinder((0.0, 0.2, 0.0), (0.0, lift + 0.05, 0.0), 1.3 * bar), *legs
            )
        case "wedge":
            # Lying, a driver's own width runs up the baffle.
            drivers = [woofer._replace(radius=0.34 * width), horn._replace(radius=0.2 * width, height=1.5)]
            wedge = lying(boxed(0.75 * width, depth), arranged(drivers, 1.3 * width, 0.0))
            return slanted(wedge, rng.uniform(0.5, 0.9) * depth / width)
        case _:
            return body
