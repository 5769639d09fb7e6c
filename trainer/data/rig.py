"""The lights of a scene by name, or from a TOML file of one's own.

ambient = [0.1, 0.1, 0.1]

[[lights]]
azimuth_degrees = 30.0
elevation_degrees = 35.0
colour = [1.0, 0.9, 0.8]
"""

import difflib
import tomllib
from dataclasses import dataclass
from pathlib import Path

from trainer.config import COLOUR_RIG, WHITE_AMBIENT, WHITE_RIG, Colour, DirectionalLight, SceneConfig
from trainer.data.scene import check_scene
from trainer.errors import ConfigError
from trainer.mapping import from_mapping


@dataclass(frozen=True)
class Rig:
    """What a rig file may say."""

    lights: tuple[DirectionalLight, ...] = ()
    """The directional lights."""
    ambient: Colour = (0.0, 0.0, 0.0)
    """Linear RGB of the light that comes from everywhere."""


def rig_names() -> list[str]:
    return sorted(_named())


def _named() -> dict[str, Rig]:
    return {"colour": Rig(COLOUR_RIG), "white": Rig(WHITE_RIG, WHITE_AMBIENT)}


def load_rig(name: str) -> Rig:
    """A rig by its name, or a TOML file by its path.

    Raises ConfigError: no such rig or file, not TOML, a key that does not exist (the nearest is named), a value out of
    range, or no light at all.
    """
    named = _named()
    if name in named:
        return named[name]
    if not name.endswith(".toml"):
        nearest = difflib.get_close_matches(name, named, n=1, cutoff=0.0)
        raise ConfigError(
            f"There is no rig '{name}'; did you mean '{nearest[0]}'? There are {', '.join(rig_names())}, and any file "
            "whose name ends in .toml."
        )
    try:
        rig = from_mapping(Rig, tomllib.loads(Path(name).read_text(encoding="utf-8")), name)
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"The rig {name} cannot be read ({error}). Check the path.") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: expected a TOML file, found {error}. Mend it.") from error
    try:
        check_scene(SceneConfig(lights=rig.lights, ambient=rig.ambient))
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error
    if not any(sum(colour) > 0 for colour in (rig.ambient, *(light.colour for light in rig.lights))):
        raise ConfigError(f"{name}: expected a light or an ambient colour above 0, found none. Add [[lights]].")
    return rig
