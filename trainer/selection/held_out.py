"""The pictures that candidates are judged on: those that every training of the selection holds out."""

import numpy as np
from jaxtyping import Float, Int64
from torch import Tensor

from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.errors import DataError
from trainer.training.checks import check_pictures
from trainer.training.loop import split_instances

# Of fewer objects a standard error says little.
LEAST_OBJECTS = 10


def held_out(images: ImageSet, recipe: TrainConfig) -> Int64[Tensor, "N"]:
    """Numbers of the pictures that are held out; all pictures of an object are, or none is."""
    return split_instances(images, recipe.validation_share, recipe.seed)[1]


def by_object(values: Float[Tensor, "N"], images: ImageSet, recipe: TrainConfig) -> Float[np.ndarray, "objects"]:
    """The mean of each held-out object over its pictures, of whose values `values` has one each."""
    shown = images.instances[held_out(images, recipe).numpy()]
    _, numbers, counts = np.unique(shown, return_inverse=True, return_counts=True)
    return np.bincount(numbers, values.double().numpy()) / counts


def check_split(images: ImageSet, recipe: TrainConfig) -> None:
    """Raises DataError where there are too few objects, to train on or to judge by."""
    training, shown = split_instances(images, recipe.validation_share, recipe.seed)
    check_pictures(recipe, images, training)
    objects = len(np.unique(images.instances[shown.numpy()]))
    if objects < LEAST_OBJECTS:
        raise DataError(
            f"Expected {LEAST_OBJECTS} held-out objects or more to judge by, found {objects} of "
            f"{len(images.instance_names)}: add pictures, or raise --validation-share (at most 0.5)."
        )
