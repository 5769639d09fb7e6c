"""Whether other programs want the cores that a training's threads compute on.

All threads of a step wait for the last of them. Where another program keeps one from its core, a step may take ten
times as long, and fewer threads are then faster (docs/decisions.md, *A training's threads wait asleep*).
"""

import time
from collections.abc import Callable
from pathlib import Path

import torch

_SECONDS = 20.0
"""So long is looked before something is said."""
_SHARE = 0.25
"""Of the time that a thread is kept from its core, from which on something is said. Two threads on two cores have 0.01
by themselves, and 0.47 beside one busy program (docs/results/contention.json)."""
_TASKS = Path("/proc/self/task")


def seconds_without_core() -> dict[str, float]:
    """How long each of this process's threads has been ready to run and was not let, as Linux counts it; empty
    elsewhere."""
    waited = {}
    for task in _TASKS.glob("*/schedstat"):
        try:
            waited[task.parent.name] = int(task.read_text().split()[1]) * 1e-9
        except (OSError, IndexError):
            continue  # The thread has just ended, or nothing is counted.
    return waited


class Contention:
    """Looks on while a training goes on, and says once that cores are wanted."""

    def __init__(
        self,
        waits: Callable[[], dict[str, float]] = seconds_without_core,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._waits, self._clock = waits, clock
        self._since, self._before = clock(), waits()
        self._said = False

    def told(self) -> str | None:
        """To be called now and then: a sentence for the user, where a thread was kept from its core for a quarter
        of the last 20 seconds or more, and fewer threads could go on; afterwards nothing more."""
        now, threads = self._clock(), torch.get_num_threads()
        if self._said or threads == 1 or now - self._since < _SECONDS:
            return None
        waits = self._waits()
        longest = max((waits[thread] - self._before.get(thread, 0.0) for thread in waits), default=0.0)
        share = longest / (now - self._since)
        self._since, self._before = now, waits
        if share < _SHARE:
            return None
        self._said = True
        return (
            f"other programs want the cores: one of {threads} threads waited {100 * share:.0f} % of the time, "
            f"and all wait for it; fewer may be faster (Ctrl-C, then --resume with --threads {threads - 1})"
        )
