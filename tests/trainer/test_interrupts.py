"""Ctrl-C while processes are started: it waits, whichever thread it is handed to."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from trainer.interrupts import interrupts_left_to_this_process


@contextmanager
def another_thread() -> Iterator[None]:
    """That takes any signal."""
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


@pytest.fixture
def handled() -> Iterator[None]:
    """Ctrl-C is not ignored, as it is where these tests run in the background of a shell."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("handled")
def test_ctrl_c_comes_at_the_end_of_the_block() -> None:
    passed = []

    def interrupted() -> None:
        with interrupts_left_to_this_process():
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(100):
                time.sleep(0.001)
            passed.append(True)

    with another_thread(), pytest.raises(KeyboardInterrupt):
        interrupted()
    assert passed
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("handled")
def test_processes_that_are_started_in_the_block_hold_it_back() -> None:
    code = "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"
    command = [sys.executable, "-c", code]
    with interrupts_left_to_this_process():
        inside = subprocess.run(command, capture_output=True, text=True, check=True)
    outside = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (inside.stdout, outside.stdout) == ("True\n", "False\n")


def test_what_is_ignored_stays_ignored_and_other_threads_may_start_processes() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_left_to_this_process():
            os.kill(os.getpid(), signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    passed = threading.Event()

    def elsewhere() -> None:
        with interrupts_left_to_this_process():
            passed.set()

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert passed.is_set()
