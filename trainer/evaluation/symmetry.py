"""Rotational symmetry about +Y: which azimuths of an object nobody can tell apart."""

import math

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial import cKDTree

from trainer.data.picture import rotation_about_y
from trainer.evaluation.surface import Surface

ORDERS = (8, 6, 5, 4, 3, 2)
"""The discrete symmetries that are looked for, the highest first."""
REFERENCE_POINTS = 16384
"""Points that turned ones are compared with: so many that the distance to the nearest is about that to the surface."""
TOLERANCE = 0.02
"""How far a turned point may lie from the surface, in diagonals of the bounding box."""
SHARE = 0.975
"""The share of points that have to lie on the surface again. Procedural shapes that have a symmetry reach 0.98 and
more; a mug whose handle is a thirtieth of its surface stays at 0.96."""

_PROBES = 2048
# Parts of a full turn that belong to no symmetry in ORDERS, nor nearly so.
_ODD_TURNS = (0.0557, 0.1459, 0.3049, 0.4427)


def rotational_order(surface: Surface) -> float:
    """The order n of an object's symmetry: turned by 360°/n about its own upright axis, it looks as before.

    `surface` holds REFERENCE_POINTS or so. 1 where there is no symmetry, infinity for a solid of revolution.
    """
    # The axis runs through the centre of the surface: that of the bounding box lies beside it for three or five legs.
    around = surface.points - surface.points.mean(0) * (1.0, 0.0, 1.0)
    tree = cKDTree(around)
    probes = around[:: max(1, len(around) // _PROBES)]
    if all(_share_on_surface(probes, tree, turn) >= SHARE for turn in _ODD_TURNS):
        return math.inf
    for order in ORDERS:
        # Beyond half a turn they are the same turns the other way round.
        if all(_share_on_surface(probes, tree, step / order) >= SHARE for step in range(1, order // 2 + 1)):
            return float(order)
    return 1.0


def _share_on_surface(probes: Float[ndarray, "P 3"], tree: cKDTree, turn: float) -> float:
    """The share of points that lie on the surface again after a part of a full turn."""
    distance, _ = tree.query(probes @ rotation_about_y(2 * math.pi * turn).T, distance_upper_bound=TOLERANCE)
    return float(np.isfinite(distance).mean())
