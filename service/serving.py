"""Answering at a socket until a signal comes: in this process, or in several that share the socket."""

import os
import signal
import socket
import sys
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait
from threading import Thread
from types import FrameType
from typing import Final

import uvicorn
from threadpoolctl import threadpool_limits

from service.app import create_app
from service.catalogue import Catalogue, read_catalogue
from service.settings import Settings

_STOPPING: Final = (signal.SIGINT, signal.SIGTERM)
# Less than the 30 s after which Kubernetes kills: work is cancelled, and the process ends, before that.
_LEAVING_SECONDS: Final = 25


def serve(listener: socket.socket, catalogue: Catalogue, settings: Settings) -> None:
    """Answers until SIGINT or SIGTERM; then takes no more, finishes what came until then, and raises SystemExit(0)."""
    # Requests share the cores, and each computes on one. numpy's BLAS would wake a thread on every core for each of the
    # small products of a request, and let them wait there for the next one.
    threadpool_limits(1, "blas")
    app = create_app(catalogue, settings)
    config = uvicorn.Config(
        app,
        # Where httptools is installed, uvicorn would take that: it sets no limit to headers.
        http="h11",
        log_level="warning",
        server_header=False,
        timeout_graceful_shutdown=_LEAVING_SECONDS,
    )
    # uvicorn finishes what it began, and then raises the signal that stopped it once more.
    for number in _STOPPING:
        signal.signal(number, _leave)
    uvicorn.Server(config).run(sockets=[listener])


def serve_in_processes(listener: socket.socket, settings: Settings) -> int:
    """The same in `settings.workers` processes; returns the exit status: 1 where one of them ended by itself."""
    spawn = get_context("spawn")
    workers = [spawn.Process(target=_work, args=(listener, settings)) for _ in range(settings.workers)]
    stopped = False

    def stop(_: int, __: FrameType | None) -> None:
        nonlocal stopped
        stopped = True
        for worker in workers:
            if worker.is_alive():
                worker.terminate()

    for worker in workers:
        worker.start()
    for number in _STOPPING:
        signal.signal(number, stop)
    # Else the kernel would take connections for which nobody is left.
    listener.close()
    wait([worker.sentinel for worker in workers])
    asked = stopped
    stop(signal.SIGTERM, None)
    for worker in workers:
        worker.join()
    if asked:
        return 0
    print(
        f"--workers {settings.workers}: expected all processes to live, found that one ended; start the service again",
        file=sys.stderr,
    )
    return 1


def _work(listener: socket.socket, settings: Settings) -> None:
    Thread(target=_follow, daemon=True).start()
    serve(listener, read_catalogue(settings.models), settings)


def _follow() -> None:
    """Leaves as soon as the process that began this one is gone, even where that was killed."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.kill(os.getpid(), signal.SIGTERM)


def _leave(_: int, __: FrameType | None) -> None:
    raise SystemExit(0)
