"""Rates of several contenders on one scene, taken in turn so that a noisy machine disturbs all alike."""

import statistics
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from typing import Any, Literal

from benchmarks.contender import Contender
from benchmarks.processes import in_processes
from benchmarks.scene import Scene

Mode = Literal["forward", "forward+backward"]
# A call is repeated within one measurement until this has passed; a contender whose call would take longer than
# LONGEST_CALL draws fewer pictures per call.
LONGEST_CALL_SECONDS = 0.4
# For threads of other contenders that still wait for work to fall asleep.
PAUSE_SECONDS = 0.02


@dataclass(frozen=True)
class Rates:
    """Pictures per second of one contender on one case."""

    pictures_per_call: int
    median: float
    lowest: float
    highest: float
    repeats: tuple[float, ...]
    """As they were taken; those with the same index in different contenders are neighbours in time."""


@dataclass(frozen=True)
class Case:
    """What is drawn, and how."""

    segments: int
    width: int
    height: int
    mode: Mode
    cores: int

    def described(self) -> dict[str, Any]:
        return {"faces": 12 * self.segments**2, **asdict(self)}


@dataclass(frozen=True)
class Ready:
    """A contender with its scene and its processes, warmed up."""

    call: Callable[[], None]
    pictures: int
    use_cores: Callable[[int], None]


def measure(
    contenders: list[Contender], scene: Scene, case: Case, repeats: int, seconds: float
) -> tuple[dict[str, Rates], dict[str, str]]:
    """Rates by contender, and the errors of those contenders that cannot draw this case.

    Each of `repeats` measurements of a contender lasts `seconds` at least.
    """
    failed: dict[str, str] = {}
    ready: dict[str, Ready] = {}
    rates: dict[str, list[float]] = {}
    with ExitStack() as running:
        for contender in contenders:
            try:
                ready[contender.name] = _prepared(contender, scene, case, running)
            # A peer may fail as it likes; the others are still measured.
            except Exception as error:
                failed[contender.name] = f"{type(error).__name__}: {error}"
        for _ in range(repeats):
            for name, one in ready.items():
                one.use_cores(case.cores)
                time.sleep(PAUSE_SECONDS)
                one.call()
                rates.setdefault(name, []).append(one.pictures / seconds_per_call(one.call, seconds))
    return {name: _summary(ready[name].pictures, values) for name, values in rates.items()}, failed


def seconds_per_call(call: Callable[[], object], at_least: float) -> float:
    """Mean of as many calls as fill `at_least` seconds."""
    calls, start = 0, time.perf_counter()
    while True:
        call()
        calls += 1
        passed = time.perf_counter() - start
        if passed >= at_least:
            return passed / calls


def _prepared(contender: Contender, scene: Scene, case: Case, running: ExitStack) -> Ready:
    """Draws a few pictures first, to compile what is compiled and to learn how many make a call of bearable length."""
    use_cores = contender.use_cores
    use_cores(case.cores)
    few = contender.prepare(scene.part(0, case.cores))
    try_out = few.forward if case.mode == "forward" else few.step
    try_out()
    affordable = int(LONGEST_CALL_SECONDS / seconds_per_call(try_out, 0.0)) * case.cores
    pictures = max(case.cores, min(scene.count, affordable) // case.cores * case.cores)
    part = scene.part(0, pictures)
    if contender.second_core == "processes" and case.cores > 1:
        renderer = running.enter_context(in_processes(contender, part, case.cores))
    else:
        renderer = contender.prepare(part)

    def call() -> None:
        if case.mode == "forward":
            renderer.forward()
        else:
            renderer.step()

    call()
    return Ready(call, pictures, use_cores)


def _summary(pictures: int, values: list[float]) -> Rates:
    return Rates(pictures, statistics.median(values), min(values), max(values), tuple(values))


def ratio(above: Rates, below: Rates) -> float:
    """Median of the ratios of neighbouring repeats."""
    return statistics.median(a / b for a, b in zip(above.repeats, below.repeats, strict=True))
