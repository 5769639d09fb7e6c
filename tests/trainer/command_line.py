"""`python -m trainer` as tests call it: in this process, or in one of its own."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from trainer.__main__ import main

SMALL = ["--width", "32", "--height", "24"]


@contextmanager
def start(*arguments: str | Path) -> Iterator[subprocess.Popen[str]]:
    """`python -m trainer …` in a process group of its own, as a terminal would start it: with Ctrl-C not ignored, as it
    is where these tests themselves run in the background of a shell. Nothing of the group outlives the block."""
    command = [sys.executable, "-m", "trainer", *map(str, arguments)]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
    finally:
        signal.signal(signal.SIGINT, before)
    with process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    with start(*arguments) as process:
        output, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors
    return subprocess.CompletedProcess(process.args, process.returncode, output, errors)


def answer(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """(status, standard output, standard error) of a command in this process, line breaks and frames taken away."""
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as ending:
        status = int(ending.code or 0)
    captured = capsys.readouterr()
    return status, *(re.sub(r"[\s│╭╮╰╯─]+", " ", text) for text in captured)


def opened(path: Path) -> np.ndarray:
    with Image.open(path) as picture:
        return np.asarray(picture)


def wait_for(process: subprocess.Popen[str], happened: object) -> None:
    assert callable(happened)
    deadline = time.monotonic() + 60
    while not happened():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
