"""A training that is killed with signal 9, at any moment, goes on from its last checkpoint as if nothing had been.

CHIARO_KILLS sets how many times it is killed (3).
"""

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numba
import pytest
import torch

from tests.trainer.training.runs import run, with_steps
from tests.trainer.training.test_loop import assert_same, metrics
from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.training.checkpoint import FILE_NAME, load_checkpoint
from trainer.training.threads import limit_threads

ROOT = Path(__file__).parents[3]
KILLS = int(os.environ.get("CHIARO_KILLS", "3"))


@pytest.fixture
def one_thread() -> Iterator[None]:
    """Others add in another order; how many this process has depends on the tests before."""
    before = torch.get_num_threads(), numba.get_num_threads()
    limit_threads(1)
    yield
    torch.set_num_threads(before[0])
    numba.set_num_threads(before[1])


@pytest.mark.usefixtures("one_thread")
def test_no_kill_loses_a_checkpoint_or_changes_the_result(
    config: TrainConfig, images: ImageSet, picture_folder: Path, tmp_path: Path
) -> None:
    directory, moments = tmp_path / "killed", random.Random(0)
    command = ["train", "--resume", "--images", picture_folder, "--run", directory, "--threads", 1,
               "--optimiser.steps", 10**6, "--intervals.checkpoint", 1, "--intervals.log", 1,
               "--intervals.preview", 1000]  # fmt: skip
    reached = run(with_steps(config, 1), images, directory).step
    for kill in range(KILLS):
        arguments = [sys.executable, "-m", "trainer", *map(str, command)]
        with subprocess.Popen(arguments, cwd=ROOT, stderr=subprocess.DEVNULL) as process:
            _wait_for_another_checkpoint(process, directory / FILE_NAME)
            time.sleep(moments.uniform(0.0, 0.3))
            process.send_signal(signal.SIGKILL)
        last = load_checkpoint(directory).step
        assert last > reached, kill
        reached = last
    killed = run(with_steps(config, reached + 2), images, directory, resume=True)
    assert not list(directory.glob(".*.part"))
    straight = run(with_steps(config, reached + 2), images, tmp_path / "straight")
    assert_same(killed, straight)
    assert metrics(directory) == metrics(tmp_path / "straight")


def _wait_for_another_checkpoint(process: subprocess.Popen[bytes], file: Path) -> None:
    deadline, before = time.monotonic() + 120, file.stat().st_mtime_ns
    while file.stat().st_mtime_ns == before:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.005)
