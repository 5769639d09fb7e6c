"""Means over seeds and classes, and how sure we are of them."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit


class Mean(NamedTuple):
    """A mean with its 95 % interval, value ± margin."""

    value: float
    margin: float | None
    """None for a single value, which tells nothing about others."""
    size: int
    """How many values."""


def mean_of(values: Sequence[float]) -> Mean | None:
    """The mean with Student's interval, which is right for few values that scatter normally; None of no values."""
    if not values:
        return None
    count = len(values)
    if count == 1:
        return Mean(float(values[0]), None, 1)
    margin = float(stdtrit(count - 1, 0.975)) * float(np.std(values, ddof=1)) / math.sqrt(count)
    return Mean(float(np.mean(values)), margin, count)
