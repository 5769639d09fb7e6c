"""Named settings: one TOML file each, with what differs from the defaults of `trainer.config`; and the rows of the
paper's tables, `table-2/full-block`, which are the default preset in the row's setting."""

import difflib
import tomllib
from importlib import resources
from pathlib import Path

from trainer.config import TrainConfig
from trainer.data.shapes.catalogue import check_category
from trainer.errors import ConfigError
from trainer.mapping import from_mapping
from trainer.tables.setting import Setting, setting_for, training_config
from trainer.tables.table import load_table, table_names

DEFAULT = "sharp"
"""What trains where no preset is named, and what the tables change."""


def preset_names() -> list[str]:
    return sorted(
        file.name.removesuffix(".toml") for file in resources.files(__name__).iterdir() if file.name.endswith(".toml")
    )


def preset_setting(name: str) -> Setting:
    """The setting of a row of a table, by the name of `load_preset`; the usual one for every other preset."""
    table, _, row = name.partition("/")
    if not row or table not in table_names():
        return Setting()
    setting = load_table(table).row(row.split("/", 1)[0]).setting
    assert setting is not None
    return setting


def load_preset(name: str) -> TrainConfig:
    """A preset by its name, a row of a table as TABLE/ROW or TABLE/ROW/CLASS, or a TOML file of one's own by its path.

    Raises:
        ConfigError: no such preset, row or file, a row whose setting depends on a class that is not named, not TOML, or
            a setting that does not exist.
    """
    table, _, row = name.partition("/")
    if row and table in table_names():
        return _row(table, *row.split("/", 1))
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


def _row(table: str, name: str, category: str = "") -> TrainConfig:
    setting = preset_setting(f"{table}/{name}")
    if setting.parameterisation == "best" and not category:
        raise ConfigError(
            f"The row {table}/{name} takes the best parameterisation of each class. Expected a class behind it, such "
            f"as {table}/{name}/car, found none."
        )
    if category:
        check_category(category)
    return training_config(setting_for(setting, category), load_preset(DEFAULT))
