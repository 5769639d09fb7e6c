"""Pictures whose truth is known, from a folder that `trainer render` wrote or rendered here from mesh files."""

import logging
import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
import torch
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray
from torch import Tensor

from imaging.srgb import decode_table, encode
from trainer.config import SceneConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.normals import corner_normals
from trainer.data.picture import draw
from trainer.data.plan import load_instance, read_settings
from trainer.data.shapes.solid import Mesh
from trainer.errors import DataError
from trainer.evaluation.fill import fill
from trainer.evaluation.surface import Surface, visible_surface
from trainer.evaluation.symmetry import REFERENCE_POINTS, rotational_order
from trainer.evaluation.voxels import Solid

_BATCH = 256

Voxels = Bool[ndarray, "32 32 32"]

logger = logging.getLogger(__name__)


class Truth(NamedTuple):
    """What is known of an object, in the class's frame."""

    voxels: Voxels
    surface: Surface
    order: float
    """Of its rotational symmetry about +Y: 1 for none, infinity for a solid of revolution."""


@dataclass(frozen=True)
class Pictures:
    """Test pictures with their truth."""

    codes: UInt8[ndarray, "N 3 H W"]
    """sRGB, as picture files hold it."""
    azimuths: Float[ndarray, "N"]
    """True azimuths, radians."""
    light_azimuths: Float[ndarray, "N"] | None
    """How far the lights are turned, radians; None where they stand still, or nobody knows."""
    objects: Int[ndarray, "N"]
    """Which object each picture shows."""
    truth: tuple[Truth, ...]
    skipped: tuple[str, ...]
    """A sentence for each mesh that could not be read."""
    views: int = 1
    """How many consecutive pictures, all of one object, are shown to the model together."""


@dataclass(frozen=True)
class Validation:
    """Pictures of other objects of the class: what may be fitted is fitted on them, and the baselines know them."""

    codes: UInt8[ndarray, "N 3 H W"]
    azimuths: Float[ndarray, "N"]
    objects: Int[ndarray, "N"]
    voxels: Bool[ndarray, "K 32 32 32"] | None
    """The occupancy of each object; None where the folder does not say what it shows."""


def linear_batches(codes: UInt8[ndarray, "N 3 H W"], views: int = 1) -> Iterator[Float[Tensor, "B 3 H W"]]:
    """The pictures in linear light, 0..1, as many at once as a network or a renderer gets; each `views` consecutive
    ones stay together."""
    table, size = decode_table(), _BATCH // views * views
    for start in range(0, len(codes), size):
        yield torch.from_numpy(table[codes[start : start + size]])


def threads() -> int:
    """One for each core that this process may use."""
    return len(os.sched_getaffinity(0))


def from_folder(folder: Path, scene: SceneConfig) -> Pictures:
    """Test pictures from a folder that `trainer render` wrote.

    Raises DataError where there is no such folder, or it does not say what its pictures show.
    """
    images = load_as_seen(folder, scene)
    azimuths, lights = _azimuths(folder, images), images.light_azimuths
    varying = lights is not None and np.ptp(lights) > 0
    truth = _look_at_objects(folder, images, truth_of)
    return Pictures(images.pictures, azimuths, lights if varying else None, images.instances, tuple(truth), ())


def from_meshes(folder: Path, scene: SceneConfig, views: int) -> Pictures:
    """Test pictures of mesh files (front = +z, up = +y), `views` of each at evenly spaced azimuths.

    Files that cannot be read are named in a warning each, and skipped. Raises DataError where none can be.
    """
    azimuths = -math.pi + (np.arange(views) + 0.5) * 2 * math.pi / views
    files = mesh_files(folder)
    with ThreadPoolExecutor(threads()) as pool:
        found = list(pool.map(lambda path: _photographed(path, scene, azimuths), files))
    skipped = tuple(result for result in found if isinstance(result, str))
    for sentence in skipped:
        logger.warning("skipped: %s", sentence)
    shown = [result for result in found if not isinstance(result, str)]
    if not shown:
        raise DataError(f"none of the {len(files)} meshes in {folder} can be read; first: {skipped[0]}")
    codes, truth = zip(*shown, strict=True)
    objects = np.repeat(np.arange(len(shown)), views)
    return Pictures(np.concatenate(codes), np.tile(azimuths, len(shown)), None, objects, truth, skipped)


