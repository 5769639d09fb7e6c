"""Several tasks at once, in processes that take one after the other."""

import signal
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import NamedTuple

from trainer.errors import ChiaroError, DataError, StorageError
from trainer.interrupts import interrupts_left_to_this_process
from trainer.tables.cells import Task
from trainer.tables.study import Study
from trainer.tables.trial import run_task
from trainer.training.threads import limit_threads


class Outcome(NamedTuple):
    task: Task
    problem: ChiaroError | None
    """Why it could not be done."""


class _Worker(NamedTuple):
    process: SpawnProcess
    line: "Connection[Task | None, ChiaroError | None]"
    """Tasks go out, and what became of them comes back."""


def run_side_by_side(study: Study, tasks: Sequence[Task], workers: int, threads: int) -> Generator[Outcome]:
    """Runs the tasks, `workers` at once with `threads` threads each, and yields each as it ends.

    Ctrl-C and SIGTERM, and a caller who closes the generator, let every process save its training and end. A task that
    fails, or takes its process with it, does not stop the others; a full disk does. Raises StorageError for that.
    """
    waiting, idle = deque(tasks), list[_Worker]()
    busy: dict[Connection, tuple[_Worker, Task]] = {}
    try:
        with _terminated_like_ctrl_c():
            while waiting or busy:
                while waiting and len(busy) < workers:
                    with interrupts_left_to_this_process():
                        worker = idle.pop() if idle else _started(study, threads)
                        busy[worker.line] = worker, waiting.popleft()
                    worker.line.send(busy[worker.line][1])
                for line in connection.wait(list(busy)):
                    assert isinstance(line, Connection)
                    worker, task = busy.pop(line)
                    problem, alive = _answer(worker, task)
                    if alive:
                        idle.append(worker)
                    if isinstance(problem, StorageError):
                        raise problem
                    yield Outcome(task, problem)
    finally:
        started = [worker for worker, _ in busy.values()] + idle
        for worker in started:
            worker.process.terminate()
        for worker in started:
            worker.line.close()
            worker.process.join()


def _started(study: Study, threads: int) -> _Worker:
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(study, threads, theirs), daemon=True)
    process.start()
    theirs.close()
    return _Worker(process, ours)


def _answer(worker: _Worker, task: Task) -> tuple[ChiaroError | None, bool]:
    """(what a worker says of its task, whether it can take another)"""
    try:
        return worker.line.recv(), True
    except (EOFError, ConnectionResetError):
        worker.process.join()
        sentence = (
            f"the process that trained {task.cell.category} ended with status {worker.process.exitcode}, often for "
            "want of memory; run the same command again, with fewer --workers"
        )
        return DataError(sentence), False


def _work(study: Study, threads: int, line: "Connection[ChiaroError | None, Task]") -> None:
    limit_threads(threads)
    while True:
        problem: ChiaroError | None = None
        try:
            task = line.recv()
        except EOFError:
            return  # Nobody asks for more.
        try:
            run_task(study, task)
        except KeyboardInterrupt:
            return  # Saved; and who asked for it does not wait for an answer.
        except ChiaroError as error:
            problem = error
        line.send(problem)


@contextmanager
def _terminated_like_ctrl_c() -> Iterator[None]:
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
