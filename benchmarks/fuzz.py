"""Coverage-guided fuzzing of what reads anybody's bytes: pictures, and the four files of a bundle.

`python -m benchmarks.fuzz --executions 1000000` goes on from the corpus that earlier runs left, and adds to their
report. A fault (an exception that the reader does not document, a crash, too long, too much memory) is kept as
the file that causes it.
"""

import datetime
import importlib.metadata
import json
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tyro
from rich.console import Console

from benchmarks.fuzz_targets import NAMES, Name, seeds_of
from benchmarks.machine import machine, versions

PACKAGES = ("atheris", "pillow", "onnxruntime", "pydantic")
SHARES: dict[Name, float] = {
    "pictures": 0.5,
    "manifests": 0.4,
    "probes": 0.08,
    "encoders": 0.01,
    "decoders": 0.01,
}
"""Of the executions; graphs take longest, and onnxruntime reads them."""
LONGEST_SECONDS = 86_400.0
MOST_FAULTS = 10
"""After so many in one run a target is left: they are probably all the same."""


@dataclass(frozen=True)
class Options:
    """Options of fuzzing."""

    targets: tyro.conf.Positional[tuple[Name, ...]] = NAMES
    """What is fuzzed."""
    executions: int = 100_000
    """Files that are read, all targets together."""
    output: Path = Path("docs/results/fuzz.json")
    """The report."""
    corpus: Path = Path("out/fuzz")
    """Folder of what was found to take new ways through the code, and of faults."""
    largest: int = 8192
    """Bytes of the largest file."""
    file_seconds: int = 10
    """How long one file may take."""
    seconds: float = float("inf")
    """How long each target is fuzzed at most."""
    mebibytes: int = 4096
    """How much address space the process may have, all its libraries included."""


@dataclass(frozen=True)
class Portion:
    """What one process did."""

    executions: int
    coverage_before: int
    """Branches that the corpus took."""
    coverage: int
    corpus: int
    """Files that each take some way of their own."""
    fault: str | None
    """The sentence of what ended it early."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.fuzz", description=__doc__)
    console = Console(stderr=True)
    report = json.loads(options.output.read_text()) if options.output.exists() else {"targets": {}}
    shares = sum(SHARES[name] for name in options.targets)
    for name in options.targets:
        known = report["targets"].get(name)
        executions = round(options.executions * SHARES[name] / shares)
        found = fuzz(name, options, executions, known["executions"] if known else 0, console)
        report["targets"][name] = added(known, found) if known else found
    totals = list(report["targets"].values())
    report = {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": {**versions(), **{name: importlib.metadata.version(name) for name in PACKAGES}},
        "command": "python -m benchmarks.fuzz --executions …",
        "limits": {"bytes": options.largest, "seconds": options.file_seconds, "mebibytes": options.mebibytes},
        "executions": sum(one["executions"] for one in totals),
        "seconds": round(sum(one["seconds"] for one in totals), 1),
        "faults": sum(len(one["faults"]) for one in totals),
        "targets": report["targets"],
    }
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    console.print(f"written: {options.output}; corpus and faults: {options.corpus}")


def fuzz(name: Name, options: Options, most: int, seed: int, console: Console) -> dict[str, Any]:
    """As many executions of a target, in a process anew after each fault."""
    corpus, faults = options.corpus / name, options.corpus / f"{name}-faults"
    for folder in (corpus, faults):
        folder.mkdir(parents=True, exist_ok=True)
    for file, content in seeds_of(name).items():
        (corpus / file).write_bytes(content)
    began, portions = time.perf_counter(), []
    executions, seconds = 0, 0.0
    while executions < most and seconds < options.seconds and _faults(portions) < MOST_FAULTS:
        left = min(options.seconds - seconds, LONGEST_SECONDS)
        portion = run(name, options, corpus, faults, most - executions, left, seed + executions + 1)
        portions.append(portion)
        executions, seconds = executions + portion.executions, time.perf_counter() - began
        console.print(f"{name}: {portion}")
    return {
        "executions": executions,
        "seconds": round(seconds, 1),
        "per_second": round(executions / seconds, 1),
        "coverage_of_seeds": portions[0].coverage_before,
        "coverage": portions[-1].coverage,
        "corpus": portions[-1].corpus,
        "faults": [portion.fault for portion in portions if portion.fault is not None],
    }


def _faults(portions: list[Portion]) -> int:
    return sum(portion.fault is not None for portion in portions)


def added(known: dict[str, Any], found: dict[str, Any]) -> dict[str, Any]:
    """The figures of a target over all its runs."""
    executions, seconds = known["executions"] + found["executions"], known["seconds"] + found["seconds"]
    return {
        **found,
        "executions": executions,
        "seconds": round(seconds, 1),
        "per_second": round(executions / seconds, 1),
        "coverage_of_seeds": known["coverage_of_seeds"],
        "faults": known["faults"] + found["faults"],
    }


def run(
    name: Name, options: Options, corpus: Path, faults: Path, executions: int, seconds: float, seed: int
) -> Portion:
    """One process, until it has done as many executions, or met a fault, or worked that long."""
    # In memory, where there is such a folder: the files of a bundle are written anew each time.
    memory = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with TemporaryDirectory(prefix="chiaro-fuzz-", dir=memory) as folder:
        command = [sys.executable, "-m", "benchmarks.fuzz_worker", name, folder, str(options.mebibytes)]
        limits = [
            f"-max_len={options.largest}",
            f"-timeout={options.file_seconds}",
            f"-rss_limit_mb={options.mebibytes}",
        ]
        ends = [f"-runs={executions}", f"-max_total_time={max(1, int(seconds))}", "-print_final_stats=1"]
        ways = [*ends, f"-artifact_prefix={faults}/", f"-seed={seed}"]
        ended = subprocess.run(
            [*command, *limits, *ways, str(corpus)], check=False, capture_output=True, text=True, errors="replace"
        )
    return portion_of(ended.stderr + ended.stdout, ended.returncode)


def portion_of(log: str, status: int) -> Portion:
    """What libFuzzer's log says.

    Raises:
        RuntimeError: it did not get as far as its corpus.
    """
    states = re.findall(r"^#(\d+)\s+(\w+)\s+cov: (\d+) ft: \d+ corp: (\d+)/", log, re.MULTILINE)
    begins = [state for state in states if state[1] == "INITED"]
    if not begins:
        raise RuntimeError(f"expected the fuzzer to begin, found that it ended with {status}: {log[-2000:]}")
    last = states[-1]
    units = re.findall(r"^stat::number_of_executed_units:\s*(\d+)", log, re.MULTILINE)
    executions = int(units[-1]) if units else int(last[0])
    return Portion(executions, int(begins[0][2]), int(last[2]), int(last[3]), _fault(log) if status else None)


def _fault(log: str) -> str:
    """The exception with the place that raised it, or libFuzzer's own summary."""
    raised = re.search(r"Uncaught Python exception: ===\n(.+(?:\n.*)*?)\n==", log)
    summary = re.search(r"^SUMMARY: (.+)$", log, re.MULTILINE)
    if raised is None:
        return summary[1] if summary else log[-300:]
    sentence, *trace = raised[1].splitlines()
    places = [line.strip() for line in trace if line.strip().startswith("File ")]
    return f"{sentence} at {places[-1]}" if places else sentence


if __name__ == "__main__":
    main()
