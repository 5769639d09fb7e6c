"""From pictures of the class to the density that the service draws samples from."""

import numpy as np
import torch
from jaxtyping import Float, Float32
from numpy import ndarray

from service.density import AggregatePosterior, Gaussian
from trainer.model.aggregate_posterior import LEAST_PICTURES, fit_aggregate_posterior
from trainer.model.vae import Model

_DIGITS, _BATCH = 4, 64


def fitted_density(model: Model, pictures: Float32[ndarray, "N 3 H W"]) -> AggregatePosterior | None:
    """Where a model's shape codes lie, by pictures as its encoder gets them; None for too few."""
    if len(pictures) < LEAST_PICTURES:
        return None
    with torch.no_grad():
        posteriors = [model.encode(part) for part in torch.from_numpy(pictures).split(_BATCH)]
    means, deviations = (
        torch.cat(told).double().numpy()
        for told in zip(*((one.shape_mean, one.shape_deviation) for one in posteriors), strict=True)
    )
    return density_of(means, deviations)


def density_of(means: Float[ndarray, "N Z"], deviations: Float[ndarray, "N Z"]) -> AggregatePosterior:
    """What the manifest says of posteriors (`trainer.model.aggregate_posterior`)."""
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
