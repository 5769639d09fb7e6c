"""The service's memory while it works, and whether it grows."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.service_process import Service, memory_mebibytes

SETTLING = 0.1
"""Share of the samples before memory has settled."""


@dataclass
class MemoryTrace:
    """Resident memory, MiB, and when it was, seconds."""

    seconds: list[float] = field(default_factory=list)
    mebibytes: list[float] = field(default_factory=list)


@contextmanager
def traced(service: Service, interval: float = 1.0) -> Iterator[MemoryTrace]:
    """A trace of the service's memory until the end of the block; Linux only, else it stays empty."""
    trace, ended = MemoryTrace(), threading.Event()
    began = time.perf_counter()

    def watch() -> None:
        while memory := memory_mebibytes(service):
            trace.seconds.append(time.perf_counter() - began)
            trace.mebibytes.append(memory["now"])
            if ended.wait(interval):
                break

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        yield trace
    finally:
        ended.set()
        watcher.join()


def summary(trace: MemoryTrace) -> dict[str, Any]:
    """The trace of a phase, with about twenty of its samples. Empty where nothing was traced."""
    found = trace.mebibytes
    if not found:
        return {}
    return {
        "first_mebibytes": found[0],
        "last_mebibytes": found[-1],
        "most_mebibytes": max(found),
        "mebibytes": found[:: max(1, len(found) // 20)],
    }


def growth(trace: MemoryTrace, requests: int) -> float | None:
    """The slope of the line through all samples after the first tenth, MiB per 100,000 requests, where `requests` were
    made evenly from the first sample to the last; None where there are too few samples for a line."""
    seconds, mebibytes = np.array(trace.seconds), np.array(trace.mebibytes)
    settled = seconds > SETTLING * seconds.max(initial=0)
    if settled.sum() < 3:
        return None
    slope = np.polyfit(seconds[settled], mebibytes[settled], 1)[0]
    return round(float(slope) * float(seconds[-1] - seconds[0]) / requests * 100_000, 2)
