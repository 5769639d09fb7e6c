"""How long the judge takes: `python -m trainer evaluate` on mesh files, by the clock.

`make bench-judging MESHES=DIR` writes benchmarks/judging.json. The pictures that align the model are rendered before
the clock starts; the start of Python counts.
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
from trainer.data.meshes import mesh_files


@dataclass(frozen=True)
class Options:
    """Options of the measurement."""

    meshes: Path
    """Folder of mesh files, of which as many are judged, evenly spread over all, by name."""
    output: Path = Path("benchmarks/judging.json")
    """The file with all figures."""
    bundle: Path = Path("models/car")
    """The model that is judged."""
    count: int = 100
    """Meshes, of which the judge renders the paper's 24 views each."""
    validation_objects: int = 200
    """Procedural cars, one picture each, by which the model is aligned."""
    repeats: int = 3
    """Times that it is measured."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.judging", description=__doc__)
    found = mesh_files(options.meshes)
    if len(found) < options.count:
        raise SystemExit(f"expected at least {options.count} mesh files in {options.meshes}, found {len(found)}")
    chosen = [found[index * len(found) // options.count] for index in range(options.count)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "meshes").mkdir()
        for number, file in enumerate(chosen):
            shutil.copy(file, folder / "meshes" / f"{number:03}{file.suffix}")
        run("render", "--class", "car", "--instances", options.validation_objects, "--output", folder / "validation")
        seconds = [judged(options.bundle, folder) for _ in range(options.repeats)]
        objects = json.loads((folder / "judged" / "metrics.json").read_text())["objects"]
    report: dict[str, Any] = {
        "what": f"seconds of `python -m trainer evaluate` for {objects} meshes in 24 views each, aligned by "
        f"{options.validation_objects} pictures, by the clock, the start of Python included",
        "machine": machine(),
        "versions": versions(),
        "seconds": [round(each, 1) for each in seconds],
        "median": round(statistics.median(seconds), 1),
    }
    options.output.write_text(json.dumps(report, indent=1) + "\n")
    print(f"{report['median']} seconds; written: {options.output}")


def judged(bundle: Path, folder: Path) -> float:
    """Seconds that it takes to judge a bundle on the meshes in a folder."""
    started = time.perf_counter()
    run("evaluate", "--bundle", bundle, "--meshes", folder / "meshes", "--validation", folder / "validation",
        "--output", folder / "judged")  # fmt: skip
    return time.perf_counter() - started


def run(*arguments: object) -> None:
    subprocess.run([sys.executable, "-m", "trainer", *map(str, arguments)], check=True, capture_output=True)


if __name__ == "__main__":
    main()
