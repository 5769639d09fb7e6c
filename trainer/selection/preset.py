"""The chosen setting as a TOML file that `trainer train --preset` takes."""

import json
from collections.abc import Mapping
from typing import Any

from trainer.config import TrainConfig
from trainer.mapping import to_mapping


def as_toml(config: TrainConfig, comment: str) -> str:
    """What differs from the defaults of `trainer.config`, under a line of comment; `load_preset` reads it again."""
    return "\n".join([f"# {comment}", *_lines(to_mapping(config), to_mapping(TrainConfig()), "")]) + "\n"


def _lines(settings: Mapping[str, Any], usual: Mapping[str, Any], table: str) -> list[str]:
    differing = {name: value for name, value in settings.items() if value != usual[name]}
    own = {name: value for name, value in differing.items() if not isinstance(value, dict)}
    # Numbers, lists of them, and words between quotes look in TOML as they do in JSON.
    lines = [f"{name} = {json.dumps(value)}" for name, value in own.items()]
    if table and lines:
        lines = ["", f"[{table}]", *lines]
    for name, value in differing.items():
        if isinstance(value, dict):
            lines += _lines(value, usual[name], f"{table}.{name}" if table else name)
    return lines
