"""Whether a model knows its own shapes again: seen from all sides, as no picture showed them.

What a picture hides of an object is a guess, and a crumpled one looks like nothing that the encoder was trained on: of
a picture from there it makes another shape. Nothing but the model is needed to tell, no other view and no truth.
"""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from trainer.config import SceneConfig
from trainer.evaluation.gallery import render
from trainer.model.aggregate_posterior import MOST_PICTURES, AggregatePosterior, fit_aggregate_posterior
from trainer.model.vae import Model

SIDES_DEGREES: Final = (20.0, 110.0, 200.0, 290.0)
"""Azimuths at which shapes are drawn: no side is seen edge-on from all of them."""
_BATCH: Final = 128


@torch.no_grad()
def self_distances(model: Model, scene: SceneConfig, codes: Float[Tensor, "N Z"]) -> Float[Tensor, "N"]:
    """How far the shapes of codes are from those that the model makes of pictures of them: root mean square over
    vertices, in the unit of the scene, in the mean of four sides."""
    return torch.cat([_of_batch(model, scene, batch) for batch in codes.split(_BATCH)])


def _of_batch(model: Model, scene: SceneConfig, codes: Float[Tensor, "B Z"]) -> Float[Tensor, "B"]:
    shapes = model.decode(codes)
    distances = []
    for side in SIDES_DEGREES:
        pictures = render(model.faces, scene, shapes, torch.full((len(shapes),), math.radians(side)))
        again = model.decode(model.encode(pictures.clamp(0, 1)).shape_mean)
        distances.append((again - shapes).square().sum(2).mean(1).sqrt())
    return torch.stack(distances).mean(0)


def consistent_posterior(
    model: Model, scene: SceneConfig, pictures: Iterable[Float[Tensor, "B 3 H W"]]
) -> AggregatePosterior:
    """Where a model's shape codes of pictures lie, those left out of whose shapes it knows least again; of more than
    MOST_PICTURES, so many at most, evenly chosen.

    Raises DataError as `fit_aggregate_posterior` does.
    """
    with torch.no_grad():
        posteriors = [model.encode(batch) for batch in pictures]
    means, deviations = (
        torch.cat(told).double().numpy()
        for told in zip(*((one.shape_mean, one.shape_deviation) for one in posteriors), strict=True)
    )
    every = max(1, math.ceil(len(means) / MOST_PICTURES))

    def doubts(codes: Float[ndarray, "M Z"]) -> Float[ndarray, "M"]:
        return np.asarray(self_distances(model, scene, torch.from_numpy(codes.astype(np.float32))))

    return fit_aggregate_posterior(means[::every], deviations[::every], doubts)
