"""What cars measure: the ranges of each kind, one car's draw from them, and the outlines that follow."""

from typing import NamedTuple

from numpy.random import Generator

from trainer.data.shapes.car_parts import Frame, rounded

Range = tuple[float, float]


class Kind(NamedTuple):
    """What real cars of a kind measure, metres; each value is drawn from its range by itself."""

    length: Range
    width: Range
    height: Range
    clearance: Range
    wheel_radius: Range
    hood: Range
    """From the nose to the foot of the windscreen."""
    windscreen: Range
    """How far the windscreen leans back."""
    rear_window: Range
    """How far the rear window leans forward."""
    deck: Range
    """From the foot of the rear window to the tail."""
    belt: Range
    """Height of the windows' lower edge, as a share of the height."""
    nose: Range
    """Height of the front end, as a share of the belt's."""


# fmt: off
SEDAN = Kind((3.8, 5.6), (1.55, 2.0), (1.28, 1.62), (0.12, 0.2), (0.28, 0.36),
             (0.95, 1.5), (0.35, 0.95), (0.3, 0.9), (0.55, 1.15), (0.6, 0.69), (0.68, 0.92))
COUPE = Kind((3.7, 5.0), (1.6, 2.05), (1.08, 1.36), (0.09, 0.15), (0.3, 0.37),
             (1.2, 2.0), (0.55, 1.1), (0.7, 1.5), (0.12, 0.5), (0.62, 0.72), (0.55, 0.82))
HATCHBACK = Kind((2.9, 4.4), (1.45, 1.85), (1.36, 1.75), (0.12, 0.2), (0.27, 0.34),
                 (0.6, 1.05), (0.35, 0.95), (0.1, 0.55), (0.02, 0.12), (0.56, 0.66), (0.7, 0.92))
ESTATE = Kind((4.2, 5.5), (1.6, 1.98), (1.36, 1.66), (0.12, 0.2), (0.29, 0.36),
              (0.95, 1.45), (0.4, 0.85), (0.15, 0.55), (0.02, 0.1), (0.6, 0.68), (0.7, 0.92))
OFF_ROADER = Kind((3.2, 5.4), (1.55, 2.1), (1.6, 2.2), (0.2, 0.34), (0.35, 0.48),
                  (0.8, 1.4), (0.08, 0.6), (0.03, 0.35), (0.02, 0.1), (0.58, 0.68), (0.8, 0.97))
VAN = Kind((3.4, 7.2), (1.6, 2.15), (1.75, 2.95), (0.15, 0.25), (0.3, 0.38),
           (0.22, 0.95), (0.25, 0.85), (0.03, 0.15), (0.02, 0.08), (0.42, 0.56), (0.62, 0.88))
PICKUP = Kind((4.4, 6.6), (1.6, 2.1), (1.5, 2.1), (0.2, 0.34), (0.34, 0.48),
              (0.95, 1.55), (0.3, 0.75), (0.06, 0.3), (1.3, 2.4), (0.58, 0.66), (0.8, 0.97))
BUS = Kind((7.0, 12.0), (2.2, 2.55), (2.7, 3.3), (0.25, 0.4), (0.45, 0.52),
           (0.1, 0.5), (0.15, 0.6), (0.03, 0.1), (0.02, 0.06), (0.38, 0.48), (0.6, 0.9))
LIMOUSINE = Kind((6.4, 8.6), (1.75, 1.95), (1.38, 1.55), (0.13, 0.18), (0.3, 0.35),
                 (1.1, 1.4), (0.5, 0.8), (0.4, 0.7), (0.7, 1.1), (0.6, 0.68), (0.7, 0.9))
MICROCAR = Kind((2.2, 2.8), (1.3, 1.6), (1.42, 1.65), (0.12, 0.2), (0.24, 0.3),
                (0.3, 0.55), (0.5, 0.8), (0.1, 0.5), (0.02, 0.06), (0.5, 0.6), (0.65, 0.9))
TRUCK = Kind((5.0, 8.5), (1.9, 2.4), (1.9, 2.6), (0.3, 0.45), (0.4, 0.52),
             (0.25, 1.4), (0.15, 0.6), (0.03, 0.12), (3.0, 5.6), (0.5, 0.6), (0.7, 0.97))
ROADSTER = Kind((3.6, 4.5), (1.55, 1.9), (1.05, 1.3), (0.09, 0.15), (0.28, 0.35),
                (1.2, 1.9), (0.2, 0.5), (0.1, 0.2), (0.7, 1.1), (0.62, 0.72), (0.65, 0.88))
# fmt: on


class Measures(NamedTuple):
    """One car's own measures: the kind's ranges after the draw."""

    frame: Frame
    hood: float
    windscreen: float
    rear_window: float
    deck: float
    belt: float
    nose: float
    rounding: float
    shoulder: float


def draw_measures(rng: Generator, kind: Kind) -> Measures:
    values = Kind(*((rng.uniform(*span), 0.0) for span in kind))
    length, width, height, clearance, radius, hood, screen, rear, deck, belt, nose = (value for value, _ in values)
    # A cabin needs room for people under its roof, before whatever is loaded behind it.
    deck = min(deck, length - hood - 1.2)
    spare = length - hood - deck - 0.75
    screen, rear = screen * min(1.0, 0.8 * spare / (screen + rear)), rear * min(1.0, 0.8 * spare / (screen + rear))
    front = max(radius * 1.14 + 0.1, rng.uniform(0.13, 0.2) * length * (1.0 if hood > 0.5 else 1.15))
    back = length - max(radius * 1.14 + 0.1, rng.uniform(0.15, 0.24) * length)
    frame = Frame(length, width, height, clearance, radius, rng.uniform(0.17, 0.28), front, back)
    belt = max(belt * height, 2.3 * radius + 0.08)
    return Measures(
        frame,
        hood,
        screen,
        rear,
        deck,
        belt,
        max(nose * belt, 2.2 * radius),
        rng.uniform(0.15, 1.0),
        rng.uniform(0.1, 1.0),
    )


def nose(draw: Measures) -> list[tuple[float, float]]:
    """The hull's outline from bumper to windscreen."""
    steep = 0.5 + 0.35 * (1 - draw.rounding)
    return [
        (0.0, steep * draw.nose),
        (0.06, (0.4 + 0.6 * steep) * draw.nose + 0.01),
        (0.16 + 0.12 * draw.rounding, draw.nose),
        (max(draw.hood, 0.34 + 0.12 * draw.rounding), draw.belt),
    ]


def tail(draw: Measures, start: float, height: float) -> list[tuple[float, float]]:
    """The hull's outline from station `start` to the rear bumper."""
    length, steep = draw.frame.length, 0.72 + 0.22 * (1 - draw.rounding)
    return [(start, height), (length - 0.1, 0.985 * height), (length - 0.03, 0.94 * height), (length, steep * height)]


def roof(rng: Generator, draw: Measures, rear_foot: float, rear_height: float) -> list[tuple[float, float]]:
    """The cabin's outline: windscreen, roof, rear window."""
    height, front = draw.frame.height, draw.hood + draw.windscreen
    rear = rear_foot - draw.rear_window
    drop, crown = rng.uniform(0.0, 0.06), rng.uniform(0.0, 0.05)
    points = [
        (draw.hood - 0.02, draw.belt),
        (front, height - crown),
        (front + 0.4 * (rear - front), height),
        (rear, height - drop),
        (rear_foot, rear_height),
    ]
    return rounded(points, int(rng.integers(0, 3)))
