"""Ctrl-C where several processes work: a terminal sends it to all of them."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker


@contextmanager
def interrupts_left_to_this_process() -> Iterator[None]:
    """Processes that are started in the block inherit that Ctrl-C is held back, from their first moment on: this one
    alone decides what becomes of them. One that comes meanwhile reaches this process at the end of the block."""
    # It would let signals through again, were it started within the block.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
