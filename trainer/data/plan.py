"""What a rendering will draw: its settings, the objects, and the pose of every picture, all known beforehand."""

import dataclasses
import json
import logging
import os
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from trainer.config import SceneConfig
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.metadata import Row
from trainer.data.scene import SCENE_FILE, read_scene, write_scene
from trainer.data.shapenet import SYNSETS, Split, load_model, model_names
from trainer.data.shapes.catalogue import CATEGORIES, make_shape
from trainer.data.shapes.solid import Mesh
from trainer.data.stretching import stretched
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError, DataError
from trainer.mapping import from_mapping, to_mapping

SETTINGS_FILE = "render.json"
_SEED_STRIDE = 1_000_000

logger = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class RenderSettings:
    """What determines the pictures, beside the scene."""

    source: str
    """A procedural class, or the path of a folder: of meshes, or of ShapeNetCore."""
    seed: int = 0
    """Names the shapes (procedural) and the poses; 0 or more."""
    rotate_lights: bool = False
    """Whether the lights are turned by a uniform angle in [0°, 180°) in each picture."""
    supersampling: int = 4
    """Samples along each side of a pixel."""
    synset: str = ""
    """ShapeNetCore's folder of the class, such as 02958343; empty for every other source."""
    split: Split = "all"
    """Which part of ShapeNetCore's class."""
    renderer: Literal["chiaro", "pyrender"] = "chiaro"
    """Who draws: ours, or OpenGL as an outside opinion."""
    shard_pictures: int = 0
    """Pictures in each tar file of `data.shards`; 0 means a file for each picture."""
    stretch: float = 0.0
    """Deviation of the logarithms by which half of the objects are stretched along their axes (`data.stretching`)."""


class Job(NamedTuple):
    """All pictures of one object."""

    instance: str
    rows: tuple[Row, ...]


def plan_jobs(settings: RenderSettings, instances: int | None, views: int) -> list[Job]:
    """All that there is to draw.

    Raises ConfigError for settings that mean nothing, DataError where two objects' pictures would have one name.
    """
    if settings.seed < 0 or settings.supersampling < 1 or views < 1 or (instances is not None and instances < 1):
        raise ConfigError(
            "expected a seed of 0 or more and at least one instance, view and sample, found "
            f"seed {settings.seed}, instances {instances}, views {views}, supersampling {settings.supersampling}"
        )
    jobs = [Job(name, tuple(poses(settings, name, views))) for name in instance_names(settings, instances)]
    claimed: dict[str, str] = {}
    for job in jobs:
        other = claimed.setdefault(job.rows[0].file_name, job.instance)
        if other != job.instance:
            raise DataError(
                f"{settings.source}: expected meshes whose pictures get names of their own, found {other} and "
                f"{job.instance}, both of which make {job.rows[0].file_name}; rename one of them"
            )
    return jobs


def instance_names(settings: RenderSettings, instances: int | None) -> list[str]:
    """The objects of a source, each by the name that `load_instance` takes; None means all that there are.

    Raises ConfigError for a class that does not exist, or too few or too many objects of it, DataError for a folder
    without any.
    """
    root = Path(settings.source)
    if settings.synset:
        return model_names(root, settings.synset, settings.split)[:instances]
    if not is_procedural(settings):
        names = [path.relative_to(root).as_posix() for path in mesh_files(root)]
        if names[0].endswith("models/model_normalized.obj"):
            logger.warning("%s looks like ShapeNetCore, whose front is -z: with --shapenet it would be turned", root)
        return names[:instances]
    if instances is None or not 1 <= instances <= _SEED_STRIDE:
        raise ConfigError(f"expected 1 to {_SEED_STRIDE:,} instances of a procedural class, found {instances}")
    make_shape(settings.source, settings.seed)
    return [f"{settings.source}-{shape_seed(settings.seed, index):07d}" for index in range(instances)]


def poses(settings: RenderSettings, instance: str, views: int) -> Iterator[Row]:
    """How an object is shown in each of its pictures: uniformly at random, and the same on every call."""
    stem = f"{category_of(settings)}/{instance.replace('/', '__')}"
    for view in range(views):
        rng = np.random.default_rng([settings.seed, zlib.crc32(instance.encode()), view])
        # Rounded before use, so that the file holds exactly what was drawn.
        azimuth, light = round(rng.uniform(-180.0, 180.0), 4), round(rng.uniform(0.0, 180.0), 4)
        yield Row(f"{stem}-{view:02d}.png", instance, azimuth, light if settings.rotate_lights else 0.0)


def shape_seed(seed: int, index: int) -> int:
    """The seed of `make_shape` for object `index` of a run with `seed`; the instance's name ends in it."""
    return seed * _SEED_STRIDE + index


def load_instance(settings: RenderSettings, instance: str) -> Mesh:
    """The mesh that an `instance` of metadata.csv names. Raises DataError where there is none."""
    return stretched(_as_made(settings, instance), instance, settings.seed, settings.stretch)


def _as_made(settings: RenderSettings, instance: str) -> Mesh:
    if settings.synset:
        return load_model(Path(settings.source), settings.synset, instance)
    if not is_procedural(settings):
        return load_mesh(Path(settings.source) / instance)
    category, _, seed = instance.rpartition("-")
    if not (category and seed.isdigit()):
        raise DataError(f"expected an instance such as car-0000017, found {instance!r}")
    return make_shape(category, int(seed))


def category_of(settings: RenderSettings) -> str:
    """What the pictures show, as their folder is called."""
    if settings.synset:
        return next(category for category, synset in SYNSETS.items() if synset == settings.synset)
    return settings.source if is_procedural(settings) else Path(settings.source).resolve().name or "meshes"


def is_procedural(settings: RenderSettings) -> bool:
    """Whether the objects are made from seeds: a class has its name; anything else is the path of a folder."""
    return settings.source in CATEGORIES or not (os.sep in settings.source or Path(settings.source).is_dir())


def claim(out: Path, settings: RenderSettings, scene: SceneConfig) -> None:
    """Makes `out` a folder of these settings, or refuses it."""
    if out.exists() and not out.is_dir():
        raise DataError(f"expected a folder to render into at {out}, found a file; choose another name")
    found: list[tuple[object, object, str]] = [
        (read_settings(out), settings, SETTINGS_FILE),
        (read_scene(out), scene, SCENE_FILE),
    ]
    for there, wanted, file in found:
        if there is not None and there != wanted:
            raise DataError(
                f"{out / file} holds other settings than this run's: {_differences(wanted, there)}; "
                "render into another folder, or delete this one"
            )
    write_scene(out, scene)
    write_bytes(out / SETTINGS_FILE, (json.dumps(to_mapping(settings), indent=2) + "\n").encode())


def _differences(wanted: object, there: object) -> str:
    expected, found = to_mapping(wanted), to_mapping(there)
    return "; ".join(
        f"{key}: expected {expected[key]}, found {found[key]}" for key in expected if expected[key] != found[key]
    )


def read_settings(folder: Path) -> RenderSettings | None:
    """The settings that a folder was rendered with, or None where it was not rendered here."""
    path = folder / SETTINGS_FILE
    if not path.exists():
        return None
    try:
        return from_mapping(RenderSettings, json.loads(path.read_text(encoding="utf-8")), "the settings")
    except (OSError, ValueError, ConfigError) as error:
        raise DataError(
            f"{path}: expected the settings of a rendering, found {error}; render into a new folder"
        ) from error
