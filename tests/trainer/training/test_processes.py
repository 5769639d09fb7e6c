"""Two processes that share a batch compute what one does, and go on from where they were stopped."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.training.one_step import PARTS, SETTINGS, first_step, telling_codes
from trainer.config import OptimiserConfig
from trainer.errors import ConfigError
from trainer.training.checkpoint import load_checkpoint
from trainer.training.checks import check_processes

ROOT = Path(__file__).parents[3]
TRAINING = (
    "trainer", "train", "--preset", "fast", "--width", "32", "--height", "24", "--optimiser.batch-size", "8",
    "--precision", "float32",
)  # fmt: skip


def torchrun(*command: object) -> list[str]:
    start = [sys.executable, "-m", "torch.distributed.run", "--nproc-per-node", "2", "--master-port", str(_port())]
    return [*start, "-m", "--", *map(str, command)]


def _port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@pytest.fixture(scope="module")
def of_two(picture_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, torch.Tensor]]:
    target = tmp_path_factory.mktemp("of_two") / "step.pt"
    subprocess.run(
        torchrun("tests.trainer.training.one_step", picture_folder, target), check=True, cwd=ROOT, timeout=200
    )
    found: dict[str, dict[str, torch.Tensor]] = torch.load(target)
    return found


@pytest.mark.parametrize("setting", [*SETTINGS, *PARTS])
def test_loss_and_gradients_are_those_of_one_process(
    setting: str, of_two: dict[str, dict[str, torch.Tensor]], picture_folder: Path
) -> None:
    alone = first_step(SETTINGS[setting], picture_folder) if setting in SETTINGS else PARTS[setting](picture_folder)
    assert alone.keys() == of_two[setting].keys()
    for name, expected in alone.items():
        tolerance = 1e-5 * max(1.0, float(expected.float().abs().max()))
        np.testing.assert_allclose(of_two[setting][name], expected, atol=tolerance, rtol=1e-5, err_msg=name)


def test_the_codes_that_are_compared_tell_of_poses(picture_folder: Path) -> None:
    found = telling_codes(picture_folder)
    assert found["value"] > 0
    assert found["gradient"].abs().max() > 0


def test_a_training_of_two_is_one_that_is_stopped_and_goes_on(picture_folder: Path, tmp_path: Path) -> None:
    """The pictures of a step are drawn for all processes, each takes its own, and one of them writes."""
    options = ("--images", picture_folder, "--run", tmp_path / "two", "--intervals.log", "1", "--optimiser.steps")
    endless = torchrun(*TRAINING, *options, 100_000)
    with subprocess.Popen(endless, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 200
        while time.monotonic() < deadline and process.poll() is None and len(_lines(tmp_path / "two")) < 3:
            time.sleep(0.1)
        os.kill(process.pid, signal.SIGTERM)
        process.communicate(timeout=100)
    stopped = load_checkpoint(tmp_path / "two").step
    lines = _lines(tmp_path / "two")
    assert [line["step"] for line in lines] == list(range(1, stopped + 1))
    resumed = torchrun("trainer", "train", "--run", tmp_path / "two", "--resume", "--optimiser.steps", stopped + 2)
    subprocess.run(resumed, check=True, cwd=ROOT, timeout=200)
    assert load_checkpoint(tmp_path / "two").step == stopped + 2


def _lines(directory: Path) -> list[dict[str, float]]:
    path = directory / "metrics.jsonl"
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def test_a_batch_that_cannot_be_shared_evenly_is_refused() -> None:
    check_processes(OptimiserConfig(batch_size=12, views_per_instance=3), 2)
    for size, views, count in ((9, 1, 2), (12, 3, 8)):
        with pytest.raises(ConfigError, match=f"multiple of {count * views}, found {size}: {count} processes share"):
            check_processes(OptimiserConfig(batch_size=size, views_per_instance=views), count)


def test_processes_that_cannot_meet_are_named(tmp_path: Path) -> None:
    environment = os.environ | {"WORLD_SIZE": "2"}
    told = subprocess.run(
        [sys.executable, "-m", *TRAINING, "--images", ROOT / "tests", "--run", tmp_path / "run"],
        env=environment, cwd=ROOT, capture_output=True, text=True, timeout=100, check=False,
    )  # fmt: skip
    assert told.returncode == 2
    assert "Expected 2 processes to meet, as WORLD_SIZE says" in told.stderr
