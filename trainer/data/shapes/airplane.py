"""Aeroplanes: airliners, transports, fighters, light ones, warbirds, gliders, and one in seven that is unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.airplane_jets import make_airliner, make_delta, make_fighter, make_rear_engined, make_transport
from trainer.data.shapes.airplane_propellers import make_glider, make_light, make_twin, make_warbird
from trainer.data.shapes.airplane_unusual import (
    make_biplane,
    make_canard,
    make_flying_boat,
    make_flying_wing,
    make_supersonic,
    make_twin_boom,
)
from trainer.data.shapes.solid import Mesh, moved


def make_airplane(rng: Generator) -> Mesh:
    """One aeroplane, metres, standing on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.24, make_airliner),
        (0.07, make_rear_engined),
        (0.08, make_transport),
        (0.14, make_fighter),
        (0.06, make_delta),
        (0.12, make_light),
        (0.06, make_warbird),
        (0.05, make_twin),
        (0.04, make_glider),
        (0.04, make_biplane),
        (0.03, make_flying_wing),
        (0.02, make_supersonic),
        (0.02, make_twin_boom),
        (0.015, make_canard),
        (0.015, make_flying_boat),
    )
    shares = np.array([share for share, _ in builders])
    plane = builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)
    return moved(plane, (0.0, -float(plane.vertices[:, 1].min()), 0.0))
