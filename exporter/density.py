"""From pictures of the class to the density that the service draws samples from."""

import numpy as np
from jaxtyping import Float32
from numpy import ndarray

from service.density import AggregatePosterior, Gaussian
from service.inference import Engine, encode
from trainer.model.aggregate_posterior import LEAST_PICTURES, fit_aggregate_posterior

_DIGITS = 6


def fitted_density(engine: Engine, pictures: Float32[ndarray, "N 3 H W"]) -> AggregatePosterior | None:
    """Where a bundle's shape codes lie (`trainer.model.aggregate_posterior`), by pictures as its encoder gets them;
    None for too few."""
    if len(pictures) < LEAST_PICTURES:
        return None
    posteriors = [encode(engine, picture) for picture in pictures]
    means, deviations = (
        np.array(told, np.float64)
        for told in zip(*((one.shape_mean, one.shape_deviation) for one in posteriors), strict=True)
    )
    found = fit_aggregate_posterior(means, deviations)
    gaussians = tuple(
        Gaussian(
            weight=round(float(weight), _DIGITS),
            mean=tuple(np.round(mean, _DIGITS).tolist()),
            factor=tuple(tuple(np.round(row[: number + 1], _DIGITS).tolist()) for number, row in enumerate(factor)),
        )
        for weight, mean, factor in zip(found.weights, found.means, found.factors, strict=True)
    )
    return AggregatePosterior(numbers=found.numbers, gaussians=gaussians, pictures=found.pictures)
