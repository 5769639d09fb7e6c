"""How many training pictures are rendered a second: `python -m trainer render`, by the clock, for each class.

`make bench-rendering` writes benchmarks/rendering.json, whose figures docs/results.md gives.
"""

import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro

from benchmarks.machine import machine, versions
from trainer.data.shapes.catalogue import CATEGORIES


@dataclass(frozen=True)
class Options:
    """Options of the measurement."""

    output: Path = Path("benchmarks/rendering.json")
    """The file with all figures."""
    folders: tuple[Path, ...] = (Path("/dev/shm"), Path("/tmp"), Path("out"))
    """Where pictures are written in turn and deleted again: in memory, and at two places of the disk."""
    classes: tuple[str, ...] = tuple(CATEGORIES)
    """What is drawn."""
    instances: int = 4000
    """Objects of each class, and pictures: each is drawn once, 128 x 96."""
    repeats: int = 3
    """Rounds: each draws every class into every folder, so that a slow minute does not meet one class alone."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.rendering", description=__doc__)
    seconds: dict[str, dict[str, list[float]]] = {}
    for _ in range(options.repeats):
        for category in options.classes:
            for folder in options.folders:
                folder.mkdir(parents=True, exist_ok=True)
                times = seconds.setdefault(f"{folder} ({file_system(folder)})", {}).setdefault(category, [])
                times.append(timed(category, folder, options.instances))
                print(f"{category} into {folder}: {options.instances / times[-1]:.0f} pictures a second", flush=True)
    report: dict[str, Any] = {
        "what": f"pictures a second of `python -m trainer render --class CLASS --instances {options.instances}`, by "
        "the clock, the start of Python included, in each round, by the folder that is written to; 128 x 96, all cores",
        "machine": machine(),
        "versions": versions(),
        "rates": {
            where: {
                category: [round(options.instances / each) for each in times] for category, times in classes.items()
            }
            for where, classes in seconds.items()
        },
    }
    report["medians"] = {
        where: {category: round(statistics.median(rates)) for category, rates in classes.items()}
        for where, classes in report["rates"].items()
    }
    options.output.write_text(json.dumps(report, indent=1) + "\n")
    print(f"written: {options.output}")


def timed(category: str, folder: Path, instances: int) -> float:
    """Seconds that the command takes."""
    pictures = Path(tempfile.mkdtemp(dir=folder))
    command = [sys.executable, "-m", "trainer", "render", "--class", category, "--instances", str(instances)]
    try:
        started = time.perf_counter()
        subprocess.run([*command, "--output", str(pictures)], check=True, capture_output=True)
        return time.perf_counter() - started
    finally:
        shutil.rmtree(pictures)


def file_system(folder: Path) -> str:
    """What a folder is on, such as ext4 or tmpfs (memory)."""
    found = subprocess.run(["stat", "--file-system", "--format=%T", str(folder)], check=True, capture_output=True)
    return {"ext2/ext3": "ext4"}.get(found.stdout.decode().strip(), found.stdout.decode().strip())


if __name__ == "__main__":
    main()
