"""What does without a model: figures are to be read beside those of guesses that know other objects of the class."""

import numpy as np
import torch
from jaxtyping import Bool, Float, Integer, UInt8
from numpy import ndarray
from torch import Tensor
from torch.nn import functional

from trainer.evaluation.metrics import iou, mean_shape
from trainer.evaluation.pictures import Pictures, Validation, linear_batches

# Height and width at which pictures are compared: what is finer tells little about the shape.
_SIZE = (48, 64)


def mean_shape_overlaps(pictures: Pictures, voxels: Bool[ndarray, "K R R R"]) -> Float[ndarray, "N"]:
    """IoU of each picture's object with the mean shape of the validation objects: knows the class, not the picture."""
    mean = mean_shape(voxels)
    overlaps = np.array([float(iou(mean, truth.voxels)) for truth in pictures.truth])
    of_pictures: Float[ndarray, N] = overlaps[pictures.objects]
    return of_pictures


def nearest_neighbour_overlaps(
    pictures: Pictures, validation: Validation, voxels: Bool[ndarray, "K R R R"]
) -> Float[ndarray, "N"]:
    """IoU of each picture's object with that validation object which a picture shows that resembles it most: knows
    pictures and their shapes, but not how either comes about."""
    neighbours = validation.objects[nearest_pictures(pictures.codes, validation.codes)]
    return np.array(
        [
            float(iou(voxels[neighbour], pictures.truth[index].voxels))
            for neighbour, index in zip(neighbours, pictures.objects, strict=True)
        ]
    )


def nearest_pictures(codes: UInt8[ndarray, "N 3 H W"], others: UInt8[ndarray, "M 3 H W"]) -> Integer[ndarray, "N"]:
    """For each picture the number of the one out of `others` with the least squared difference, in linear light at
    64 × 48."""
    reference = _reduced(others)
    squares = reference.square().sum(1)
    # |a - b|² = |a|² - 2 a·b + |b|², where |a|² decides nothing.
    nearest: Integer[ndarray, N] = (squares - 2 * _reduced(codes) @ reference.T).argmin(1).numpy()
    return nearest


def _reduced(codes: UInt8[ndarray, "N 3 H W"]) -> Float[Tensor, "N D"]:
    small = [functional.interpolate(batch, size=_SIZE, mode="area") for batch in linear_batches(codes)]
    return torch.cat(small).flatten(1)
