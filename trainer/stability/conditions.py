"""The conditions under which models are looked at, each in degrees of severity."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray
from numpy.random import Generator

from trainer.config import SceneConfig
from trainer.stability import damages, scenes
from trainer.stability.damages import Damage
from trainer.stability.objects import Exhibit, photographs
from trainer.stability.scenes import Change


class Sitting(NamedTuple):
    """Objects as the model expects to see them."""

    shown: tuple[Exhibit, ...]
    scene: SceneConfig
    codes: UInt8[ndarray, "N 3 H W"]
    """A picture of each."""


@dataclass(frozen=True)
class Condition:
    """One way in which pictures differ from those that a model was made for."""

    name: str
    title: str
    unit: str
    """What severities are measured in."""
    severities: tuple[float, ...]
    """From untouched pictures, which the first stands for, to hardly any that could be recognised."""
    alter: Callable[[Sitting, float, Generator], UInt8[ndarray, "N 3 H W"]]
    """What becomes of the pictures."""


def pictures_under(condition: Condition, sitting: Sitting, severity: float, seed: int) -> UInt8[ndarray, "N 3 H W"]:
    """The pictures of a sitting at a severity: the same on every call, and untouched at the first."""
    if severity == condition.severities[0]:
        return sitting.codes
    return condition.alter(sitting, severity, np.random.default_rng([seed, zlib.crc32(condition.name.encode())]))


def _damaged(damage: Damage) -> Callable[[Sitting, float, Generator], UInt8[ndarray, "N 3 H W"]]:
    return lambda sitting, severity, rng: damage(sitting.codes, severity, rng)


def _seen_again(change: Change) -> Callable[[Sitting, float, Generator], UInt8[ndarray, "N 3 H W"]]:
    def again(sitting: Sitting, severity: float, rng: Generator) -> UInt8[ndarray, "N 3 H W"]:
        scene, light_azimuth = change(sitting.scene, severity)
        return photographs(sitting.shown, scene, light_azimuth=light_azimuth)

    return again


_HEIGHT, _BOX = "parts of the picture's height", "part of the object's box"
DAMAGES = (
    Condition("noise", "noise", "deviation, sRGB codes", (0, 8, 16, 32, 64, 128), _damaged(damages.noise)),
    Condition("blur", "blur", f"deviation, {_HEIGHT}", (0, 0.01, 0.02, 0.04, 0.08, 0.16), _damaged(damages.blur)),
    Condition("jpeg", "JPEG", "quality (100: untouched)", (100, 90, 50, 20, 8, 2), _damaged(damages.jpeg)),
    Condition("cut", "cut off at a side", _BOX, (0, 0.1, 0.2, 0.3, 0.45, 0.6), _damaged(damages.cut)),
    Condition("occlusion", "hidden by a grey bar", _BOX, (0, 0.1, 0.2, 0.3, 0.45, 0.6), _damaged(damages.occlusion)),
    Condition("shift", "shifted", _HEIGHT, (0, 0.03, 0.06, 0.12, 0.2, 0.35), _damaged(damages.shift)),
    Condition("smaller", "smaller", "times as large", (1, 0.9, 0.8, 0.65, 0.5, 0.35), _damaged(damages.scale)),
    Condition("larger", "larger", "times as large", (1, 1.1, 1.25, 1.5, 1.8, 2.2), _damaged(damages.scale)),
    Condition("darker", "darker", "times the light", (1, 0.8, 0.6, 0.4, 0.2, 0.1), _damaged(damages.brightness)),
    Condition("brighter", "brighter", "times the light", (1, 1.25, 1.6, 2.5, 4, 8), _damaged(damages.brightness)),
    Condition(
        "white-balance", "white balance", "times red, and less blue", (1, 1.1, 1.25, 1.5, 2, 3),
        _damaged(damages.white_balance),
    ),
)  # fmt: skip
"""What befalls a picture."""
_OF_WIDTH, _GREY = "times the field of view", "part that is grey"
SCENES = (
    Condition("camera-lower", "camera lower", "degrees", (0, -5, -10, -20, -30, -45), _seen_again(scenes.raised)),
    Condition("camera-higher", "camera higher", "degrees", (0, 5, 10, 20, 35, 50), _seen_again(scenes.raised)),
    Condition("nearer", "wider lens, nearer", _OF_WIDTH, (1, 1.25, 1.6, 2, 2.5, 3), _seen_again(scenes.lens)),
    Condition("farther", "longer lens, farther", _OF_WIDTH, (1, 0.8, 0.6, 0.4, 0.2, 0.1), _seen_again(scenes.lens)),
    Condition("lights-turned", "lights turned", "degrees", (0, 5, 15, 30, 60, 90), _seen_again(scenes.lights_turned)),
    Condition("lights-higher", "lights higher", "degrees", (0, 5, 10, 20, 35, 50), _seen_again(scenes.lights_raised)),
    Condition("lights-whiter", "lights whiter", _GREY, (0, 0.1, 0.25, 0.5, 0.75, 1), _seen_again(scenes.lights_whiter)),
)
"""The same objects by another camera or in other light."""
CONDITIONS = DAMAGES + SCENES
