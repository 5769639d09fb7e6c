"""The paper's tables and figures as data: one TOML file each, with the settings of its rows and the paper's figures."""

import difflib
import tomllib
from dataclasses import dataclass
from importlib import resources
from typing import Any, Literal, NamedTuple

from trainer.errors import ConfigError
from trainer.mapping import from_mapping
from trainer.tables.setting import Setting

Figure = Literal["iou", "err", "acc", "iou_pose_given"]
"""The paper's *iou*, *err* (median, degrees) and *acc* (within 30°) of a model that is not told the poses, and
*iou | θ* of one that is."""


@dataclass(frozen=True)
class Row:
    """A line of a table."""

    name: str
    setting: Setting | None
    """None: somebody else's method, of which only the paper's figures are known."""
    test_views: int
    """Pictures of each object that a test reconstructs it from."""
    paper: dict[str, dict[Figure, float]]
    """The paper's figures, by class."""


class Reference(NamedTuple):
    """A row of a table, and one of its figures."""

    row: str
    figure: Figure


class PaperOrdering(NamedTuple):
    """Where the paper has the ordering from."""

    table: str
    better: Reference
    worse: Reference


@dataclass(frozen=True)
class Comparison:
    """Two rows, of which one should reconstruct shapes better."""

    better: str
    worse: str
    paper: PaperOrdering | None
    """None: a question of our own."""


@dataclass(frozen=True)
class Table:
    """A table or figure of the paper, or a choice of settings."""

    name: str
    title: str
    label: str
    """In the paper's LaTeX source; empty for a table of our own."""
    figures: tuple[Figure, ...]
    classes: tuple[str, ...]
    rows: tuple[Row, ...]
    comparisons: tuple[Comparison, ...]

    def row(self, name: str) -> Row:
        """Raises ConfigError for a row that does not exist, or is somebody else's."""
        ours = {row.name: row for row in self.rows if row.setting is not None}
        if name not in ours:
            raise ConfigError(f"There is no row '{name}' in {self.name}; there are {', '.join(ours)}.")
        return ours[name]


def table_names() -> list[str]:
    files = (file.name for file in resources.files(__name__.rpartition(".")[0]).iterdir())
    return sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml"))


def load_table(name: str) -> Table:
    """Raises ConfigError for a name that does not exist; the nearest is named."""
    if name not in table_names():
        nearest = difflib.get_close_matches(name, table_names(), n=1, cutoff=0.0)
        raise ConfigError(
            f"There is no table '{name}'; did you mean '{nearest[0]}'? There are {', '.join(table_names())}."
        )
    package = resources.files(__name__.rpartition(".")[0])
    content = tomllib.loads(package.joinpath(f"{name}.toml").read_text(encoding="utf-8"))
    figures = tuple(content["figures"])
    rows = tuple(_row(row, figures, name) for row in content["rows"])
    shown = (category for row in rows for category in row.paper)
    return Table(
        name,
        content["title"],
        content.get("label", ""),
        figures,
        tuple(content.get("classes", dict.fromkeys(shown))),
        rows,
        tuple(_comparison(comparison) for comparison in content.get("comparisons", ())),
    )


def _row(content: dict[str, Any], figures: tuple[Figure, ...], table: str) -> Row:
    setting = from_mapping(Setting, content["setting"], f"{table}, {content['name']}") if "setting" in content else None
    paper = {category: dict(zip(figures, values, strict=True)) for category, values in content.get("paper", {}).items()}
    return Row(content["name"], setting, content.get("test_views", 1), paper)


def _comparison(content: dict[str, Any]) -> Comparison:
    if "paper" not in content:
        return Comparison(content["better"], content["worse"], None)
    paper = content["paper"]
    ordering = PaperOrdering(paper["table"], Reference(*paper["better"]), Reference(*paper["worse"]))
    return Comparison(content["better"], content["worse"], ordering)
