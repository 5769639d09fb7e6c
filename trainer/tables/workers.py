"""Several tasks of a study at once."""

from collections.abc import Generator, Sequence
from functools import partial

from trainer.tables.cells import Task
from trainer.tables.study import Study
from trainer.tables.trial import run_task
from trainer.workers import Outcome
from trainer.workers import run_side_by_side as run_any_side_by_side


def run_side_by_side(study: Study, tasks: Sequence[Task], workers: int, threads: int) -> Generator[Outcome[Task]]:
    """Trains and judges what the tasks lack, as `trainer.workers.run_side_by_side` does any work."""
    return run_any_side_by_side(partial(run_task, study), tasks, workers, threads, lambda task: task.cell.category)
