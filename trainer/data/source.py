"""Where a training's pictures come from: a folder that was decoded once, or views that are drawn for each step."""

import itertools
from collections.abc import Generator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import torch
from jaxtyping import Float, Int, Int64
from numpy import ndarray
from torch import Tensor

from trainer import processes
from trainer.config import SceneConfig
from trainer.data.images import ImageSet

MOST_SHOWN = 6
"""Pictures of a preview."""


class Minibatch(NamedTuple):
    """What one step is trained on."""

    pictures: Float[Tensor, "B 3 H W"]
    """Linear, 0..1, in float32 on the CPU."""
    azimuths: Float[Tensor, "B"] | None
    """True azimuths θ, radians; None where they are not known."""
    generator: torch.Generator
    """The step's own randomness, from where the choice of the pictures has left it."""


class PictureSource(Protocol):
    """Pictures to train on, and pictures to watch the training by."""

    @property
    def scene(self) -> SceneConfig:
        """Camera and lights of all pictures."""

    @property
    def framed(self) -> bool:
        """Whether objects are where the scene's camera has them; else they were cut out, and a rule has set them."""

    @property
    def training(self) -> int:
        """How many pictures (of a folder) or objects (drawn anew) are trained on."""

    @property
    def validation(self) -> int:
        """How many pictures are held out."""

    def shown(self) -> Float[Tensor, "N 3 H W"]:
        """The same few pictures on every call, held-out ones where there are any."""

    def some(self, most: int, seed: int) -> ImageSet:
        """So many of the pictures that are trained on, or all where there are no more, the same ones in every
        process."""

    def minibatches(self, size: int, seed: int, start: int, views: int = 1) -> Generator[Minibatch]:
        """The minibatches of steps `start`, `start` + 1 …, without end; each depends on `seed` and its step alone.

        Of the `size` pictures each `views` consecutive ones show one object; `views` divides `size`. Of processes that
        train together each gets its share of the pictures, and the same generator.
        To be closed: it may hold threads.
        """


@dataclass(frozen=True)
class FolderPictures:
    """The pictures of a folder, some of them held out."""

    images: ImageSet
    chosen: Int64[Tensor, "T"]
    """Numbers of the pictures that are trained on."""
    held_out: Int64[Tensor, "N"]
    """Numbers of the others."""

    @property
    def scene(self) -> SceneConfig:
        return self.images.scene

    @property
    def framed(self) -> bool:
        return self.images.framed

    @property
    def training(self) -> int:
        return len(self.chosen)

    @property
    def validation(self) -> int:
        return len(self.held_out)

    def shown(self) -> Float[Tensor, "N 3 H W"]:
        return self.images.batch((self.held_out if len(self.held_out) else self.chosen)[:MOST_SHOWN])

    def some(self, most: int, seed: int) -> ImageSet:
        order = torch.randperm(len(self.chosen), generator=step_generator(seed, 0))
        return self.images.of(self.chosen[order[:most]].numpy())

    def minibatches(self, size: int, seed: int, start: int, views: int = 1) -> Generator[Minibatch]:
        known = self.images.azimuths
        azimuths = None if known is None else torch.as_tensor(known, dtype=torch.float32)
        for step in itertools.count(start):
            generator = step_generator(seed, step)
            if views == 1:
                chosen = batch_indices(self.chosen, size, generator)
            else:
                chosen = grouped_indices(self.chosen, self.images.instances, size // views, views, generator)
            chosen = chosen[processes.share(size)]
            yield Minibatch(self.images.batch(chosen), None if azimuths is None else azimuths[chosen], generator)


def step_generator(seed: int, step: int) -> torch.Generator:
    """The randomness of one step of one training."""
    return torch.Generator().manual_seed(seed * 1_000_003 + step)


def batch_indices(pictures: Int64[Tensor, "T"], size: int, generator: torch.Generator) -> Int64[Tensor, "B"]:
    """A batch drawn uniformly with replacement (section 5, "Training minibatches")."""
    return pictures[torch.randint(len(pictures), (size,), generator=generator)]


def grouped_indices(
    pictures: Int64[Tensor, "T"],
    instances: Int[ndarray, "N"],
    objects: int,
    views: int,
    generator: torch.Generator,
) -> Int64[Tensor, "objects_views"]:
    """Pictures of `objects` objects drawn uniformly with replacement, `views` different ones of each, side by side.

    `instances` says of each picture of the folder which object it shows; each has at least `views` among `pictures`.
    """
    order = pictures[torch.as_tensor(instances[pictures.numpy()]).argsort(stable=True)]
    _, counts = torch.as_tensor(instances[order.numpy()]).unique_consecutive(return_counts=True)
    firsts = counts.cumsum(0) - counts
    chosen = torch.randint(len(counts), (objects,), generator=generator)
    # The first few of a random order of an object's pictures; those beyond its own come last.
    keys = torch.rand(objects, int(counts.max()), generator=generator)
    keys = torch.where(torch.arange(keys.shape[1]) < counts[chosen, None], keys, 2.0)
    return order[firsts[chosen, None] + keys.argsort(1)[:, :views]].flatten()
