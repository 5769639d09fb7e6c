"""A folder of pictures, decoded into memory."""

import dataclasses
import logging
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float, Int, Integer, UInt8
from numpy import ndarray
from torch import Tensor

from imaging.framing import Frame, frame_of
from imaging.srgb import decode_table
from rasteriser.compilation import kernel
from trainer.config import SceneConfig
from trainer.data.decoding import Decoded, Unusable, decode_picture, decoders
from trainer.data.lens import largest_zoom, through_lens_of, zoomed
from trainer.data.metadata import METADATA_FILE, Row, read_metadata
from trainer.data.scene import read_scene
from trainer.errors import DataError

FORMATS = (".png", ".jpg", ".jpeg", ".webp")
"""File name endings that are read, in lower case."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Preparation:
    """How the pictures of a folder were brought into the model's frame."""

    framed: int = 0
    """Pictures that were in it already: the folder has a scene.json."""
    alpha: int = 0
    """Pictures whose object was cut out by their transparency."""
    background: int = 0
    """Pictures from which a plain background was removed."""
    refused: tuple[str, ...] = ()
    """A sentence for each picture whose object cannot be told from its background."""


@dataclass(frozen=True)
class ImageSet:
    """Pictures of one size, and what is known about them."""

    pictures: UInt8[ndarray, "N 3 H W"]
    """sRGB codes: a quarter of the memory of linear floats, at a step too small to see."""
    names: tuple[str, ...]
    """Path of each picture, relative to the folder."""
    instances: Int[ndarray, "N"]
    """Which object each picture shows, 0 … number of objects - 1; views of one object share a number."""
    instance_names: tuple[str, ...]
    """The name of each object."""
    azimuths: Float[ndarray, "N"] | None
    """The true azimuth θ of each picture, radians; None unless it is known for all of them."""
    light_azimuths: Float[ndarray, "N"] | None
    """How far the lights are turned, radians; None unless it is known for all pictures."""
    scene: SceneConfig
    """Camera and lights, at the size of `pictures`."""
    skipped: tuple[str, ...]
    """A sentence for each file that could not be read."""
    preparation: Preparation = Preparation()
    """How the pictures came to be as they are."""

    def __len__(self) -> int:
        return len(self.names)

    @property
    def framed(self) -> bool:
        """Whether objects are where a camera has them; else a rule has set them."""
        return self.preparation.framed > 0

    def of(self, numbers: Int[ndarray, "M"]) -> "ImageSet":
        """Some of the pictures."""
        objects, instances = np.unique(self.instances[numbers], return_inverse=True)
        return dataclasses.replace(
            self,
            pictures=self.pictures[numbers],
            names=tuple(self.names[number] for number in numbers),
            instances=instances,
            instance_names=tuple(self.instance_names[number] for number in objects),
            azimuths=None if self.azimuths is None else self.azimuths[numbers],
            light_azimuths=None if self.light_azimuths is None else self.light_azimuths[numbers],
        )

    def batch(self, indices: Integer[ndarray, "B"] | Integer[Tensor, "B"]) -> Float[Tensor, "B 3 H W"]:
        """Linear pictures 0..1 of the given numbers, in float32 on the CPU."""
        chosen = np.asarray(indices, np.int64)
        # Allocated by torch: its memory is aligned, so that what is computed from it is the same in every run.
        linear = torch.empty((len(chosen), *self.pictures.shape[1:]))
        _look_up(self.pictures.reshape(len(self), -1), chosen, decode_table(), linear.numpy().reshape(len(chosen), -1))
        return linear


def load_image_folder(
    folder: Path, width: int, height: int, own: SceneConfig | None = None, zoom: float | None = None
) -> ImageSet:
    """All PNG, JPEG and WebP pictures in a folder and below it, at `width` × `height`, in order of their names.

    A folder with a `scene.json` was rendered in that scene's frame: its pictures are scaled to fit by area averaging in
    linear light, and padded evenly with black where their aspect differs; where padding enlarges the height, the
    scene's field of view is widened to match. The pictures of any other folder are brought into the frame of the scene
    `own`, by default the default one: the object is told by its transparency, or else by a plain background, and set on
    black, cropped and scaled to stand where renderings stand (see `imaging.preparation`). All are then enlarged about
    their middle: `zoom` times, where 0 is as far as their objects allow, or by default so that they are what the camera
    of `own` sees (`data.lens`).

    `metadata.csv` is used where present: without it each picture is an object of its own and no azimuth is known.
    Pictures that cannot be read, whose object cannot be told, that metadata.csv does not name, or that it names in
    vain, are counted and named in one warning each kind. Raises DataError where the folder is missing or holds no
    picture that can be used.
    """
    names = _picture_names(folder)
    rows = read_metadata(folder)
    if rows is not None:
        names = _named_in_both(folder, names, rows)
    rendered = read_scene(folder)
    scene = fitted(rendered or own or SceneConfig(width=height, height=height), width, height)

    def load(scene: SceneConfig, zoom: float) -> ImageSet:
        frame = frame_in(scene)._replace(zoom=zoom)
        kept, decoded, preparation, skipped = _decoded(folder, names, frame, rendered is not None)
        known = [(rows or {}).get(name, Row(name, name, None, None)) for name in kept]
        return image_set(known, [picture.codes for picture in decoded], scene, skipped, preparation)

    if zoom is None:
        return load(*through_lens_of(own, scene)) if own else load(scene, 1.0)
    if zoom:
        return load(zoomed(scene, zoom), zoom)
    images = load(zoomed(scene, 1.0), 1.0)
    zoom = largest_zoom(images.pictures)
    return images if zoom == 1 else load(zoomed(scene, zoom), zoom)


