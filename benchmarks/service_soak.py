"""The service under load for long: nothing lost, nothing mixed up, memory flat; and how it starts with all models.

`python -m benchmarks.service_soak` writes service_soak.json.
"""

import datetime
import importlib.metadata
import json
import os
import shlex
import statistics
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console

from benchmarks.machine import machine, versions
from benchmarks.service_flood import measure_flood
from benchmarks.service_load import measure_service
from benchmarks.service_memory import growth, summary, traced
from benchmarks.service_pictures import HEIGHT, WIDTH, Question, make_questions
from benchmarks.service_process import PACKAGES, Service, memory_mebibytes, serving
from service.catalogue import read_catalogue


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    models: Path = Path("models")
    """A bundle, or a directory of bundles."""
    category: str = "car"
    """Whose model is asked alone."""
    output: Path = Path("benchmarks")
    """Folder for service_soak.json."""
    clients: int = 64
    """Clients that ask at the same time."""
    threads: int = os.cpu_count() or 1
    """Threads of the service."""
    pictures: int = 32
    """Different pictures that are asked about; of each category a share."""
    seconds: float = 60.0
    """How long the clients ask about one category, and about all, and how long more is offered than can be served."""
    overload: float = 2.0
    """How many times what was served is then offered."""
    requests: int = 100_000
    """Requests of the longest phase."""
    starts: int = 5
    """Cold starts."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.service_soak", description=__doc__)
    console = Console(stderr=True)
    report: dict[str, Any] = {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": {**versions(), **{name: importlib.metadata.version(name) for name in PACKAGES}},
        "command": shlex.join(["python", "-m", "benchmarks.service_soak", *sys.argv[1:]]),
        "picture": f"{WIDTH} × {HEIGHT} JPEG",
        "threads": options.threads,
        "seconds": options.seconds,
        **soak(options, console),
    }
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "service_soak.json").write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    console.print(f"written: {options.output / 'service_soak.json'}")


def soak(options: Options, console: Console) -> dict[str, Any]:
    """All phases, the last four on one service."""
    categories = read_catalogue(options.models).names
    found: dict[str, Any] = {"categories": list(categories), "start": starts(options)}
    console.print(found["start"])
    with serving(options.models, options.threads) as service:
        alone = make_questions(service, options.category, options.pictures)
        mixed = mixed_questions(service, categories, options.pictures)
        found["one_category"] = steady(service, alone, options.clients, options.seconds)
        console.print(found["one_category"])
        found["all_categories"] = steady(service, mixed, options.clients, options.seconds)
        console.print(found["all_categories"])
        rate = options.overload * found["all_categories"]["per_second"]
        found["overload"] = flooded(service, mixed, rate, options.seconds, 4 * options.clients)
        console.print(found["overload"])
        found["long"] = steady(service, mixed, options.clients, float("inf"), options.requests)
        console.print(found["long"])
    return found


def starts(options: Options) -> dict[str, Any]:
    """Seconds from the start of the process until all models are proven, and its memory then."""
    seconds, now, peak = [], [], []
    for _ in range(options.starts):
        with serving(options.models, options.threads) as service:
            memory = memory_mebibytes(service)
            seconds.append(round(service.seconds_to_ready, 3))
            now.append(memory.get("now"))
            peak.append(memory.get("peak"))
    return {
        "median_seconds_to_ready": statistics.median(seconds),
        "seconds_to_ready": seconds,
        "mebibytes": now,
        "peak_mebibytes": peak,
    }


def mixed_questions(service: Service, categories: tuple[str, ...], count: int) -> list[Question]:
    """Pictures of every category, in turns."""
    share = -(-count // len(categories))
    each = [make_questions(service, category, share) for category in categories]
    return [question for turn in zip(*each, strict=True) for question in turn]


def steady(
    service: Service, questions: list[Question], clients: int, seconds: float, requests: int | None = None
) -> dict[str, Any]:
    """Clients that each ask as soon as they are answered, for as long, or as often; then also how memory grew."""
    with traced(service) as trace:
        measured = measure_service(service, questions, clients, seconds, requests)
    found = {"clients": clients, **measured, "memory": summary(trace)}
    if requests is not None:
        found["mebibytes_per_100000_requests"] = growth(trace, measured["requests"])
    return found


def flooded(service: Service, questions: list[Question], rate: float, seconds: float, clients: int) -> dict[str, Any]:
    """Pictures at a fixed rate."""
    with traced(service) as trace:
        measured = measure_flood(service, questions, rate, seconds, clients)
    return {"clients": clients, **measured, "memory": summary(trace)}


if __name__ == "__main__":
    main()
