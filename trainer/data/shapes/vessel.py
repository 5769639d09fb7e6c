"""Vessels: boats under oars, sails and engines, ships for cargo, war and passengers, and one in seven unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.solid import Mesh, moved
from trainer.data.shapes.vessel_boats import make_inflatable, make_motor_boat, make_rowing_boat
from trainer.data.shapes.vessel_cargo import make_container_ship, make_freighter
from trainer.data.shapes.vessel_naval import make_carrier, make_submarine, make_warship
from trainer.data.shapes.vessel_sailing import make_catamaran, make_sailing_boat, make_tall_ship, make_viking_ship
from trainer.data.shapes.vessel_ships import make_liner, make_motor_yacht, make_trawler, make_tug
from trainer.data.shapes.vessel_unusual import make_canoe, make_hovercraft, make_paddle_steamer


def make_vessel(rng: Generator) -> Mesh:
    """One boat or ship, metres, its lowest point on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.12, make_rowing_boat),
        (0.03, make_inflatable),
        (0.1, make_motor_boat),
        (0.13, make_sailing_boat),
        (0.04, make_catamaran),
        (0.1, make_motor_yacht),
        (0.07, make_container_ship),
        (0.08, make_freighter),
        (0.09, make_warship),
        (0.06, make_liner),
        (0.05, make_tug),
        (0.05, make_trawler),
        (0.03, make_viking_ship),
        (0.03, make_tall_ship),
        (0.03, make_submarine),
        (0.02, make_carrier),
        (0.02, make_canoe),
        (0.01, make_paddle_steamer),
        (0.01, make_hovercraft),
    )
    shares = np.array([share for share, _ in builders])
    vessel = builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)
    return moved(vessel, (0.0, -float(vessel.vertices[:, 1].min()), 0.0))
