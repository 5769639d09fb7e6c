"""All procedural classes, and the shape that a class and a seed name."""

from collections.abc import Callable
from difflib import get_close_matches

import numpy as np
from numpy.random import Generator

from trainer.data.shapes.car import make_car
from trainer.data.shapes.chair import make_chair
from trainer.data.shapes.solid import Mesh, normalise
from trainer.errors import ConfigError

CATEGORIES: dict[str, Callable[[Generator], Mesh]] = {
    "car": make_car,
    "chair": make_chair,
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
