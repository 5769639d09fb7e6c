"""Pictures that are read from shards while the training goes on: memory holds a few of them, however many there are.

The shards of an epoch are put in random order, a few of them at a time are decoded into memory, and the minibatches of
a while are drawn from these; the next few are decoded meanwhile. What a step sees depends on the seed and its number
alone: a training that goes on opens the shards it needs, and no other.
"""

import itertools
import logging
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from trainer import processes
from trainer.config import SceneConfig
from trainer.data.decoding import Decoded, decode_content, decoders
from trainer.data.images import ImageSet, Preparation, fitted, frame_in, image_set
from trainer.data.lens import largest_zoom, zoomed
from trainer.data.scene import read_scene
from trainer.data.shards import Shard, read_index, read_shard
from trainer.data.source import MOST_SHOWN, Minibatch, batch_indices, grouped_indices, step_generator
from trainer.errors import DataError

logger = logging.getLogger(__name__)


class Window(NamedTuple):
    """A few shards that are in memory at the same time, and for how many steps."""

    shards: tuple[Shard, ...]
    steps: int


@dataclass(frozen=True)
class ShardPictures:
    """A `PictureSource` of tar files."""

    folder: Path
    scene: SceneConfig
    """Camera, lights, and the size at which is trained."""
    framed: bool
    """Whether the pictures are renderings of that scene; else their objects are cut out and framed."""
    shards: tuple[Shard, ...]
    held_out: tuple[Shard, ...]
    at_once: int
    """Shards that are in memory together, of which the minibatches of a while are drawn; while they are, as many more
    are decoded."""

    @property
    def training(self) -> int:
        return sum(shard.pictures for shard in self.shards)

    @property
    def validation(self) -> int:
        return sum(shard.pictures for shard in self.held_out)

    def shown(self) -> Float[Tensor, "N 3 H W"]:
        images = self.load((self.held_out or self.shards)[:1])
        return images.batch(np.arange(min(MOST_SHOWN, len(images))))

    def some(self, most: int, seed: int) -> ImageSet:
        order = np.random.default_rng([seed, 0]).permutation(len(self.shards))
        found = itertools.accumulate(self.shards[number].pictures for number in order)
        enough = sum(pictures < most for pictures in found) + 1
        images = self.load(tuple(self.shards[number] for number in order[:enough]))
        return images.of(np.random.default_rng([seed, 1]).permutation(len(images))[:most])

    def minibatches(self, size: int, seed: int, start: int, views: int = 1) -> Generator[Minibatch]:
        with ThreadPoolExecutor(1, "shards") as ahead:
            windows = itertools.chain.from_iterable(self.windows(size, seed, epoch) for epoch in itertools.count())
            step, loading = 0, None
            for window, following in itertools.pairwise(windows):
                if step + window.steps > start:
                    images = loading.result() if loading else self.load(window.shards)
                    loading = ahead.submit(self.load, following.shards)
                    choose = _choosing(images, size, views)
                    for now in range(max(start, step), step + window.steps):
                        generator = step_generator(seed, now)
                        chosen = choose(generator)[processes.share(size)]
                        azimuths = None if images.azimuths is None else torch.tensor(images.azimuths).float()[chosen]
                        yield Minibatch(images.batch(chosen), azimuths, generator)
                step += window.steps

    def windows(self, size: int, seed: int, epoch: int) -> Iterator[Window]:
        """Those of one pass over all shards; of processes that train together each has shards of its own."""
        order = np.random.default_rng([seed, epoch]).permutation(len(self.shards))[
            processes.number() :: processes.count()
        ]
        for first in range(0, len(order), self.at_once):
            shards = tuple(self.shards[number] for number in order[first : first + self.at_once])
            pictures = sum(shard.pictures for shard in shards)
            yield Window(shards, max(1, pictures * processes.count() // size))

    def load(self, shards: tuple[Shard, ...]) -> ImageSet:
        """The pictures of these shards, decoded. Raises DataError where none of them can be used."""
        decode = partial(decode_content, frame=frame_in(self.scene), framed=self.framed)
        rows, pictures, unusable = [], [], []
        with decoders() as pool:
            for shard in shards:
                samples = read_shard(self.folder / shard.name)
                names = [f"{shard.name}, {row.file_name}" for row, _ in samples]
                contents = [content for _, content in samples]
                decoded = pool.map(decode, contents, names)
                for (row, _), found in zip(samples, decoded, strict=True):
                    if isinstance(found, Decoded):
                        rows.append(row)
                        pictures.append(found.codes)
                    else:
                        unusable.append(found.sentence)
        if unusable:
            logger.warning(
                "skipped %d of %d pictures; first: %s", len(unusable), len(unusable) + len(rows), unusable[0]
            )
        if not rows:
            raise DataError(f"none of the pictures in {', '.join(shard.name for shard in shards)} can be used")
        return image_set(rows, pictures, self.scene, tuple(unusable), Preparation())


def _choosing(images: ImageSet, size: int, views: int) -> Callable[[torch.Generator], Tensor]:
    everything = torch.arange(len(images))
    if views == 1:
        return lambda generator: batch_indices(everything, size, generator)
    return lambda generator: grouped_indices(everything, images.instances, size // views, views, generator)


def open_shards(
    folder: Path, width: int, height: int, own: SceneConfig, share: float, at_once: int, zoom: float = 1.0
) -> ShardPictures:
    """The shards of a folder, at least one of which (and about a `share`) is held out where that is not 0.

    Without a scene.json, the pictures' objects are cut out and brought into the frame of the scene `own`. All are then
    enlarged about their middle, `zoom` times; 0 is as far as the objects of the first shard allow. Raises DataError
    where there are too few shards.
    """
    shards = read_index(folder)
    count = max(1, round(share * len(shards))) if share and len(shards) > 1 else 0
    if len(shards) - count < processes.count():
        raise DataError(
            f"Expected a shard or more to train on for each of {processes.count()} processes, found "
            f"{len(shards) - count} in {folder}. Write smaller shards, or start fewer processes."
        )
    rendered = read_scene(folder)
    scene = fitted(rendered or own, width, height)
    kept, held_out = tuple(shards[: len(shards) - count]), tuple(shards[len(shards) - count :])
    source = ShardPictures(folder, zoomed(scene, zoom or 1.0), rendered is not None, kept, held_out, at_once)
    if zoom:
        return source
    return replace(source, scene=zoomed(scene, largest_zoom(source.load(kept[:1]).pictures)))
