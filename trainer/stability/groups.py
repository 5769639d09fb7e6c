"""Untouched pictures, by what they show: the side that is seen, thin and thick objects, symmetric ones."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import binary_erosion

from trainer.evaluation.pictures import Pictures, Voxels
from trainer.stability.answers import Answers, figures_of

_SIDES_DEGREES = (0, 15, 30, 45, 60, 75, 90)
_QUARTERS = 4


def groups(told: Answers, pictures: Pictures) -> dict[str, list[dict[str, Any]]]:
    """Figures of each group, in order of what tells them apart; groups without a picture are left out."""
    thinness = np.array([thinness_of(truth.voxels) for truth in pictures.truth])
    orders = np.array([truth.order for truth in pictures.truth])
    edges = np.quantile(thinness, np.linspace(0, 1, _QUARTERS + 1))
    quarter = np.searchsorted(edges[1:-1], thinness[pictures.objects], side="left")
    kind = _kinds(orders)[pictures.objects]
    return {
        "side": _figures(told, _by_side(pictures.azimuths), _side_names()),
        "thinness": _figures(told, quarter, [f"{low:.2f} to {high:.2f}" for low, high in pairwise(edges)]),
        "symmetry": _figures(told, kind, ["none", "2", "3 and more", "continuous"]),
    }


def thinness_of(voxels: Voxels) -> float:
    """The share of an object's voxels that lie at its surface: 1 where it is thin everywhere, or is not there."""
    inner: Bool[ndarray, "R R R"] = binary_erosion(voxels)
    return 1 - float(inner.sum()) / max(1, int(voxels.sum()))


def _by_side(azimuths: Float[ndarray, "N"]) -> ndarray:
    """Which of the sides: how far from its front or back, whichever is nearer, the object is turned."""
    turned = np.degrees(np.abs(np.remainder(azimuths + math.pi, 2 * math.pi) - math.pi))
    return np.asarray(np.digitize(np.minimum(turned, 180 - turned), _SIDES_DEGREES[1:-1]))


def _side_names() -> list[str]:
    return [f"{low}° to {high}°" for low, high in pairwise(_SIDES_DEGREES)]


def _kinds(orders: Float[ndarray, "K"]) -> ndarray:
    return np.select([orders == 1, orders == 2, np.isfinite(orders)], [0, 1, 2], 3)


def _figures(told: Answers, group: ndarray, names: Sequence[str]) -> list[dict[str, Any]]:
    return [
        {"group": name, **figures_of(told.of(group == number))}
        for number, name in enumerate(names)
        if (group == number).any()
    ]
