"""From where a model has the shape codes of pictures to what a manifest says of it, by which samples are drawn."""

import numpy as np

from service.density import AggregatePosterior, Gaussian
from trainer.model import aggregate_posterior as fitted

_DIGITS = 4


def told(found: fitted.AggregatePosterior) -> AggregatePosterior:
    """The same density, its numbers rounded."""
    gaussians = tuple(
        Gaussian(
            weight=round(float(weight), _DIGITS),
            mean=tuple(np.round(mean, _DIGITS).tolist()),
            factor=tuple(tuple(np.round(row[: number + 1], _DIGITS).tolist()) for number, row in enumerate(factor)),
        )
        for weight, mean, factor in zip(found.weights, found.means, found.factors, strict=True)
    )
    return AggregatePosterior(numbers=found.numbers, gaussians=gaussians, pictures=found.pictures)
