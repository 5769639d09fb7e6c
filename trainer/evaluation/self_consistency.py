"""Whether a model knows its own shapes again: seen from all sides, as no picture showed them.

What a picture hides of an object is a guess, and a crumpled one looks like nothing that the encoder was trained on: of
a picture from there it makes another shape. Nothing but the model is needed to tell, no other view and no truth.
"""

import math
from collections.abc import Callable, Iterable
from typing import Final

import numpy as np
import torch
from jaxtyping import Bool, Float, Int64, UInt8
from numpy import ndarray
from torch import Tensor

from trainer.config import SceneConfig
from trainer.evaluation.gallery import render
from trainer.evaluation.pictures import linear_batches
from trainer.evaluation.subject import Subject
from trainer.model.aggregate_posterior import MOST_PICTURES, AggregatePosterior, fit_aggregate_posterior
from trainer.model.vae import Model

SIDES_DEGREES: Final = (20.0, 110.0, 200.0, 290.0)
"""Azimuths at which shapes are drawn: no side is seen edge-on from all of them."""
UNKNOWN: Final = 0.15
"""So many of a class's pictures show what a model does not know again: of vessels it is the boats with sails."""
_BATCH: Final = 128


@torch.no_grad()
def self_distances(
    encode: Callable[[Float[Tensor, "B 3 H W"]], Float[Tensor, "B Z"]],
    decode: Callable[[Float[Tensor, "B Z"]], Float[Tensor, "B V 3"]],
    faces: Int64[Tensor, "F 3"],
    scene: SceneConfig,
    codes: Float[Tensor, "N Z"],
) -> Float[Tensor, "N"]:
    """How far the shapes of codes are from those that a model makes of pictures of them: root mean square over
    vertices, in the unit of the scene, in the mean of four sides."""

    def of_batch(codes: Float[Tensor, "B Z"]) -> Float[Tensor, "B"]:
        shapes = decode(codes)
        distances = []
        for side in SIDES_DEGREES:
            pictures = render(faces, scene, shapes, torch.full((len(shapes),), math.radians(side)))
            again = decode(encode(pictures.clamp(0, 1)))
            distances.append((again - shapes).square().sum(2).mean(1).sqrt())
        return torch.stack(distances).mean(0)

    return torch.cat([of_batch(batch) for batch in codes.split(_BATCH)])


def doubts(subject: Subject, pictures: UInt8[ndarray, "N 3 H W"]) -> Float[ndarray, "N"]:
    """`self_distances` of what a model makes of pictures."""

    def encode(linear: Float[Tensor, "B 3 H W"]) -> Float[Tensor, "B Z"]:
        return subject.infer(linear).shape_mean

    codes = torch.cat([encode(batch) for batch in linear_batches(pictures)])
    return np.asarray(self_distances(encode, subject.decode, subject.faces, subject.scene, codes))


def unknown(distances: Float[ndarray, "N"]) -> Bool[ndarray, "N"]:
    """The pictures, a share UNKNOWN of them, of which a model knows least again what it makes of them."""
    chosen = np.zeros(len(distances), np.bool_)
    chosen[np.argsort(-distances, kind="stable")[: round(UNKNOWN * len(distances))]] = True
    return chosen


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

    def encode(linear: Float[Tensor, "B 3 H W"]) -> Float[Tensor, "B Z"]:
        return model.encode(linear).shape_mean

    def doubts(codes: Float[ndarray, "M Z"]) -> Float[ndarray, "M"]:
        drawn = torch.from_numpy(codes.astype(np.float32))
        return np.asarray(self_distances(encode, model.decode, model.faces, scene, drawn))

    return fit_aggregate_posterior(means[::every], deviations[::every], doubts)
