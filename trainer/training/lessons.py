"""What the encoder is taught in the last phase of a training: pictures, and what a longer look finds in them."""

import itertools
from collections.abc import Callable, Generator
from contextlib import closing
from copy import deepcopy
from functools import partial
from typing import Final, NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from trainer import processes
from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.data.source import PictureSource, batch_indices, step_generator
from trainer.errors import DataError
from trainer.model.posterior import Posterior
from trainer.training.checkpoint import Checkpoint
from trainer.training.longer_look import Look, joined, look_longer

MOST_STUDIED: Final = 4096
"""At most so many pictures are looked at longer, and taught."""
_LOOKED_AT_ONCE: Final = 256


class Studied(NamedTuple):
    """Pictures that were looked at longer."""

    images: ImageSet
    look: Look


def study(
    checkpoint: Checkpoint, images: ImageSet, steps: int, device: torch.device, stopped: Callable[[], bool]
) -> Studied | None:
    """What so many steps of a longer look find; None where it was stopped first.

    Raises DataError where what the model makes of pictures cannot be drawn.
    """
    model, found = deepcopy(checkpoint.model).eval().to(device), []
    for numbers in torch.arange(len(images)).split(_LOOKED_AT_ONCE):
        if stopped():
            return None
        try:
            pictures = images.batch(numbers).to(device)
            found.append(look_longer(model, checkpoint.scene, checkpoint.config, pictures, steps))
        except FloatingPointError as error:
            raise DataError(
                f"Expected shapes that can be drawn: {error}. Train again with a lower --optimiser.learning-rate, and "
                "look at the pictures."
            ) from error
    return Studied(images, joined(found))


class Lesson(NamedTuple):
    """What one step is taught by."""

    pictures: Float[Tensor, "B 3 H W"]
    """Linear, 0..1."""
    look: Look | None
    """What a longer look finds in them."""
    generator: torch.Generator


def lessons(config: TrainConfig, source: Studied | PictureSource, start: int) -> Generator[Lesson]:
    """Those of steps `start`, `start` + 1 …, without end; of processes that train together each gets its share."""
    size, seed = config.optimiser.batch_size, config.seed
    if not isinstance(source, Studied):
        with closing(source.minibatches(size, seed, start)) as minibatches:
            for pictures, _, generator in minibatches:
                yield Lesson(pictures, None, generator)
        return
    everything = torch.arange(len(source.images))
    for step in itertools.count(start):
        generator = step_generator(seed, step)
        chosen = batch_indices(everything, size, generator)[processes.share(size)]
        look = source.look.each(partial(torch.index_select, dim=0, index=chosen))
        yield Lesson(source.images.batch(chosen), look, generator)


def told(said: Posterior, look: Look | None) -> Posterior:
    """What is taught: the encoder's word, its means replaced by what a longer look finds."""
    if look is None:
        return said
    light = said.light
    if light is not None and look.light_fine is not None:
        light = light._replace(fine_mean=look.light_fine)
    return said._replace(shape_mean=look.shape_code, azimuth_fine_mean=look.azimuth_fine, light=light)
