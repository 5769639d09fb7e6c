"""Settings to and from plain mappings, as JSON and TOML hold them; what does not fit is refused by name."""

import dataclasses
import difflib
import sys
import types
import typing
from collections.abc import Mapping
from typing import Any, TypeVar

from trainer.errors import ConfigError

Settings = TypeVar("Settings")

_KINDS = {int: "a whole number", float: "a finite number", bool: "true or false", str: "a text"}


def to_mapping(settings: Any) -> dict[str, Any]:
    """The fields of a dataclass as JSON can hold them; tuples become lists."""
    return {field.name: _plain(getattr(settings, field.name)) for field in dataclasses.fields(settings)}


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return to_mapping(value)
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def from_mapping(
    kind: type[Settings], mapping: Mapping[str, Any], where: str, default: Settings | None = None
) -> Settings:
    """A dataclass from a mapping; fields that are absent keep those of `default`, else their own default.

    A whole number may be written as 3.0, and any number where a float is expected, as long as it is finite.

    Raises:
        ConfigError: an unknown key (the nearest valid one is named), a missing one, or a value of another type. `where`
            says in the message which file or option is meant.
    """
    if not isinstance(mapping, Mapping):
        raise ConfigError(f"{where}: expected a table of settings, found {mapping!r}.")
    hints = typing.get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(typing.cast(Any, kind))}
    values: dict[str, Any] = {}
    for key, value in mapping.items():
        if key not in fields:
            nearest = difflib.get_close_matches(key, fields, n=1, cutoff=0.0)
            raise ConfigError(f"{where}: there is no setting '{key}'; did you mean '{nearest[0]}'?")
        inherited = getattr(default, key) if default is not None else None
        values[key] = _typed(hints[key], value, f"{where}: {key}", inherited)
    missing = [
        name
        for name, field in fields.items()
        if name not in values
        and default is None
        and field.default is dataclasses.MISSING
        and field.default_factory is dataclasses.MISSING
    ]
    if missing:
        raise ConfigError(f"{where}: the setting '{missing[0]}' is missing.")
    if default is not None:
        return typing.cast(Settings, dataclasses.replace(typing.cast(Any, default), **values))
    return kind(**values)


def _typed(hint: Any, value: Any, where: str, inherited: Any) -> Any:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if dataclasses.is_dataclass(hint):
        return from_mapping(typing.cast(type[Any], hint), value, where, inherited)
    if origin is typing.Literal:
        if value not in arguments:
            raise ConfigError(f"{where}: expected one of {', '.join(map(repr, arguments))}, found {value!r}.")
        return value
    if origin is tuple:
        kinds = arguments[:1] * len(value) if isinstance(value, list) and arguments[-1] is Ellipsis else arguments
        if not isinstance(value, list) or len(value) != len(kinds):
            raise ConfigError(f"{where}: expected a list of {len(kinds)} values, found {value!r}.")
        items = enumerate(zip(kinds, value, strict=True))
        return tuple(_typed(inner, item, f"{where}[{index}]", None) for index, (inner, item) in items)
    if origin in (typing.Union, types.UnionType):
        inner = [argument for argument in arguments if argument is not type(None)]
        return None if value is None else _typed(inner[0], value, where, inherited)
    return _scalar(hint, value, where)


def _scalar(kind: type[Any], value: Any, where: str) -> Any:
    if kind not in (int, float):
        if isinstance(value, kind):
            return value
    elif isinstance(value, int | float) and not isinstance(value, bool):
        # Neither NaN nor infinity, nor a whole number beyond every float.
        finite = abs(value) <= sys.float_info.max
        if finite and (kind is float or value == int(value)):
            return kind(value)
    raise ConfigError(f"{where}: expected {_KINDS.get(kind, kind.__name__)}, found {value!r}.")