def _photographed(
    path: Path, scene: SceneConfig, azimuths: Float[ndarray, "N"]
) -> tuple[UInt8[ndarray, "N 3 H W"], Truth] | str:
    """Pictures of a mesh file with its truth, or a sentence on why it cannot be read."""
    try:
        mesh = load_mesh(path)
    except DataError as error:
        return str(error)
    normals = corner_normals(mesh)
    pictures = [encode(draw(mesh, float(azimuth), 0.0, scene, normals=normals)[0]) for azimuth in azimuths]
    return np.stack(pictures).transpose(0, 3, 1, 2), truth_of(mesh, fill(mesh.vertices, mesh.faces))


def grouped(pictures: Pictures, views: int) -> Pictures:
    """The same pictures, to be shown to the model `views` at once: those of a group are spread over all that there are
    of their object.

    Raises DataError where an object has a number of pictures that is no multiple of `views`.
    """
    counts = np.bincount(pictures.objects)
    others = counts[counts % views > 0]
    if len(others):
        raise DataError(
            f"expected a multiple of {views} pictures of each object, as --views-per-instance says, found {others[0]} "
            f"of one, and other numbers for {len(others)} objects of {len(counts)}; render as many views, or see which "
            "pictures cannot be read"
        )
    own = (np.flatnonzero(pictures.objects == index) for index in range(len(counts)))
    chosen = np.concatenate([numbers.reshape(views, -1).T.reshape(-1) for numbers in own])
    lights = None if pictures.light_azimuths is None else pictures.light_azimuths[chosen]
    return replace(
        pictures,
        codes=pictures.codes[chosen],
        azimuths=pictures.azimuths[chosen],
        light_azimuths=lights,
        objects=pictures.objects[chosen],
        views=views,
    )


def validation_from(folder: Path, scene: SceneConfig) -> Validation:
    """Validation pictures from a folder; its objects' shapes too, where `trainer render` wrote it.

    Raises DataError where there is no such folder, or no azimuths are known.
    """
    images = load_as_seen(folder, scene)
    azimuths = _azimuths(folder, images)
    known = read_settings(folder) is not None
    voxels = np.stack(_look_at_objects(folder, images, lambda _, solid: solid.full)) if known else None
    return Validation(images.pictures, azimuths, images.instances, voxels)


def truth_of(mesh: Mesh, solid: Solid) -> Truth:
    """What is known of a mesh that fills `solid`."""
    surface = visible_surface(mesh.vertices, mesh.faces, solid.air)
    dense = visible_surface(mesh.vertices, mesh.faces, solid.air, REFERENCE_POINTS)
    return Truth(solid.full, surface, rotational_order(dense))


def load_as_seen(folder: Path, scene: SceneConfig) -> ImageSet:
    """The pictures of a folder for a model that expects `scene`; a warning says where they show another."""
    images = load_image_folder(folder, scene.width, scene.height, scene)
    if images.scene != scene:
        logger.warning(
            "%s was rendered with another camera or other lights than the model was trained for: the figures tell of "
            "both",
            folder,
        )
    return images


def _azimuths(folder: Path, images: ImageSet) -> Float[ndarray, "N"]:
    if images.azimuths is None:
        raise DataError(f"{folder} has no azimuths in metadata.csv. Expected a folder that `trainer render` wrote.")
    return images.azimuths


Seen = TypeVar("Seen")


def _look_at_objects(folder: Path, images: ImageSet, look: Callable[[Mesh, Solid], Seen]) -> list[Seen]:
    """What `look` sees of each object of a rendered folder, made or read again from what render.json says."""
    settings = read_settings(folder)
    if settings is None:
        raise DataError(
            f"{folder} has no render.json, so its shapes are not known. Expected a folder that `trainer render` wrote."
        )

    def look_at(name: str) -> Seen:
        mesh = load_instance(settings, name)
        return look(mesh, fill(mesh.vertices, mesh.faces))

    with ThreadPoolExecutor(threads()) as pool:
        return list(pool.map(look_at, images.instance_names))
