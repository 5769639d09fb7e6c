"""`python -m trainer frontier`"""

import sys
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Self

import numba
from rich.console import Console

from trainer.errors import ConfigError, DataError
from trainer.evaluation.subject import check_refinement
from trainer.frontier.files import write_report
from trainer.frontier.measurement import measure
from trainer.frontier.plan import load_plan
from trainer.frontier.trainings import compile_kernels, study_of, tasks_of
from trainer.tables.cells import Task
from trainer.tables.pictures import missing_folders, render_missing
from trainer.tables.setting import setting_name
from trainer.tables.study import Study
from trainer.tables.trial import check_identity
from trainer.tables.workers import run_side_by_side
from trainer.training.checks import check_category, check_settings
from trainer.training.threads import limit_threads
from trainer.workers import run_side_by_side as run_any_side_by_side


@dataclass(frozen=True)
class FrontierCommand:
    """Chart accuracy against cost: picture size, encoder width, subdivision, blocks, latent size, pose bins, precision,
    edges, refinement; one factor at a time.

    Pictures are rendered, models trained and judged, bundles exported and timed, where that is not done yet: the same
    command goes on where it was interrupted.
    """

    budget: str = "full"
    """Which points, on how much: `small`, minutes; `full`, one to two hours of one core; or a TOML file like theirs."""
    output: Path = Path("out/frontier")
    """Directory for pictures, runs and bundles, a folder for each budget."""
    report: Path | None = None
    """Directory for frontier.md, results/frontier.json and .csv, and images/frontier-*.png; by default the budget's
    own. Of a page that is there, what stands outside its figures is kept."""
    workers: int = 0
    """Trainings at once, which share the cores; 0 means one per core."""
    dry_run: bool = False
    """Only say what would be trained."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        return cls()

    def run(self) -> None:
        if not 0 <= self.workers <= 1024:
            raise ConfigError(f"Expected --workers from 0 to 1024, found {self.workers}.")
        plan = load_plan(self.budget)
        study = study_of(plan, self.output / Path(self.budget).stem)
        tasks = tasks_of(plan)
        for point in plan.points:
            check_refinement(point.choice.refine)
        for task in tasks:
            check_category(task.cell.category)
            check_settings(study.config(task.cell))
            check_identity(study, task.cell)
        missing = [task for task in tasks if not study.is_done(task)]
        if self.dry_run:
            for task in tasks:
                print(f"{'train' if task in missing else 'done':8}{_name(task)}")
            return
        failures = self._train(study, missing)
        # Alone on one core, as latencies are told.
        limit_threads(1)
        folder = self.report or study.root
        written = write_report(measure(plan, study, Path(self.budget).stem), folder)
        print(f"written to {folder}: {', '.join(written)}")
        if not any(name.endswith(".png") for name in written):
            print("no charts: they need matplotlib; pip install 'chiaro[bench]'", file=sys.stderr)
        if failures:
            raise DataError(f"{len(failures)} of {len(missing)} trainings failed; first: {failures[0]}")

    def _train(self, study: Study, missing: list[Task]) -> list[str]:
        """Renders, trains and judges, and returns a sentence for each training that failed."""
        if not missing:
            return []
        cores: int = numba.config.NUMBA_NUM_THREADS
        for folder in missing_folders(study, missing):
            render_missing(folder, self.workers or cores)
        # In a process of its own, which Ctrl-C ends like the others. What fails here fails again, and is told, below.
        first = partial(compile_kernels, study)
        list(run_any_side_by_side(first, missing[:1], 1, cores, _name))
        workers = min(self.workers or cores, len(missing))
        console, failures = Console(stderr=True, soft_wrap=True), list[str]()
        with closing(run_side_by_side(study, missing, workers, max(1, cores // workers))) as outcomes:
            for number, (task, problem) in enumerate(outcomes, 1):
                name = _name(task)
                if problem is not None:
                    failures.append(f"{name}: {problem}")
                seconds = "failed" if problem else f"{study.trained(task.cell)['seconds']:.0f} s"
                console.print(f"[{number}/{len(missing)}] {name}: {problem or seconds}", markup=False)
        return failures


def _name(task: Task) -> str:
    return f"{task.cell.category}, {setting_name(task.cell.setting)}, seed {task.cell.seed}"
