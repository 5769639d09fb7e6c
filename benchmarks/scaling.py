"""How our own cost grows with pictures, pixels and faces."""

import statistics
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.ours import FUSED, KERNELS, use_cores
from benchmarks.scene import make_scene
from benchmarks.timing import PAUSE_SECONDS, seconds_per_call

CONTENDERS = (KERNELS, FUSED)


@dataclass(frozen=True)
class Sweep:
    """One quantity grows, the others stay."""

    quantity: str
    sizes: tuple[tuple[int, int, int, int], ...]
    """Segments, width, height, pictures."""


def sweeps(quick: bool) -> tuple[Sweep, ...]:
    every = slice(None, None, 2 if quick else 1)
    return (
        Sweep("pictures", tuple((4, 128, 96, 2**power) for power in range(9))[every]),
        Sweep("pixels", tuple((4, 32 * scale, 24 * scale, 32) for scale in (1, 2, 3, 4, 6, 8, 12, 16))[every]),
        Sweep("faces", tuple((segments, 128, 96, 16) for segments in (2, 4, 8, 16, 32, 64))[every]),
    )


def measure_sweep(sweep: Sweep, cores: int, repeats: int, seconds: float, seed: int) -> list[dict[str, Any]]:
    """Forward and backward: milliseconds per call by size and contender, the sizes taken in turn."""
    use_cores(cores)
    points = []
    for segments, width, height, pictures in sweep.sizes:
        scene = make_scene(segments, width, height, pictures, np.random.default_rng(seed))
        points.append({contender.name: contender.prepare(scene) for contender in CONTENDERS})
    for point in points:
        for renderer in point.values():
            renderer.step()
    times: list[dict[str, list[float]]] = [{name: [] for name in point} for point in points]
    for _ in range(repeats):
        for point, taken in zip(points, times, strict=True):
            for name, renderer in point.items():
                time.sleep(PAUSE_SECONDS)
                renderer.step()
                taken[name].append(1e3 * seconds_per_call(renderer.step, seconds))
    return [
        {
            "faces": 12 * segments**2,
            "width": width,
            "height": height,
            "pixels": width * height,
            "pictures": pictures,
            "cores": cores,
            "milliseconds_per_call": {
                name: {"median": statistics.median(values), "lowest": min(values), "highest": max(values)}
                for name, values in taken.items()
            },
        }
        for (segments, width, height, pictures), taken in zip(sweep.sizes, times, strict=True)
    ]
