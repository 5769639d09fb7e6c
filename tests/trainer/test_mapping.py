"""Settings survive JSON and TOML, and what does not fit is refused by name."""

import dataclasses
import json
import math
import tomllib
from dataclasses import dataclass, field
from typing import Any, Literal

import pytest

from trainer.config import CameraConfig, DirectionalLight, SceneConfig, TrainConfig
from trainer.errors import ConfigError
from trainer.mapping import from_mapping, to_mapping


@dataclass(frozen=True)
class Inner:
    share: float = 0.5
    kind: Literal["round", "square"] = "round"


@dataclass(frozen=True)
class Outer:
    name: str
    count: int = 3
    on: bool = False
    limit: float | None = None
    pair: tuple[int, float] = (1, 2.0)
    many: tuple[Inner, ...] = ()
    inner: Inner = field(default_factory=Inner)


FULL = Outer("a", 7, True, 0.25, (4, 0.5), (Inner(0.1), Inner(0.2, "square")), Inner(1.5))


@pytest.mark.parametrize("settings", [Outer("b"), FULL])
def test_settings_survive_json(settings: Outer) -> None:
    assert from_mapping(Outer, json.loads(json.dumps(to_mapping(settings))), "here") == settings


def test_the_project_s_own_settings_survive_json() -> None:
    scene = SceneConfig(33, 44, CameraConfig(-5.0, 3.5, 12.25), (DirectionalLight(1.0, 2.0, (0.1, 0.2, 0.3)),))
    assert from_mapping(SceneConfig, json.loads(json.dumps(to_mapping(scene))), "here") == scene
    assert from_mapping(TrainConfig, json.loads(json.dumps(to_mapping(TrainConfig()))), "here") == TrainConfig()


def test_absent_keys_keep_those_of_the_default_and_else_their_own() -> None:
    assert from_mapping(Outer, {"name": "a", "inner": {"share": 2}}, "here") == Outer("a", inner=Inner(2.0))
    changed = from_mapping(Outer, tomllib.loads("count = 9\n[inner]\nkind = 'square'"), "here", FULL)
    assert changed == dataclasses.replace(FULL, count=9, inner=Inner(1.5, "square"))


def test_numbers_are_taken_as_they_are_meant() -> None:
    taken = from_mapping(Outer, {"name": "a", "count": 4.0, "pair": [2.0, 3], "limit": 1}, "here")
    assert taken == Outer("a", 4, pair=(2, 3.0), limit=1.0)
    assert [type(value) for value in (taken.count, taken.limit, *taken.pair)] == [int, float, int, float]
    assert from_mapping(Outer, {"name": "a", "limit": None}, "here", FULL).limit is None


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ([], "here: expected a table of settings, found []"),
        ({"cuont": 3}, "here: there is no setting 'cuont'; did you mean 'count'?"),
        ({"name": "a", "inner": {"shape": 1}}, "here: inner: there is no setting 'shape'; did you mean 'share'?"),
        ({"count": 1}, "here: the setting 'name' is missing."),
        ({"name": 3}, "here: name: expected a text, found 3"),
        ({"name": "a", "count": 3.5}, "here: count: expected a whole number, found 3.5"),
        ({"name": "a", "count": True}, "here: count: expected a whole number, found True"),
        ({"name": "a", "count": "3"}, "here: count: expected a whole number, found '3'"),
        ({"name": "a", "count": math.inf}, "here: count: expected a whole number, found inf"),
        ({"name": "a", "on": 1}, "here: on: expected true or false, found 1"),
        ({"name": "a", "limit": math.nan}, "here: limit: expected a finite number, found nan"),
        ({"name": "a", "limit": 10**400}, "here: limit: expected a finite number, found 1000"),
        ({"name": "a", "inner": {"share": math.inf}}, "here: inner: share: expected a finite number, found inf"),
        (
            {"name": "a", "inner": {"kind": "oval"}},
            "here: inner: kind: expected one of 'round', 'square', found 'oval'",
        ),
        ({"name": "a", "inner": 4}, "here: inner: expected a table of settings, found 4"),
        ({"name": "a", "pair": [1]}, "here: pair: expected a list of 2 values, found [1]"),
        ({"name": "a", "pair": [1, "x"]}, "here: pair[1]: expected a finite number, found 'x'"),
        ({"name": "a", "many": [{}, {"share": []}]}, "here: many[1]: share: expected a finite number, found []"),
    ],
)
def test_what_does_not_fit_is_named(mapping: Any, message: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        from_mapping(Outer, mapping, "here")
    assert str(refusal.value).startswith(message)
