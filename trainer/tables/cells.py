"""What a table takes: a training for each class, setting and seed, and what of it is judged."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from trainer.tables.setting import Setting, Variant, setting_for
from trainer.tables.table import Figure, Row, Table


class Cell(NamedTuple):
    """One training."""

    category: str
    setting: Setting | Variant
    seed: int


class Entry(NamedTuple):
    """A line of the table for one class and seed, or for one of its figures that is another training's."""

    row: Row
    figures: tuple[Figure, ...]
    cell: Cell


class Task(NamedTuple):
    """A training, and how often it is judged: by so many pictures of each object together."""

    cell: Cell
    test_views: tuple[int, ...]


def entries_of(table: Table, classes: Sequence[str], seeds: Sequence[int]) -> list[Entry]:
    """All that is measured for a table, seed by seed, so that an interrupted one is whole for the first seeds."""
    entries = []
    for seed in seeds:
        for category in classes:
            for row in table.rows:
                if row.setting is None:
                    continue
                setting = setting_for(row.setting, category)
                untold = tuple(figure for figure in table.figures if figure != "iou_pose_given")
                if untold:
                    entries.append(Entry(row, untold, Cell(category, setting, seed)))
                if "iou_pose_given" in table.figures:
                    told = replace(setting, pose="azimuth")
                    entries.append(Entry(row, ("iou_pose_given",), Cell(category, told, seed)))
    return entries


def tasks_of(entries: Sequence[Entry]) -> list[Task]:
    """Each training once, whichever rows share it, in the entries' order."""
    views: dict[Cell, set[int]] = {}
    for entry in entries:
        views.setdefault(entry.cell, set()).add(entry.row.test_views)
    return [Task(cell, tuple(sorted(counts))) for cell, counts in views.items()]
