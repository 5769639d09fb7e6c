"""What one more picture costs in memory: growth of the resident set while a batch is drawn and differentiated."""

import ctypes
import gc
import multiprocessing
import resource
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ours import COMPOSED, FUSED, use_cores
from benchmarks.scene import make_scene

SEGMENTS, WIDTH, HEIGHT = 4, 128, 96
CONTENDERS = {contender.name: contender for contender in (FUSED, COMPOSED)}
# What the fused path adds per picture shows only where there are many.
BATCHES = {FUSED.name: (128, 256, 512, 1024, 2048), COMPOSED.name: (16, 32, 64, 128, 256)}


def measure_memory(quick: bool, seed: int) -> dict[str, Any]:
    """Peak growth in bytes by contender and batch, each in a process of its own, and its slope per picture."""
    figures: dict[str, Any] = {"faces": 12 * SEGMENTS**2, "width": WIDTH, "height": HEIGHT, "contenders": {}}
    for name in CONTENDERS:
        points = [_in_own_process(name, count, seed) for count in BATCHES[name][:: 2 if quick else 1]]
        counts, growth = zip(*((point["pictures"], point["growth_bytes"]) for point in points), strict=True)
        figures["contenders"][name] = {
            "points": points,
            "growth_bytes_per_picture": float(np.polyfit(counts, growth, 1)[0]),
            "gradients_bytes_per_picture": points[-1]["gradients_bytes"] / counts[-1],
            "picture_bytes": 3 * WIDTH * HEIGHT * 4,
        }
    return figures


def _in_own_process(name: str, count: int, seed: int) -> dict[str, int]:
    spawn = multiprocessing.get_context("spawn")
    here, there = spawn.Pipe(duplex=False)
    worker = spawn.Process(target=_grow, args=(there, name, count, seed))
    worker.start()
    there.close()
    try:
        point: dict[str, int] = here.recv()
    except EOFError as error:
        raise ChildProcessError(f"expected the memory that {name} takes for {count} pictures, found none") from error
    finally:
        worker.join()
    return point


def _grow(line: Connection, name: str, count: int, seed: int) -> None:
    use_cores(1)
    scene = make_scene(SEGMENTS, WIDTH, HEIGHT, count, np.random.default_rng(seed))
    contender = CONTENDERS[name]
    contender.prepare(scene.part(0, 2)).step()
    renderer = contender.prepare(scene)
    _give_back_freed()
    before = _resident_bytes()
    _forget_peak()
    gradients = renderer.step()
    line.send(
        {
            "pictures": count,
            "growth_bytes": max(_peak_bytes() - before, 0),
            "gradients_bytes": gradients.positions.nbytes + gradients.colours.nbytes,
        }
    )


def _give_back_freed() -> None:
    """So that what was freed before cannot be used again unseen; where the C library knows how (glibc)."""
    gc.collect()
    library = ctypes.CDLL(None)
    if hasattr(library, "malloc_trim"):
        library.malloc_trim(0)


def _forget_peak() -> None:
    """Linux only: elsewhere, the peak is that of the process's whole life."""
    clear = Path("/proc/self/clear_refs")
    if clear.exists():
        clear.write_text("5")


def _resident_bytes() -> int:
    statm = Path("/proc/self/statm")
    if statm.exists():
        return int(statm.read_text().split()[1]) * resource.getpagesize()
    return _peak_bytes()


def _peak_bytes() -> int:
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
