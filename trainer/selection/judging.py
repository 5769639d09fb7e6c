"""Candidates trained up to a step and judged, side by side, where that is not done yet."""

from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial

import numba

from trainer.data.images import ImageSet
from trainer.selection.candidates import Candidate
from trainer.selection.record import Record, load_record
from trainer.selection.selection import Selection, Task
from trainer.selection.trial import run_task
from trainer.workers import run_one_by_one, run_side_by_side


def judge(
    selection: Selection,
    images: ImageSet,
    workers: int,
    say: Callable[[str], None],
    candidates: Sequence[Candidate],
    step: int,
) -> dict[Candidate, Record]:
    """What each candidate shows after so many steps. `workers` are as many processes (0: one per core), `say` is told
    of every one that is done.

    Raises as `run_task` does, and DataError where a process ended before its task.
    """
    tasks = [Task(candidate, step) for candidate in candidates]
    missing = [task for task in tasks if load_record(selection.record(task)) is None]
    cores: int = numba.config.NUMBA_NUM_THREADS
    workers = min(workers or cores, max(1, len(missing)))
    if missing:
        say(f"{len(tasks)} candidates to step {step}, {workers} at once")
    work = partial(run_task, selection, images)
    if workers == 1:
        running = run_one_by_one(work, missing)
    else:
        running = run_side_by_side(work, missing, workers, max(1, cores // workers), lambda task: task.candidate.name)
    with closing(running) as outcomes:
        for number, (task, problem) in enumerate(outcomes, 1):
            if problem is not None:
                raise problem
            say(f"[{number}/{len(missing)}] {task.candidate.name}: {_told(_record(selection, task))}")
    return {task.candidate: _record(selection, task) for task in tasks}


def _record(selection: Selection, task: Task) -> Record:
    found = load_record(selection.record(task))
    assert found is not None
    return found


def _told(record: Record) -> str:
    if record.problem is not None:
        return f"failed: {record.problem}"
    return f"bound {record.mean:.2f}, after {record.training_core_seconds:.0f} s of a core"
