"""All procedural classes, and the shape that a class and a seed name."""

from collections.abc import Callable
from difflib import get_close_matches

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.airplane import make_airplane
from trainer.data.shapes.bathtub import make_bathtub
from trainer.data.shapes.bench import make_bench
from trainer.data.shapes.car import make_car
from trainer.data.shapes.chair import make_chair
from trainer.data.shapes.jar import make_jar
from trainer.data.shapes.lamp import make_lamp
from trainer.data.shapes.loudspeaker import make_loudspeaker
from trainer.data.shapes.pot import make_pot
from trainer.data.shapes.rifle import make_rifle
from trainer.data.shapes.sofa import make_sofa
from trainer.data.shapes.solid import Mesh, normalise
from trainer.data.shapes.table import make_table
from trainer.data.shapes.vessel import make_vessel
from trainer.errors import ConfigError

CATEGORIES: dict[str, Callable[[Generator], Mesh]] = {
    "airplane": make_airplane,
    "bathtub": make_bathtub,
    "bench": make_bench,
    "car": make_car,
    "chair": make_chair,
    "jar": make_jar,
    "lamp": make_lamp,
    "loudspeaker": make_loudspeaker,
    "pot": make_pot,
    "rifle": make_rifle,
    "sofa": make_sofa,
    "table": make_table,
    "vessel": make_vessel,
}
"""Each class with the function that draws one object of it."""


def check_category(category: str) -> None:
    """Raises ConfigError for a class that does not exist, and names the nearest."""
    if category not in CATEGORIES:
        nearest = get_close_matches(category, CATEGORIES, 1)
        hint = f"; did you mean {nearest[0]!r}?" if nearest else ""
        raise ConfigError(f"expected a class out of {', '.join(sorted(CATEGORIES))}, found {category!r}{hint}")


def make_shape(category: str, seed: int) -> Mesh:
    """The object of a class that a seed names: the same on every call, centred, with a unit bounding-box diagonal.

    Raises ConfigError for a class that does not exist, and for a negative seed.
    """
    check_category(category)
    if seed < 0:
        raise ConfigError(f"expected a shape seed of 0 or more, found {seed}")
    return normalise(CATEGORIES[category](np.random.default_rng(seed)))
