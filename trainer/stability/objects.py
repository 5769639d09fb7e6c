"""Procedural objects whose truth is known, photographed as `trainer render` does, by any camera in any light."""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray

from imaging.srgb import encode
from trainer.config import SceneConfig
from trainer.data.normals import corner_normals
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings, instance_names, load_instance, poses
from trainer.data.shapes.solid import Mesh
from trainer.evaluation.fill import fill
from trainer.evaluation.pictures import Pictures, Truth, threads, truth_of

VALIDATION_SEED, TEST_SEED = 1, 2
"""Of `trainer render`; the models that ship are judged on the same objects."""


class Exhibit(NamedTuple):
    """An object of which pictures can be taken."""

    mesh: Mesh
    normals: Float[ndarray, "F 3 3"]
    """Of its faces' corners."""
    azimuths: tuple[float, ...]
    """At which it is shown, one a picture, radians."""


def exhibits(category: str, seed: int, count: int, views: int = 1) -> list[Exhibit]:
    """The objects and poses of `trainer render --class … --seed … --instances … --views …`.

    Raises ConfigError for a class that does not exist.
    """
    settings = RenderSettings(category, seed=seed)
    found = []
    for name in instance_names(settings, count):
        mesh = load_instance(settings, name)
        azimuths = [math.radians(row.azimuth_degrees or 0.0) for row in poses(settings, name, views)]
        found.append(Exhibit(mesh, corner_normals(mesh), tuple(azimuths)))
    return found


def truths(shown: Sequence[Exhibit]) -> tuple[Truth, ...]:
    """What the judge knows of each object."""

    def look(exhibit: Exhibit) -> Truth:
        return truth_of(exhibit.mesh, fill(exhibit.mesh.vertices, exhibit.mesh.faces))

    with ThreadPoolExecutor(threads()) as pool:
        return tuple(pool.map(look, shown))


def photographs(
    shown: Sequence[Exhibit], scene: SceneConfig, views: int = 1, light_azimuth: float = 0.0
) -> UInt8[ndarray, "N 3 H W"]:
    """sRGB codes of the first `views` pictures of each object, an object's together; the lights are turned by
    `light_azimuth` radians."""
    pictures = [
        encode(draw(exhibit.mesh, azimuth, light_azimuth, scene, normals=exhibit.normals)[0])
        for exhibit in shown
        for azimuth in exhibit.azimuths[:views]
    ]
    return np.stack(pictures).transpose(0, 3, 1, 2)


def pictures_of(
    codes: UInt8[ndarray, "N 3 H W"], shown: Sequence[Exhibit], truth: tuple[Truth, ...], views: int = 1
) -> Pictures:
    """These photographs, or what became of them, as the judge takes test pictures."""
    azimuths = np.array([azimuth for exhibit in shown for azimuth in exhibit.azimuths[:views]])
    return Pictures(codes, azimuths, None, np.repeat(np.arange(len(shown)), views), truth, ())
