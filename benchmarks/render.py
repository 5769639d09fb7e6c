"""The renderer beside its peers: the same mesh, camera, colours and loss, in turn on the same machine.

`python -m benchmarks.render` writes render.json (every figure, all repeats), render.png (the charts) and, for each
peer, a comparison of its pictures with ours.
"""

import datetime
import json
import shlex
import sys
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numba
import numpy as np
import tyro
from rich.console import Console

from benchmarks.agreement import compare, compare_likelihoods
from benchmarks.charts import write_charts
from benchmarks.contender import Contender
from benchmarks.machine import machine, versions
from benchmarks.memory import measure_memory
from benchmarks.ours import CONTENDERS
from benchmarks.peers import find_peers
from benchmarks.scaling import measure_sweep, sweeps
from benchmarks.scene import make_scene
from benchmarks.timing import Case, Mode, Rates, measure, ratio

Part = Literal["peers", "scaling", "memory"]
MODES: tuple[Mode, ...] = ("forward", "forward+backward")
SEGMENTS_TO_PICTURES = {4: 64, 16: 64, 64: 16}
SIZES = ((64, 48), (128, 96), (256, 192))
COMPARED_PICTURES = 8


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    output: Path = Path("benchmarks")
    """Folder for render.json, render.png and the comparisons of pictures."""
    repeats: int = 7
    """Measurements of each contender on each case, taken in turn with the others'."""
    seconds: float = 0.25
    """Shortest measurement, seconds."""
    cores: tuple[int, ...] = (1, 2)
    """Numbers of threads, or of processes for renderers without threads."""
    parts: tuple[Part, ...] = ("peers", "scaling", "memory")
    """What to measure."""
    quick: bool = False
    """Two meshes, two picture sizes, a quarter of the pictures, three short repeats: to see that all works."""
    seed: int = 0
    """Of poses and target pictures."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.render", description=__doc__)
    if options.quick:
        options = replace(options, repeats=3, seconds=0.02)
    console = Console(stderr=True)
    most = numba.config.NUMBA_NUM_THREADS
    if max(options.cores) > most:
        console.print(f"expected {most} cores at most, found {max(options.cores)}; measuring without the others")
        options = replace(options, cores=tuple(cores for cores in options.cores if cores <= most))
    options.output.mkdir(parents=True, exist_ok=True)
    peers, absent = find_peers()
    for name, reason in absent.items():
        console.print(f"without {name}: {reason}")
    report: dict[str, Any] = {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": versions(),
        "command": shlex.join(["python", "-m", "benchmarks.render", *sys.argv[1:]]),
        "repeats": options.repeats,
        "seconds_per_repeat": options.seconds,
        "contenders": {
            one.name: {"what": one.what, "loss": one.work, "second_core": one.second_core, "ours": one.ours}
            for one in (*CONTENDERS, *peers)
        },
        "absent": absent,
    }
    if "peers" in options.parts:
        report["agreement"] = agreement(peers, options)
        report["cases"] = []
        for case in cases(options):
            report["cases"].append(result := measured(case, [*CONTENDERS, *peers], options))
            console.print(_line(result))
    if "scaling" in options.parts:
        report["scaling"] = {
            sweep.quantity: [
                point
                for cores in options.cores
                for point in measure_sweep(sweep, cores, options.repeats, options.seconds, options.seed)
            ]
            for sweep in sweeps(options.quick)
        }
    if "memory" in options.parts:
        report["memory"] = measure_memory(options.quick, options.seed)
    (options.output / "render.json").write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    write_charts(report, options.output / "render.png")
    console.print(f"written: {options.output / 'render.json'}, {options.output / 'render.png'}")


def agreement(peers: list[Contender], options: Options) -> dict[str, Any]:
    """Of every peer's pictures and gradients with ours, and of our two likelihoods; at 192 faces, 128 × 96 pixels."""
    found: dict[str, Any] = {}
    for peer in peers:
        scene = make_scene(4, 128, 96, COMPARED_PICTURES, np.random.default_rng(options.seed))
        try:
            found[peer.name] = compare(peer, scene, options.output / "comparisons")
        # A peer may fail as it likes; the others are still measured.
        except Exception as error:
            found[peer.name] = {"failed": f"{type(error).__name__}: {error}"}
    scene = make_scene(4, 128, 96, COMPARED_PICTURES, np.random.default_rng(options.seed))
    found["chiaro fused likelihood against composed"] = compare_likelihoods(scene)
    return found


def cases(options: Options) -> list[Case]:
    segments, sizes = list(SEGMENTS_TO_PICTURES), list(SIZES)
    if options.quick:
        segments, sizes = segments[:2], sizes[:2]
    return [
        Case(segment, *size, mode, cores)
        for segment, size, mode, cores in product(segments, sizes, MODES, options.cores)
    ]


def measured(case: Case, contenders: list[Contender], options: Options) -> dict[str, Any]:
    """Rates of all contenders, the fastest peer, and every contender's rate as a multiple of the peers'."""
    pictures = SEGMENTS_TO_PICTURES[case.segments] // (4 if options.quick else 1)
    scene = make_scene(case.segments, case.width, case.height, pictures, np.random.default_rng(options.seed))
    rates, failed = measure(contenders, scene, case, options.repeats, options.seconds)
    ours = [one.name for one in contenders if one.ours and one.name in rates]
    peers = {one.name: rates[one.name] for one in contenders if not one.ours and one.name in rates}
    fastest = max(peers, key=lambda name: peers[name].median, default=None)
    return {
        **case.described(),
        "pictures_per_second": {name: asdict(value) for name, value in rates.items()},
        "failed": failed,
        "fastest_peer": fastest,
        "times_as_fast_as_fastest_peer": {} if fastest is None else _multiples(rates, rates[fastest]),
        "times_as_fast_as": {peer: {name: ratio(rates[name], peers[peer]) for name in ours} for peer in peers},
    }


def _multiples(rates: dict[str, Rates], other: Rates) -> dict[str, float]:
    return {name: ratio(value, other) for name, value in rates.items()}


def _line(result: dict[str, Any]) -> str:
    rates = ", ".join(f"{name} {value['median']:.0f}" for name, value in result["pictures_per_second"].items())
    size = f"{result['width']}×{result['height']}"
    return f"{result['faces']} faces, {size}, {result['mode']}, {result['cores']} cores, pictures/s: {rates}"


if __name__ == "__main__":
    main()
