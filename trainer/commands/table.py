"""`python -m trainer table`"""

import json
import math
import sys
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

import numba
import tyro
from rich.console import Console

from trainer.config import TrainConfig
from trainer.data.shapes.catalogue import check_category
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError, DataError
from trainer.presets import DEFAULT, load_preset
from trainer.selection.starts import check_starts
from trainer.tables.cells import Entry, Task, entries_of, tasks_of
from trainer.tables.page import as_json, as_markdown
from trainer.tables.pictures import missing_folders, render_missing
from trainer.tables.results import results_of
from trainer.tables.setting import setting_name
from trainer.tables.study import Study
from trainer.tables.table import Table, load_table, table_names
from trainer.tables.trial import check_identity
from trainer.tables.workers import run_side_by_side
from trainer.training.checks import check_settings

MOST_SEEDS = 100
ENLARGED = 2
"""How many times larger than a training's pictures those are that a recipe zooms into."""


@dataclass(frozen=True)
class TableCommand:
    """Train and judge what one of the paper's tables needs, and print our figures beside the paper's.

    Pictures are rendered, and models trained and judged, where that is not done yet: the same command goes on where it
    was interrupted. Writes NAME.md, NAME.json and every run into the output directory; tables there share their runs.
    """

    name: Annotated[str, tyro.conf.Positional]
    """Which table."""
    output: Path = Path("out/tables")
    """Directory to write to."""
    classes: tuple[str, ...] = ()
    """Classes of objects; by default those of the paper's table."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds of the trainings, a training each."""
    preset: str = DEFAULT
    """Recipe that every setting starts from: a preset, or a TOML file. paper-small has the paper's objective."""
    steps: int = 0
    """Steps of each training; 0 means the preset's."""
    budget: float = 0.0
    """Instead of --steps: minutes of training in all, shared out evenly to the table's trainings, done or not."""
    starts: int = 1
    """Trainings that are begun for each seed, as by `trainer train --starts`; no two seeds have one in common."""
    shapenet: Path | None = None
    """Folder of ShapeNetCore, instead of procedural classes."""
    instances: int = 0
    """Objects to train on; 0 means 4000 of a procedural class, or all of ShapeNet's."""
    test_instances: int = 100
    """Objects to judge on, and as many others to align the canonical frame on."""
    test_views: int = 6
    """Pictures of each of these objects, at random azimuths (paper: 24)."""
    workers: int = 0
    """Trainings at once, which share the cores; 0 means one per core."""
    dry_run: bool = False
    """Only say what would be done."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required)

    def run(self) -> None:
        table = load_table(self.name)
        self._check()
        classes = self.classes or table.classes
        for category in classes:
            check_category(category)
        if len(set(classes)) < len(classes):
            raise ConfigError(f"Expected --classes that differ, found {' '.join(classes)}. Name each once.")
        entries = entries_of(table, classes, self.seeds)
        tasks = tasks_of(entries)
        study = self._study(table, tasks)
        for task in tasks:
            check_settings(study.config(task.cell))
            check_identity(study, task.cell)
        missing = [task for task in tasks if not study.is_done(task)]
        folders = missing_folders(study, missing)
        if self.dry_run:
            print(_plan(study, tasks, [str(folder.path) for folder in folders]))
            return
        cores: int = numba.config.NUMBA_NUM_THREADS
        workers = self.workers or cores
        for folder in folders:
            render_missing(folder, workers)
        failures = self._run(table, study, entries, missing, min(workers, max(1, len(missing))), cores)
        print(self._write(table, study, entries, failures), end="")
        print(f"{'written':12}{self.output}: {table.name}.md, {table.name}.json, runs/", file=sys.stderr)
        if failures:
            raise DataError(f"{len(failures)} of {len(missing)} trainings failed; first: {failures[0]}")

    def _check(self) -> None:
        for option, value, low, high in (
            ("steps", self.steps, 0, 10**9),
            ("budget", self.budget, 0, 10**6),
            ("instances", self.instances, 0, 1_000_000),
            ("test-instances", self.test_instances, 2, 1_000_000),
            ("test-views", self.test_views, 1, 1000),
            ("workers", self.workers, 0, 1024),
        ):
            if not (math.isfinite(value) and low <= value <= high):
                raise ConfigError(f"Expected --{option} from {low} to {high}, found {value}.")
        check_starts(self.starts)
        if self.steps and self.budget:
            raise ConfigError("Expected either --steps or --budget, found both.")
        if self.starts > 1 and self.budget:
            # A choice is made after a share of the steps, and time does not tell beforehand how many these are.
            raise ConfigError("Expected either --starts or --budget, found both.")
        if not 1 <= len(self.seeds) <= MOST_SEEDS or len(set(self.seeds)) < len(self.seeds):
            raise ConfigError(f"Expected 1 to {MOST_SEEDS} different --seeds, found {self.seeds}.")

    def _study(self, table: Table, tasks: Sequence[Task]) -> Study:
        for views in {views for task in tasks for views in task.test_views}:
            if self.test_views % views:
                raise ConfigError(
                    f"Expected --test-views to be a multiple of {views}, found {self.test_views}: {self.name} judges "
                    f"{views} pictures of an object together."
                )
        recipe = self._recipe()
        # What a zoom enlarges has to be there.
        size = (ENLARGED * recipe.width, ENLARGED * recipe.height) if recipe.zoom != 1 else None
        return Study(
            root=self.output,
            recipe_name=Path(self.preset).stem,
            recipe=recipe,
            instances=self.instances or (4000 if self.shapenet is None else None),
            test_instances=self.test_instances,
            test_views=self.test_views,
            seconds=self.budget * 60 / len(tasks) if self.budget else None,
            shapenet=self.shapenet,
            picture_size=size,
            starts=self.starts,
        )

    def _recipe(self) -> TrainConfig:
        recipe = load_preset(self.preset)
        if self.steps:
            recipe = replace(recipe, optimiser=replace(recipe.optimiser, steps=self.steps))
        return recipe

    def _run(
        self, table: Table, study: Study, entries: Sequence[Entry], missing: Sequence[Task], workers: int, cores: int
    ) -> list[str]:
        """Runs what is missing, keeps the written table up to date, and returns a sentence for each failure."""
        console, failures = Console(stderr=True, soft_wrap=True), list[str]()
        if missing:
            console.print(f"{len(missing)} trainings, {workers} at once, {_goal(study)}")
        with closing(run_side_by_side(study, missing, workers, max(1, cores // workers))) as outcomes:
            for number, (task, problem) in enumerate(outcomes, 1):
                name = _name(task)
                console.print(f"[{number}/{len(missing)}] {name}: {_told(study, task, problem)}", markup=False)
                if problem is not None:
                    failures.append(f"{name}: {problem}")
                self._write(table, study, entries, failures)
        return failures

    def _write(self, table: Table, study: Study, entries: Sequence[Entry], failures: Sequence[str]) -> str:
        """Writes the table of what is there so far, and returns the page."""
        results, classes = results_of(study, entries), self.classes or table.classes
        page = as_markdown(table, study, classes, results, failures)
        figures = as_json(table, study, classes, results, failures)
        write_bytes(self.output / f"{table.name}.md", page.encode())
        write_bytes(self.output / f"{table.name}.json", (json.dumps(figures, indent=2) + "\n").encode())
        return page


def _name(task: Task) -> str:
    return f"{task.cell.category}, {setting_name(task.cell.setting)}, seed {task.cell.seed}"


def _goal(study: Study) -> str:
    if study.seconds is not None:
        return f"{study.seconds / 60:.1f} minutes each"
    return f"{study.recipe.optimiser.steps} steps each"


def _told(study: Study, task: Task, problem: Exception | None) -> str:
    if problem is not None:
        return f"failed: {problem}"
    trained, metrics = study.trained(task.cell), study.metrics(task.cell, task.test_views[0])
    iou = "" if metrics is None else f", IoU {metrics['iou']:.2f}"
    return f"{trained['steps']} steps in {trained['seconds']:.0f} s{iou}"


def _plan(study: Study, tasks: Sequence[Task], folders: Sequence[str]) -> str:
    """What there is and what is missing, a line each."""
    lines = [f"{'render':12}{folder}" for folder in folders]
    for task in tasks:
        if study.is_done(task):
            state = "done"
        elif study.is_trained(task.cell):
            state = "judge"
        else:
            state = "resume" if study.is_begun(task.cell) else "train"
        lines.append(f"{state:12}{_name(task)}")
    count = sum(not study.is_trained(task.cell) for task in tasks)
    return "\n".join([*lines, f"{count} of {len(tasks)} trainings to do, {_goal(study)}"])


TableCommand.__doc__ = f"{TableCommand.__doc__}\n    Tables: {', '.join(table_names())}.\n    "
