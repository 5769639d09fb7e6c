"""Rotational symmetry of what a picture says about pose: which turns it does not tell apart."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

ALIKE: Final = 0.7
"""How well a posterior has to agree with itself turned, 1 being in full (docs/results/symmetry.json)."""


def symmetry_order(probabilities: NDArray[np.floating]) -> int:
    """The largest n for which turns by 360° / n make no difference to the probabilities [R] of evenly spaced bins: 1
    where all turns are told apart, R where none is.

    The posterior agrees with itself k bins further as far as Σ pᵣ pᵣ₊ₖ / Σ pᵣ² says.
    """
    bins = len(probabilities)
    further = np.arange(bins)[:, None] + np.arange(bins)
    agreement = probabilities[further % bins] @ probabilities
    orders = (order for order in range(bins, 1, -1) if bins % order == 0)
    return next((order for order in orders if agreement[:: bins // order].min() >= ALIKE * agreement[0]), 1)
