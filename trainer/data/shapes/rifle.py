"""Rifles: for hunting, for sport, for soldiers of three centuries, with about one in eight that is unusual."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.rifle_automatic import make_assault, make_machine_gun, make_submachine
from trainer.data.shapes.rifle_manual import make_double, make_hunting, make_lever, make_musket, make_pump, make_sniper
from trainer.data.shapes.rifle_unusual import make_blunderbuss, make_bullpup, make_top_loader, make_toy
from trainer.data.shapes.solid import Mesh, moved


def make_rifle(rng: Generator) -> Mesh:
    """One rifle, metres, its lowest point on y = 0."""
    builders: tuple[tuple[float, Callable[[Generator], Mesh]], ...] = (
        (0.15, make_hunting),
        (0.22, make_assault),
        (0.13, make_sniper),
        (0.05, make_pump),
        (0.05, make_double),
        (0.08, make_bullpup),
        (0.06, make_musket),
        (0.06, make_lever),
        (0.09, make_submachine),
        (0.05, make_machine_gun),
        (0.04, make_top_loader),
        (0.04, make_blunderbuss),
        (0.04, make_toy),
    )
    shares = np.array([share for share, _ in builders])
    rifle = builders[rng.choice(len(builders), p=shares / shares.sum())][1](rng)
    return moved(rifle, (0.0, -float(rifle.vertices[:, 1].min()), 0.0))
