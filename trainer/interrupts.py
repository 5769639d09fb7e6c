"""Ctrl-C where several processes work: a terminal sends it to all of them."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker


@contextmanager
def interrupts_left_to_this_process() -> Iterator[None]:
    """Processes that are started in the block inherit that Ctrl-C is held back, from their first moment on: this one
    alone decides what becomes of them. One that comes meanwhile reaches this process at the end of the block."""
    # It would let signals through again, were it started within the block.
    resource_tracker.ensure_running()
    with _postponed():
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _postponed() -> Iterator[None]:
    """A signal that one thread holds back is handed to another of the process, and Python would raise in the main one
    all the same, perhaps while it holds a lock of a pool, which then waits for ever. It is raised after the block."""
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    came = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: came.set())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if came.is_set():
            signal.raise_signal(signal.SIGINT)
