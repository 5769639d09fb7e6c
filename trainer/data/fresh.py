"""Objects that are drawn anew for each step of a training, from directions that never come again.

Section 5 of the paper, "Training minibatches": meshes drawn uniformly with replacement, and a single picture of each at
a uniform azimuth. Threads draw ahead of the training; the rasteriser lets others compute meanwhile.
"""

import itertools
import math
from collections import deque
from collections.abc import Generator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numba
import numpy as np
import torch
from jaxtyping import Float, Float32
from numpy import ndarray
from torch import Tensor

from imaging.srgb import encode
from trainer import processes
from trainer.config import SceneConfig
from trainer.data.images import ImageSet, Preparation, image_set
from trainer.data.mesh_store import MeshStore, Ready
from trainer.data.metadata import Row
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings, instance_names, is_procedural, load_instance, poses
from trainer.data.source import MOST_SHOWN, Minibatch, step_generator
from trainer.errors import DataError

Drawn = tuple[Float[Tensor, "B 3 H W"], Float[Tensor, "B"]]
"""Pictures and their azimuths, radians."""


@dataclass(frozen=True)
class FreshViews:
    """A `PictureSource` whose pictures are drawn when they are needed."""

    scene: SceneConfig
    """Camera, lights, and the size at which is trained."""
    settings: RenderSettings
    names: tuple[str, ...]
    """The objects that are trained on."""
    held_out: tuple[str, ...]
    """The objects that are not; each is shown in one picture, always the same."""
    store: MeshStore

    @property
    def framed(self) -> bool:
        return True

    @property
    def training(self) -> int:
        return len(self.names)

    @property
    def validation(self) -> int:
        return len(self.held_out)

    def shown(self) -> Float[Tensor, "N 3 H W"]:
        readable = self._readable(self.held_out) or self._readable(self.names)
        if not readable:
            raise self._nothing_readable(self.names)
        pictures = []
        for name, found in readable:
            (pose,) = poses(self.settings, name, 1)
            angles = math.radians(pose.azimuth_degrees or 0.0), math.radians(pose.light_azimuth_degrees or 0.0)
            pictures.append(self._picture(found, *angles))
        return torch.from_numpy(np.stack(pictures))

    def _readable(self, names: tuple[str, ...]) -> list[tuple[str, Ready]]:
        """The first objects out of these that can be read."""
        readable = ((name, found) for name in names if (found := self.store.get(name)) is not None)
        return list(itertools.islice(readable, MOST_SHOWN))

    def some(self, most: int, seed: int) -> ImageSet:
        known, codes = [], []
        for number in range(most):
            picture, azimuth = self._drawn(range(number, number + 1), seed, 0, 1)
            known.append(Row(f"{number}", f"{number}", math.degrees(azimuth), None))
            codes.append(encode(picture[0].numpy()))
        return image_set(known, codes, self.scene, (), Preparation(framed=most))

    def minibatches(self, size: int, seed: int, start: int, views: int = 1) -> Generator[Minibatch]:
        # Half of the cores: the training has work for the others.
        threads = max(1, numba.get_num_threads() // 2)
        pool = ThreadPoolExecutor(threads, "fresh-views")
        ahead: deque[Future[Drawn]] = deque()
        try:
            for step in itertools.count(start):
                while len(ahead) <= threads:
                    ahead.append(pool.submit(self.drawn, size, seed, step + len(ahead), views))
                pictures, azimuths = ahead.popleft().result()
                yield Minibatch(pictures, azimuths, step_generator(seed, step))
        finally:
            pool.shutdown(cancel_futures=True)

    def drawn(self, size: int, seed: int, step: int, views: int = 1) -> Drawn:
        """The pictures of one step, each `views` consecutive ones of one object; this process's share of them.

        Raises DataError where none of the objects can be read.
        """
        return self._drawn(range(size)[processes.share(size)], seed, step, views)

    def sample(self, count: int, seed: int) -> Float[Tensor, "count 3 H W"]:
        """The first of those pictures, the same ones in every process. Raises DataError as `drawn` does."""
        return self._drawn(range(count), seed, 0, 1)[0]

    def _drawn(self, own: range, seed: int, step: int, views: int) -> Drawn:
        # Allocated by torch: its memory is aligned, so that what is computed from it is the same in every run.
        pictures, azimuths = torch.empty((len(own), 3, self.scene.height, self.scene.width)), torch.empty(len(own))
        for slot, place in enumerate(own):
            if place % views == 0:
                rng = np.random.default_rng([seed, step, place])
                found = self._any(rng)
            azimuth, light_azimuth = rng.uniform(-math.pi, math.pi), rng.uniform(0.0, math.pi)
            turned = light_azimuth if self.settings.rotate_lights else 0.0
            pictures.numpy()[slot] = self._picture(found, azimuth, turned)
            azimuths[slot] = azimuth
        return pictures, azimuths

    def _any(self, rng: np.random.Generator) -> Ready:
        """An object drawn uniformly out of those that can be read."""
        while True:
            found = self.store.get(self.names[rng.integers(len(self.names))])
            if found is not None:
                return found
            if self.store.broken.keys() >= set(self.names):
                raise self._nothing_readable(self.names)

    def _picture(self, ready: Ready, azimuth: float, light_azimuth: float) -> Float32[ndarray, "3 H W"]:
        scene, samples, closed = self.scene, self.settings.supersampling, is_procedural(self.settings)
        return draw(ready.mesh, azimuth, light_azimuth, scene, samples, ready.normals, closed)[0].transpose(2, 0, 1)

    def _nothing_readable(self, names: tuple[str, ...]) -> DataError:
        return DataError(
            f"none of the {len(names)} meshes in {self.settings.source} can be read; first: "
            f"{self.store.broken[names[0]]}"
        )


def fresh_views(
    settings: RenderSettings, scene: SceneConfig, instances: int | None, share: float, seed: int, most_bytes: int
) -> FreshViews:
    """Views of `instances` objects of a source, a `share` of which is held out; None means all that there are.

    Meshes that have been drawn stay in memory up to `most_bytes`. Raises ConfigError or DataError where the source has
    no such objects, or too few to train on.
    """
    names = instance_names(settings, instances)
    shuffled = [names[index] for index in np.random.default_rng(seed).permutation(len(names))]
    count = round(share * len(names))
    if len(names) - count < 2:
        raise DataError(
            f"Expected at least 2 objects to train on, found {len(names) - count} in {settings.source}. Add meshes."
        )
    store = MeshStore(partial(load_instance, settings), most_bytes)
    return FreshViews(scene, settings, tuple(sorted(shuffled[count:])), tuple(sorted(shuffled[:count])), store)
