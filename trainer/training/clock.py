"""How long a training took, through all its interruptions: by the clock on the wall, and by what its cores computed."""

import time
from collections.abc import Mapping
from typing import Any


class Clock:
    """Starts at once, from where `run`, what a checkpoint says of its training, left off."""

    def __init__(self, run: Mapping[str, Any]) -> None:
        self.seconds_before: float = run.get("seconds", 0.0)
        self._core_seconds_before: float = run.get("core_seconds", 0.0)
        self._began, self._began_computing = time.monotonic(), time.process_time()

    def told(self) -> dict[str, float]:
        """Seconds, and core seconds, until now: on a busy machine the second tell more."""
        seconds = self.seconds_before + time.monotonic() - self._began
        core_seconds = self._core_seconds_before + time.process_time() - self._began_computing
        return {"seconds": round(seconds, 2), "core_seconds": round(core_seconds, 2)}
