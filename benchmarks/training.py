"""Pictures that a training takes in per second, by processes and threads, and where the time goes.

`python -m benchmarks.training` writes training.json.
"""

import datetime
import json
import os
import shlex
import socket
import statistics
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, NamedTuple

import torch
import tyro
from rich.console import Console

from benchmarks.machine import machine, versions
from trainer import SPIN_COUNT

CORES = os.cpu_count() or 1


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    output: Path = Path("benchmarks")
    """Folder for training.json."""
    presets: tuple[str, ...] = ("fast", "sharp", "paper")
    """Settings that are trained with."""
    steps: int = 60
    """Steps that are measured."""
    rounds: int = 3
    """How often each setting is measured; the median counts."""
    pictures: int = 512
    """Pictures that are trained on, of as many cars."""
    images: Path | None = None
    """Folder of pictures to train on in their place."""
    devices: tuple[Literal["cpu", "cuda"], ...] = ("cpu", "cuda") if torch.cuda.is_available() else ("cpu",)
    """Where to train."""


class Way(NamedTuple):
    """How a training computes."""

    device: str
    processes: int
    threads: int
    recorded: bool


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.training", description=__doc__)
    console = Console(stderr=True)
    on_cores = Way("cpu", 1, 1, False), Way("cpu", 1, CORES, False), Way("cpu", CORES, 1, False)
    on_gpu = Way("cuda", 1, CORES, False), Way("cuda", 1, CORES, True)
    ways = [way for way in dict.fromkeys(on_cores + on_gpu) if way.device in options.devices]
    found: dict[tuple[str, Way], list[dict[str, Any]]] = {}
    with TemporaryDirectory() as folder:
        images = options.images or Path(folder)
        if options.images is None:
            render = ["trainer", "render", "--class", "car", "--instances", str(options.pictures), "--output", folder]
            subprocess.run([sys.executable, "-m", *render], check=True, stderr=subprocess.DEVNULL)
        for turn in range(options.rounds):
            for preset in options.presets:
                for way in ways:
                    console.print(f"round {turn + 1}: {preset}, {way}")
                    found.setdefault((preset, way), []).append(measure(images, preset, options.steps, way))
    report = {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "gpu": torch.cuda.get_device_name() if torch.cuda.is_available() else None,
        "versions": versions(),
        "command": shlex.join(["python", "-m", "benchmarks.training", *sys.argv[1:]]),
        "trainings": [summary(*key, rounds) for key, rounds in found.items()],
    }
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "training.json").write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    console.print(f"written: {options.output / 'training.json'}")


def measure(images: Path, preset: str, steps: int, way: Way) -> dict[str, Any]:
    """What `benchmarks.training_steps` prints."""
    start = [sys.executable, "-m"]
    if way.processes > 1:
        start += [
            "torch.distributed.run",
            "--nproc-per-node",
            str(way.processes),
            "--master-port",
            str(free_port()),
            "-m",
            "--",
        ]
    options = ["--images", images, "--preset", preset, "--steps", steps, "--threads", way.threads]
    where = ["--device", way.device, "--record" if way.recorded else "--no-record"]
    command = [*start, "benchmarks.training_steps", *map(str, options), *where]
    # As `python -m trainer` has it, which has said so before torch is there.
    known = os.environ | {"GOMP_SPINCOUNT": str(SPIN_COUNT)}
    told = subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=known)
    once: dict[str, Any] = json.loads(told.stdout.splitlines()[-1])
    return once


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def summary(preset: str, way: Way, rounds: list[dict[str, Any]]) -> dict[str, Any]:
    seconds = [once["seconds"] for once in rounds]
    middle = sorted(rounds, key=lambda once: once["seconds"])[len(rounds) // 2]
    rate = rounds[0]["batch"] / statistics.median(seconds)
    return {
        "preset": preset,
        **way._asdict(),
        "batch": rounds[0]["batch"],
        "pictures_per_second": round(rate, 1),
        "seconds_a_step": [round(one, 4) for one in seconds],
        "share": {name: round(spent / middle["seconds"], 3) for name, spent in middle["stages"].items()},
        "network_operations": middle["network_operations"],
        "peak_operations_a_second": middle["peak_operations_a_second"],
        "share_of_the_networks_at_that": round(middle["least_seconds"] / middle["seconds"], 3),
    }


if __name__ == "__main__":
    main()
