"""The service beside its floor: whole requests, and the two ONNX graphs alone on the same pictures, in one run.

`python -m benchmarks.service` writes service.json and service.png.
"""

import datetime
import importlib.metadata
import json
import os
import shlex
import statistics
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console

from benchmarks.machine import machine, versions
from benchmarks.service_charts import write_charts
from benchmarks.service_load import measure_graphs, measure_service, prepared
from benchmarks.service_pictures import HEIGHT, WIDTH, make_questions
from benchmarks.service_process import PACKAGES, memory_mebibytes, serving
from service.catalogue import read_catalogue


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    models: Path = Path("models")
    """A bundle, or a directory of bundles."""
    category: str = "car"
    """Whose model is asked."""
    output: Path = Path("benchmarks")
    """Folder for service.json and service.png."""
    clients: tuple[int, ...] = (1, 4, 16, 64)
    """Numbers of clients that ask at the same time."""
    threads: int = os.cpu_count() or 1
    """Threads of the service, and of the graphs beside it."""
    pictures: int = 32
    """Different pictures that are asked about."""
    seconds: float = 20.0
    """How long each number of clients is measured, and the graphs beside it."""
    starts: int = 5
    """Cold starts."""
    quick: bool = False
    """Two numbers of clients, a second each, two starts: to see that all works."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.service", description=__doc__)
    if options.quick:
        options = replace(options, clients=options.clients[:2], seconds=1.0, pictures=4, starts=2)
    console = Console(stderr=True)
    options.output.mkdir(parents=True, exist_ok=True)
    report: dict[str, Any] = {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": {**versions(), **{name: importlib.metadata.version(name) for name in PACKAGES}},
        "command": shlex.join(["python", "-m", "benchmarks.service", *sys.argv[1:]]),
        "picture": f"{WIDTH} × {HEIGHT} JPEG",
        "threads": options.threads,
        "seconds": options.seconds,
        "seconds_to_ready": cold_starts(options),
        **loads(options, console),
    }
    (options.output / "service.json").write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    write_charts(report, options.output / "service.png")
    console.print(f"written: {options.output / 'service.json'}, {options.output / 'service.png'}")


def cold_starts(options: Options) -> dict[str, Any]:
    """Seconds from the start of the process until it is ready, over several starts."""
    found = []
    for _ in range(options.starts):
        with serving(options.models, options.threads) as service:
            found.append(round(service.seconds_to_ready, 3))
    return {"median": statistics.median(found), "all": found}


def loads(options: Options, console: Console) -> dict[str, Any]:
    """At each number of clients the service, and right before it the graphs: one thread for the time of a picture, all
    threads for the throughput."""
    catalogue = read_catalogue(options.models)
    catalogue.load()
    engine = catalogue.engine(options.category)
    measured = []
    with serving(options.models, options.threads) as service:
        questions = make_questions(service, options.category, options.pictures)
        pictures = prepared(engine, questions)
        before = memory_mebibytes(service)
        for clients in options.clients:
            alone = measure_graphs(engine, pictures, 1, options.seconds / 4)
            together = measure_graphs(engine, pictures, options.threads, options.seconds / 4)
            answered = measure_service(service, questions, clients, options.seconds)
            measured.append(
                {
                    "clients": clients,
                    "service": answered,
                    "graphs_one_thread": alone,
                    "graphs_all_threads": together,
                    "p50_over_graphs": round(answered["p50_ms"] / alone["p50_ms"], 3),
                    "throughput_over_graphs": round(answered["per_second"] / together["per_second"], 3),
                    "memory_mebibytes": memory_mebibytes(service),
                }
            )
            console.print(_line(measured[-1]))
    return {"model": engine.manifest.identity, "memory_mebibytes_before": before, "loads": measured}


def _line(measured: dict[str, Any]) -> str:
    service = measured["service"]
    return (
        f"{measured['clients']} clients: "
        f"p50 {service['p50_ms']:.1f} ms ({measured['p50_over_graphs']:.2f} × the graphs), "
        f"p99 {service['p99_ms']:.1f} ms, {service['per_second']:.0f} per second "
        f"({measured['throughput_over_graphs']:.0%} of the graphs), {service['outcomes']}"
    )


if __name__ == "__main__":
    main()
