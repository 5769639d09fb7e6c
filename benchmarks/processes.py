"""A contender without threads of its own, on several cores: worker processes that share the pictures."""

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection

import numpy as np

from benchmarks.contender import Contender, Gradients, Renderer
from benchmarks.scene import Scene


@contextmanager
def in_processes(contender: Contender, scene: Scene, count: int) -> Iterator[Renderer]:
    """A renderer whose calls return when all workers have done their share, which stays with them.

    What a user would have to send back to the parent process is left out, in the contender's favour.

    Raises:
        ChildProcessError: a worker ended before it was ready.
    """
    spawn = multiprocessing.get_context("spawn")
    share = scene.count // count
    lines: list[Connection] = []
    workers = []
    for index in range(count):
        here, there = spawn.Pipe()
        worker = spawn.Process(
            target=_work, args=(there, contender, scene.part(index * share, (index + 1) * share)), daemon=True
        )
        worker.start()
        there.close()
        lines.append(here)
        workers.append(worker)

    def all_do(mode: str) -> None:
        for line in lines:
            line.send(mode)
        for line in lines:
            _await(line, contender.name)

    def forward() -> np.ndarray:
        all_do("forward")
        return np.empty(0)

    def step() -> Gradients:
        all_do("step")
        return Gradients(np.empty(0), np.empty(0))

    try:
        for line in lines:
            _await(line, contender.name)
        yield Renderer(forward, step)
    finally:
        for line in lines:
            line.close()
        for worker in workers:
            worker.join()


def _await(line: Connection, name: str) -> None:
    try:
        line.recv()
    except EOFError as error:
        raise ChildProcessError(f"expected a worker process of {name} to answer, found that it has ended") from error


def _work(line: Connection, contender: Contender, scene: Scene) -> None:
    contender.use_cores(1)
    renderer = contender.prepare(scene)
    line.send("ready")
    while True:
        try:
            mode = line.recv()
        except EOFError:
            return
        if mode == "forward":
            renderer.forward()
        else:
            renderer.step()
        line.send("done")
