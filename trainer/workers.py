"""Several tasks at once, in processes that take one after the other."""

import signal
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, Generic, NamedTuple, TypeVar

from trainer.errors import ChiaroError, DataError, StorageError
from trainer.interrupts import interrupts_left_to_this_process
from trainer.training.threads import limit_threads

Task = TypeVar("Task")


class Outcome(NamedTuple, Generic[Task]):
    task: Task
    problem: ChiaroError | None
    """Why it could not be done."""


class _Worker(NamedTuple):
    process: SpawnProcess
    line: "Connection[Any, ChiaroError | None]"
    """Tasks go out, and what became of them comes back."""


def run_one_by_one(work: Callable[[Task], None], tasks: Sequence[Task]) -> Generator[Outcome[Task]]:
    """The same as `run_side_by_side` in this process: a single worker need not be started, and takes all cores."""
    for task in tasks:
        problem: ChiaroError | None = None
        try:
            work(task)
        except StorageError:
            raise
        except ChiaroError as error:
            problem = error
        yield Outcome(task, problem)


def run_side_by_side(
    work: Callable[[Task], None], tasks: Sequence[Task], workers: int, threads: int, name: Callable[[Task], str]
) -> Generator[Outcome[Task]]:
    """Does `work` of every task, `workers` at once with `threads` threads each, and yields each as it ends.

    Work and tasks travel to other processes, which import them by name. `name` says in an error which task it was.
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
                        worker = idle.pop() if idle else _started(work, threads)
                        busy[worker.line] = worker, waiting.popleft()
                    worker.line.send(busy[worker.line][1])
                for line in connection.wait(list(busy)):
                    assert isinstance(line, Connection)
                    worker, task = busy.pop(line)
                    problem, alive = _answer(worker, name(task))
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


def _started(work: Callable[[Any], None], threads: int) -> _Worker:
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(work, threads, theirs), daemon=True)
    process.start()
    theirs.close()
    return _Worker(process, ours)


def _answer(worker: _Worker, name: str) -> tuple[ChiaroError | None, bool]:
    """(what a worker says of its task, whether it can take another)"""
    try:
        return worker.line.recv(), True
    except (EOFError, ConnectionResetError):
        worker.process.join()
        sentence = (
            f"the process that trained {name} ended with status {worker.process.exitcode}, often for "
            "want of memory; run the same command again, with fewer --workers"
        )
        return DataError(sentence), False


def _work(work: Callable[[Any], None], threads: int, line: "Connection[ChiaroError | None, Any]") -> None:
    limit_threads(threads)
    while True:
        problem: ChiaroError | None = None
        try:
            task = line.recv()
        except EOFError:
            return  # Nobody asks for more.
        try:
            work(task)
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
