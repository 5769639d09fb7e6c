"""A bundle's two graphs as they are served: one picture after the other, in one thread.

This module needs neither torch nor the trainer, so that a process of its own (`python -m trainer.frontier.answering
BUNDLE`, which prints its peak in bytes) takes the memory of answering, and no more.
"""

import json
import resource
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import onnxruntime

# A turn of one bundle lasts so long at least; then it is the next one's.
_TURN_SECONDS = 0.05
_PICTURES = 20


class Answerer:
    """The graphs of a bundle, and a picture of its size."""

    def __init__(self, bundle: Path) -> None:
        picture = json.loads((bundle / "manifest.json").read_text(encoding="utf-8"))["picture"]
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        options.log_severity_level = 3
        self._encoder, self._decoder = (
            onnxruntime.InferenceSession(str(bundle / f"{name}.onnx"), options, providers=["CPUExecutionProvider"])
            for name in ("encoder", "decoder")
        )
        shape = (1, 3, picture["height"], picture["width"])
        self._picture = np.random.default_rng(0).random(shape, dtype=np.float32)
        self._entrances = self._encoder.get_inputs()[0].name, self._decoder.get_inputs()[0].name

    def answer(self) -> Any:
        """From the picture to vertices."""
        encoder, decoder = self._entrances
        shape_code = self._encoder.run(["shape_mean"], {encoder: self._picture})[0]
        return self._decoder.run(["vertices"], {decoder: shape_code})[0]


def latencies_ms(bundles: Mapping[str, Path], turns: int) -> dict[str, float]:
    """The median time of an answer of each bundle, milliseconds: all are loaded, and take turns."""
    answerers = {name: Answerer(bundle) for name, bundle in bundles.items()}
    times: dict[str, list[float]] = {name: [] for name in answerers}
    for _ in range(turns):
        for name, answerer in answerers.items():
            # The first one finds the caches full of another bundle.
            answerer.answer()
            times[name] += _times(answerer)
    return {name: 1e3 * median(values) for name, values in times.items()}


def _times(answerer: Answerer) -> list[float]:
    found = []
    end = time.perf_counter() + _TURN_SECONDS
    while (start := time.perf_counter()) < end:
        answerer.answer()
        found.append(time.perf_counter() - start)
    return found


def peak_bytes() -> int:
    """The largest resident set that this process has had."""
    status = Path("/proc/self/status")
    if status.exists():
        # Since the program was started; getrusage would also count the process that started it.
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def main(arguments: Sequence[str]) -> None:
    answerer = Answerer(Path(arguments[0]))
    for _ in range(_PICTURES):
        answerer.answer()
    print(peak_bytes())


if __name__ == "__main__":
    main(sys.argv[1:])