def frame_in(scene: SceneConfig) -> Frame:
    """Where objects stand in the pictures of a scene."""
    camera = scene.camera
    return frame_of(scene.width, scene.height, camera.distance, camera.field_of_view_degrees, scene.zoom)


def image_set(
    known: Sequence[Row],
    pictures: Sequence[UInt8[ndarray, "3 H W"]],
    scene: SceneConfig,
    skipped: tuple[str, ...],
    preparation: Preparation,
) -> ImageSet:
    """Pictures, and a row for each of them, in the same order."""
    instance_names, instances = np.unique([row.instance for row in known], return_inverse=True)
    return ImageSet(
        pictures=np.stack(pictures),
        names=tuple(row.file_name for row in known),
        instances=instances.astype(np.int64),
        instance_names=tuple(map(str, instance_names)),
        azimuths=_radians([row.azimuth_degrees for row in known]),
        light_azimuths=_radians([row.light_azimuth_degrees for row in known]),
        scene=scene,
        skipped=skipped,
        preparation=preparation,
    )


def _decoded(
    folder: Path, names: list[str], frame: Frame, framed: bool
) -> tuple[tuple[str, ...], list[Decoded], Preparation, tuple[str, ...]]:
    """The names of pictures that can be used, the pictures, how they were prepared, and what cannot be read."""
    with decoders() as pool:
        found = list(pool.map(lambda name: decode_picture(folder / name, frame, framed), names))
    unusable = [result for result in found if isinstance(result, Unusable)]
    kept = [(name, result) for name, result in zip(names, found, strict=True) if isinstance(result, Decoded)]
    refused = tuple(result.sentence for result in unusable if result.refused)
    skipped = tuple(result.sentence for result in unusable if not result.refused)
    if not kept:
        raise DataError(
            f"none of the {len(names)} pictures in {folder} can be used; first: {unusable[0].sentence}; "
            "expected pictures of one object each, before a plain or transparent background"
        )
    if skipped:
        logger.warning("skipped %d of %d pictures that cannot be read; first: %s", len(skipped), len(names), skipped[0])
    if refused:
        logger.warning(
            "refused %d of %d pictures whose object cannot be told from its background; first: %s",
            len(refused), len(names), refused[0],
        )  # fmt: skip
    methods = Counter(result.method for _, result in kept)
    preparation = Preparation(methods["framed"], methods["alpha"], methods["background"], refused)
    return tuple(name for name, _ in kept), [result for _, result in kept], preparation, skipped


def fitted(scene: SceneConfig, width: int, height: int) -> SceneConfig:
    """The scene of pictures that were scaled to fit `width` × `height` and padded with black."""
    scale = min(width / scene.width, height / scene.height)
    half = math.radians(scene.camera.field_of_view_degrees) / 2
    widened = math.atan(math.tan(half) * height / (scene.height * scale))
    field_of_view = scene.camera.field_of_view_degrees if widened <= half * (1 + 1e-9) else math.degrees(2 * widened)
    camera = dataclasses.replace(scene.camera, field_of_view_degrees=field_of_view)
    return dataclasses.replace(scene, width=width, height=height, camera=camera)


def _picture_names(folder: Path) -> list[str]:
    if not folder.is_dir():
        found = "a file" if folder.exists() else "nothing"
        raise DataError(f"expected a folder of pictures at {folder}, found {found}; check the path, or render one")
    names = sorted(
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.suffix.lower() in FORMATS and not path.name.startswith(".") and path.is_file()
    )
    if not names:
        raise DataError(f"expected pictures ({', '.join(FORMATS)}) in {folder} or below it, found none; add some")
    return names


def _named_in_both(folder: Path, names: list[str], rows: dict[str, Row]) -> list[str]:
    """The pictures that metadata.csv names; warns of pictures without a row and of rows without a picture."""
    there = set(names)
    absent, unnamed = [name for name in rows if name not in there], [name for name in names if name not in rows]
    path = folder / METADATA_FILE
    if len(unnamed) == len(names):
        raise DataError(
            f"{path} names none of the {len(names)} pictures in the folder: expected file_name relative to the folder, "
            f"such as {names[0]}, found {next(iter(rows), 'no row')}; correct the file or delete it"
        )
    if absent:
        logger.warning("%s names %d pictures that are not there; first: %s", path, len(absent), absent[0])
    if unnamed:
        logger.warning("skipped %d pictures that %s does not name; first: %s", len(unnamed), path, unnamed[0])
    return [name for name in names if name in rows]


def _radians(degrees: list[float | None]) -> Float[ndarray, "N"] | None:
    known = [value for value in degrees if value is not None]
    if len(known) < len(degrees):
        return None
    return np.array([math.remainder(math.radians(value), 2 * math.pi) for value in known])


@kernel()
def _look_up(codes, chosen, table, linear):
    for row in range(len(chosen)):
        source, target = codes[chosen[row]], linear[row]
        for position in range(len(source)):
            target[position] = table[source[position]]
