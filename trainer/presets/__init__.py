"""Named settings: one TOML file each, with what differs from the defaults of `trainer.config`."""

import difflib
import tomllib
from importlib import resources
from pathlib import Path

from trainer.config import TrainConfig
from trainer.errors import ConfigError
from trainer.mapping import from_mapping


def preset_names() -> list[str]:
    return sorted(
        file.name.removesuffix(".toml") for file in resources.files(__name__).iterdir() if file.name.endswith(".toml")
    )


def load_preset(name: str) -> TrainConfig:
    """A preset by its name, or a TOML file of one's own by its path.

    Raises:
        ConfigError: no such preset or file, not TOML, or a setting that does not exist.
    """
    if name.endswith(".toml"):
        try:
            text = Path(name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"The settings file {name} cannot be read ({error}). Check the path.") from error
    elif name in preset_names():
        text = resources.files(__name__).joinpath(f"{name}.toml").read_text()
    else:
        nearest = difflib.get_close_matches(name, preset_names(), n=1, cutoff=0.0)
        raise ConfigError(
            f"There is no preset '{name}'; did you mean '{nearest[0]}'? There are {', '.join(preset_names())}, and any "
            "file whose name ends in .toml."
        )
    try:
        return from_mapping(TrainConfig, tomllib.loads(text), name, TrainConfig())
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: expected a TOML file, found {error}. Mend it.") from error
