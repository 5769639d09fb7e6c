"""How much of its pictures a model looks at: margins that objects hardly reach need not be computed."""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray

from trainer.config import SceneConfig

MOST_ZOOM: Final = 8.0

_KEPT: Final = 0.998
"""Share of what objects cover that stays in the picture: a wing tip of a few may be lost."""
_BLACK: Final = 8
"""sRGB code that compression may make of black."""


def zoomed(scene: SceneConfig, zoom: float) -> SceneConfig:
    """The scene as a model sees it that looks at the middle 1 / `zoom` of picture files, at the same size."""
    if zoom == scene.zoom:
        return scene
    half = math.tan(math.radians(scene.camera.field_of_view_degrees) / 2) * scene.zoom / zoom
    camera = replace(scene.camera, field_of_view_degrees=math.degrees(2 * math.atan(half)))
    return replace(scene, camera=camera, zoom=zoom)


def through_lens_of(own: SceneConfig, scene: SceneConfig) -> tuple[SceneConfig, float]:
    """The scene as the lens of `own` shows it, and how many times pictures of the scene are enlarged for that.

    Where the cameras stand in different places, lenses cannot be compared: the pictures are zoomed into as `own` does.
    """
    if replace(scene.camera, field_of_view_degrees=own.camera.field_of_view_degrees) != own.camera:
        return zoomed(scene, own.zoom), own.zoom
    wide, near = (math.tan(math.radians(one.camera.field_of_view_degrees) / 2) for one in (scene, own))
    return replace(scene, camera=own.camera, zoom=own.zoom), wide / near


def largest_zoom(pictures: UInt8[ndarray, "N 3 H W"]) -> float:
    """How far into sRGB pictures on black one can zoom before objects lose more than a few pixels.

    At least 1, and 1 where there are none.
    """
    _, _, height, width = pictures.shape
    covered = (pictures.max(1) > _BLACK).sum(0).ravel()
    # How far from the middle each pixel ends, in half pictures.
    x, y = (np.abs(np.linspace(-1, 1, size + 1)) for size in (width, height))
    reach = np.maximum(np.maximum(x[:-1], x[1:]), np.maximum(y[:-1], y[1:])[:, None]).ravel()
    ends, ring = np.unique(reach.round(9), return_inverse=True)
    inside = np.bincount(ring, covered).cumsum()
    if not inside[-1]:
        return 1.0
    farthest = float(np.interp(_KEPT * inside[-1], inside, ends))
    # Two digits: rounding then makes no difference between machines.
    return min(MOST_ZOOM, max(1.0, math.floor(100 / farthest) / 100))
