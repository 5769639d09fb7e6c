"""The judge's figures: overlap of shapes, errors of azimuths, and how sure we are of either.

Angles are radians. `correct` azimuths are within 30°, as in the paper (section 5.2).
"""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Integer
from numpy import ndarray
from numpy.random import Generator
from scipy.optimize import minimize_scalar
from scipy.special import log_softmax

CORRECT_WITHIN = np.radians(30.0)
"""Largest error of an azimuth that counts as correct."""
FLIPPED_BEYOND = np.radians(150.0)
"""Beyond this error an object was taken for its own back."""
TEMPERATURES: Final = (0.1, 100.0)
"""Those that are looked for; at the highest, twelve bins of which one was certain are all about as probable."""


class Interval(NamedTuple):
    """A mean or median over objects with its 95 % bootstrap interval."""

    value: float
    low: float
    high: float


def iou(first: Bool[ndarray, "*#N R R R"], second: Bool[ndarray, "*#N R R R"]) -> Float[ndarray, "..."]:
    """Intersection over union of occupancy grids, which broadcast; 1 for two empty ones."""
    grid = (-3, -2, -1)
    union = (first | second).sum(grid)
    return np.where(union > 0, (first & second).sum(grid) / np.maximum(union, 1), 1.0)


def azimuth_error(predicted: Float[ndarray, "N"], true: Float[ndarray, "N"]) -> Float[ndarray, "N"]:
    """Angle between azimuths, 0 … π."""
    angle: Float[ndarray, " N"] = np.abs(np.remainder(predicted - true + np.pi, 2 * np.pi) - np.pi)
    return angle


def symmetric_azimuth_error(
    predicted: Float[ndarray, "N"], true: Float[ndarray, "N"], orders: Float[ndarray, "N"]
) -> Float[ndarray, "N"]:
    """The least of the errors against all azimuths at which the object looks as it does, 0 … π/n.

    `orders` are those of `trainer.evaluation.symmetry`: an object of order n repeats after 2π/n, one of order infinity
    looks the same at every azimuth.
    """
    error = azimuth_error(predicted, true)
    period = 2 * np.pi / orders
    turns = np.round(np.divide(error, period, out=np.zeros_like(error), where=period > 0))
    return np.where(period > 0, np.abs(error - turns * period), 0.0)


def mean(values: Float[ndarray, "N"]) -> float:
    """The mean, as a plain number."""
    return float(np.mean(values))


def median_error(errors: Float[ndarray, "N"]) -> float:
    """The paper's *err*."""
    return float(np.median(errors))


def accuracy(errors: Float[ndarray, "N"]) -> float:
    """The paper's *acc*: the share of azimuths within 30°."""
    return float(np.mean(errors <= CORRECT_WITHIN))


def calibration_error(told: Float[ndarray, "N 2"]) -> float:
    """The expected calibration error (Guo et al., "On calibration of modern neural networks", ICML 2017): how far
    confidence is from the share of right answers, averaged over ten equal ranges of confidence by their pictures.

    `told` holds each answer's confidence, and 1 where it was right or 0. 0 is honest; 0.5 a guess between two that
    calls itself sure.
    """
    confidence, right = told.T
    ranges = np.minimum((10 * confidence).astype(int), 9)
    return float(np.abs(np.bincount(ranges, confidence - right)).sum() / len(told))


def fit_azimuth_offset(predicted: Float[ndarray, "N"], true: Float[ndarray, "N"]) -> float:
    """The one rotation that, added to all predicted azimuths, aligns them best with the true ones, in [-π, π).

    It minimises the mean of min(|error|, 30°): the pictures within 30° decide by their absolute errors, and how wrong
    the others are does not matter, so that neither flips nor guesses pull it aside. Exact: between the pictures' own
    offsets this mean is concave or linear, so its least value lies at one of them.

    To be fitted on validation pictures, never on those that are judged. Raises ValueError without a picture.
    """
    if len(predicted) == 0 or len(predicted) != len(true):
        raise ValueError(
            f"expected as many predicted as true azimuths, one at least, found {len(predicted)}, {len(true)}"
        )
    offsets = np.unique(np.remainder(true - predicted + np.pi, 2 * np.pi) - np.pi)
    own = true - predicted
    costs = [np.minimum(azimuth_error(np.full_like(own, offset), own), CORRECT_WITHIN).mean() for offset in offsets]
    # Equal up to rounding is equal: the first one is taken, whatever the order of the pictures.
    return float(offsets[np.flatnonzero(costs <= min(costs) + 1e-12)[0]])


def tempered(probabilities: Float[ndarray, "N R"], temperature: float) -> Float[ndarray, "N R"]:
    """Probabilities whose logarithms are divided by a temperature: above 1 they are less sure, in the same order."""
    result: Float[ndarray, "N R"] = np.exp(_tempered_logarithms(probabilities, temperature))
    return result


def fit_temperature(probabilities: Float[ndarray, "N R"], true: Integer[ndarray, "N"]) -> float:
    """The temperature of bins' probabilities at which the true bins are most probable (Guo et al., section 4.2), within
    TEMPERATURES. One number for a model changes no answer, only how sure it is.

    To be fitted on validation pictures, never on those that are judged.
    """
    pictures = np.arange(len(true))

    def surprise(logarithm: float) -> float:
        return -float(_tempered_logarithms(probabilities, np.exp(logarithm))[pictures, true].mean())

    return float(np.exp(minimize_scalar(surprise, bounds=np.log(TEMPERATURES), method="bounded").x))


def _tempered_logarithms(probabilities: Float[ndarray, "N R"], temperature: float) -> Float[ndarray, "N R"]:
    # What a graph's float32 has rounded to 0 is no less probable than its smallest number.
    least = np.finfo(np.float32).tiny
    logarithms: Float[ndarray, "N R"] = log_softmax(np.log(np.maximum(probabilities, least)) / temperature, 1)
    return logarithms


def bootstrap(
    values: Float[ndarray, "N *K"],
    objects: Integer[ndarray, "N"],
    rng: Generator,
    statistic: Callable[[Float[ndarray, "M *K"]], float] = mean,
    rounds: int = 1000,
) -> Interval:
    """A statistic of all values with its 95 % interval: whole objects, with all their views, are drawn anew.

    Views of one object resemble each other; drawing pictures one by one would make the interval too narrow.
    """
    _, codes = np.unique(objects, return_inverse=True)
    order = np.argsort(codes, kind="stable")
    groups = np.split(values[order], np.cumsum(np.bincount(codes))[:-1])
    drawn = [
        statistic(np.concatenate([groups[index] for index in rng.integers(len(groups), size=len(groups))]))
        for _ in range(rounds)
    ]
    low, high = np.percentile(drawn, (2.5, 97.5))
    return Interval(statistic(values), float(low), float(high))


def mean_shape(training: Bool[ndarray, "N R R R"]) -> Bool[ndarray, "R R R"]:
    """The baseline that knows the class but not the picture: the voxels that are full in at least a share of the
    training shapes; the share, out of 19 from 5 % to 95 %, is the one with the best mean IoU on those shapes."""
    shares = training.mean(0)
    candidates = [shares >= share for share in np.arange(1, 20) / 20]
    return max(candidates, key=lambda candidate: float(iou(training, candidate[None]).mean()))
