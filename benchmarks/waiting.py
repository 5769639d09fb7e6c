"""How long a training's step takes by itself and beside other work, by how long OpenMP's threads wait awake.

`python -m benchmarks.waiting` writes docs/results/waiting.json.
"""

import datetime
import json
import os
import shlex
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import tyro
from rich.console import Console

from benchmarks.machine import machine, versions
from trainer import SPIN_COUNT

LIBGOMP_SPIN_COUNT = 300_000
"""What libgomp takes where no variable says otherwise."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    output: Path = Path("docs/results")
    """Folder for waiting.json."""
    spin_counts: tuple[int, ...] = (LIBGOMP_SPIN_COUNT, 10_000, SPIN_COUNT, 1_000, 0)
    """Values of GOMP_SPINCOUNT: how many times a thread looks whether there is work before it sleeps."""
    preset: str = "sharp"
    """Settings that are trained with."""
    steps: int = 30
    """Steps that are measured."""
    rounds: int = 3
    """How often each setting is measured, in turns; the median counts."""
    pictures: int = 256
    """Pictures that are trained on, of as many cars."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.waiting", description=__doc__)
    console = Console(stderr=True)
    found: dict[tuple[int, bool], list[float]] = {}
    with TemporaryDirectory() as folder:
        render = ["render", "--class", "car", "--instances", str(options.pictures), "--output", folder]
        subprocess.run([sys.executable, "-m", "trainer", *render], check=True, stderr=subprocess.DEVNULL)
        for turn in range(options.rounds):
            for spin_count in options.spin_counts:
                for beside in (False, True):
                    seconds = seconds_a_step(Path(folder), options, spin_count, beside)
                    found.setdefault((spin_count, beside), []).append(seconds)
                    console.print(f"round {turn + 1}: {spin_count}, {beside=}: {seconds:.3f} s a step")
    report = {
        "what": f"Seconds a step of {options.preset} on all cores, by GOMP_SPINCOUNT: alone, and beside one process "
        "that keeps a core busy.",
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": versions(),
        "command": shlex.join(["python", "-m", "benchmarks.waiting", *sys.argv[1:]]),
        "spin_counts": {
            str(spin_count): {
                name: {"median": round(statistics.median(taken), 4), "repeats": [round(one, 4) for one in taken]}
                for name, taken in (("alone", found[spin_count, False]), ("beside", found[spin_count, True]))
            }
            for spin_count in options.spin_counts
        },
    }
    (options.output / "waiting.json").write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    console.print(f"written: {options.output / 'waiting.json'}")


def seconds_a_step(images: Path, options: Options, spin_count: int, beside: bool) -> float:
    known = {name: value for name, value in os.environ.items() if name != "OMP_WAIT_POLICY"}
    settings = ["--images", str(images), "--preset", options.preset, "--steps", str(options.steps)]
    command = [sys.executable, "-m", "benchmarks.training_steps", *settings, "--threads", "0"]
    with busy_core() if beside else nullcontext():
        told = subprocess.run(
            command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env=known | {"GOMP_SPINCOUNT": str(spin_count)},
        )  # fmt: skip
    return float(json.loads(told.stdout.splitlines()[-1])["seconds"])


@contextmanager
def busy_core() -> Iterator[None]:
    """A program beside the training that never rests; in a session of its own, as whatever is started elsewhere."""
    program = subprocess.Popen([sys.executable, "-c", "while True: pass"], start_new_session=True)
    try:
        yield
    finally:
        program.kill()
        program.wait()


if __name__ == "__main__":
    main()
