"""What a frontier measures: from one start, one factor at a time is changed; and named settings as they are."""

import tomllib
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any, Literal, NamedTuple

from trainer.config import TrainConfig
from trainer.errors import ConfigError
from trainer.mapping import from_mapping
from trainer.presets import load_preset
from trainer.tables.setting import Variant

BundlePrecision = Literal["float32", "float16", "int8"]
Expense = Literal["latency_ms", "training_minutes", "bundle_mb", "memory_mb"]

DEFAULT = "default"
"""The point that the others are compared with."""
BUDGETS = ("small", "full")


@dataclass(frozen=True)
class Scale:
    """On how much every point is measured."""

    preset: str
    """What points start from, where they do not name another preset."""
    instances: int
    """Objects to train on, one picture each."""
    test_instances: int
    """Objects to judge on, and as many others to align the canonical frame on."""
    test_views: int
    """Pictures of each of these."""
    width: int
    height: int
    """Size at which pictures are rendered, pixels; trainings reduce them to theirs."""
    steps: int = 0
    """Steps of trainings that start from that preset, where they do not set them themselves; 0 means the preset's."""


@dataclass(frozen=True)
class Factor:
    """What is varied."""

    name: str
    title: str
    default: str = ""
    """The default's label among the points of this factor; empty where it is none of them."""
    cost: Expense = "training_minutes"
    """What its points are charted against."""


@dataclass(frozen=True)
class Choice:
    """What becomes of a training, and of how many."""

    name: str
    """A file name; no two points share one."""
    label: str
    """What a chart writes beside the point."""
    preset: str = ""
    """What the training starts from; empty means the scale's preset."""
    bundle: BundlePrecision = "float32"
    """Number format of the exported weights."""
    refine: int = 0
    """Steps of refinement for each picture."""
    classes: tuple[str, ...] = ("car",)
    seeds: tuple[int, ...] = (0,)


class Point(NamedTuple):
    """A model of the chart, before it is measured."""

    factor: Factor
    choice: Choice
    variant: Variant
    """How it is trained. Points that differ in what comes afterwards alone share one."""


class Plan(NamedTuple):
    """All points, in the order in which they are trained."""

    scale: Scale
    points: tuple[Point, ...]

    def point(self, name: str) -> Point:
        return next(point for point in self.points if point.choice.name == name)


def load_plan(name: str) -> Plan:
    """The points of a budget, `small` or `full`, or those of a TOML file of the same form.

    Raises ConfigError for a file that cannot be read, a setting that does not exist, two points of one name, and
    points without a default.
    """
    if name in BUDGETS:
        text = resources.files(__name__.rpartition(".")[0]).joinpath(f"{name}.toml").read_text(encoding="utf-8")
    elif name.endswith(".toml"):
        try:
            text = Path(name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"The points {name} cannot be read ({error}). Check the path.") from error
    else:
        raise ConfigError(
            f"Expected a budget, {' or '.join(BUDGETS)}, or a file whose name ends in .toml, found '{name}'."
        )
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: expected a TOML file, found {error}. Mend it.") from error
    scale = from_mapping(Scale, content.get("scale", {}), f"{name}: scale")
    points = _points(scale, content.get("factors", []), name)
    _check(points, name)
    return Plan(scale, points)


def _points(scale: Scale, factors: list[dict[str, Any]], where: str) -> tuple[Point, ...]:
    points: list[Point] = []
    # A training has the name of the first point that is trained so.
    names: dict[TrainConfig, str] = {}
    for content in factors:
        factor = from_mapping(Factor, _without(content, "points"), f"{where}: factors")
        for mapping in content.get("points", []):
            choice = from_mapping(Choice, _without(mapping, "changes"), f"{where}: {factor.name}")
            config = load_preset(choice.preset or scale.preset)
            if scale.steps and not choice.preset:
                config = replace(config, optimiser=replace(config.optimiser, steps=scale.steps))
            config = from_mapping(TrainConfig, mapping.get("changes", {}), f"{where}: {choice.name}", config)
            points.append(Point(factor, choice, Variant(names.setdefault(config, choice.name), config)))
    return tuple(points)


def _without(mapping: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in mapping.items() if name != key}


def _check(points: tuple[Point, ...], where: str) -> None:
    names = [point.choice.name for point in points]
    doubled = [name for name in names if names.count(name) > 1]
    if doubled:
        raise ConfigError(f"{where}: expected points of different names, found {doubled[0]} twice. Rename one.")
    idle = [point.choice.name for point in points if not (point.choice.classes and point.choice.seeds)]
    if idle:
        raise ConfigError(f"{where}: expected a class and a seed at least of {idle[0]}, found none. Name them.")
    if names[:1] != [DEFAULT]:
        found = names[0] if names else "none"
        raise ConfigError(
            f"{where}: expected the first point to be called {DEFAULT}, since the others are compared with it, found "
            f"{found}. Put one there."
        )
