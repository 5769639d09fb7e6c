"""docs/scale.md says what the committed figures say."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "scale.md").read_text()
TRAININGS = json.loads((ROOT / "benchmarks" / "training.json").read_text())["trainings"]
GPU = json.loads((ROOT / "docs" / "results" / "gpu.json").read_text())
STREAM = json.loads((ROOT / "docs" / "results" / "scale.json").read_text())["streaming"]


def training(preset: str, processes: int, threads: int) -> dict[str, Any]:
    wanted = {"preset": preset, "device": "cpu", "processes": processes, "threads": threads}
    (found,) = [one for one in TRAININGS if wanted.items() <= one.items()]
    return dict(found)


@pytest.mark.parametrize("preset", dict.fromkeys(one["preset"] for one in TRAININGS))
def test_processes_and_threads(preset: str) -> None:
    one, two, threads = (training(preset, *way) for way in ((1, 1), (2, 1), (1, 2)))
    alone = one["pictures_per_second"]
    told = re.search(rf"^\| `{preset}` \| (.*) \|$", TEXT, re.M)
    assert told
    assert told[1].split(" | ")[1:4] == [
        f"{alone:.0f}",
        *(f"{one['pictures_per_second']:.0f} ({one['pictures_per_second'] / alone:.2f} ×)" for one in (two, threads)),
    ]
    assert told[1].split(" | ")[4].split()[0] == f"{threads['share_of_the_networks_at_that']:.2f}"


def test_memory_stays_flat_over_a_hundred_thousand_pictures() -> None:
    first, *later = STREAM["resident_mib_at_each_twentieth"]
    assert STREAM["pictures"] >= 100_000
    said = re.sub(r"\s+", " ", TEXT)
    assert f"{first:.0f} MiB after the first twentieth, and between {min(later):.0f} and {max(later):.0f} MiB" in said
    assert f"{STREAM['pictures_per_second']:,.0f} pictures a second" in said


def test_trainings_on_a_gpu() -> None:
    trainings, said = GPU["trainings"], re.sub(r"\s+", " ", TEXT)
    by_itself = trainings["by_itself"]
    assert (
        f"| each kernel launched | {by_itself['seconds_of_1500_steps']:.1f} s | {by_itself['seconds']:.1f} s | |"
        in TEXT
    )
    rows = re.findall(r"^\| recorded.* \| (\S+) s \| (\S+) s \| (\S+) \|$", TEXT, re.M)
    assert rows == [
        (f"{one['seconds_of_1500_steps']:.1f}", f"{one['seconds']:.1f}", f"{one['validation']['iou']:.3f}")
        for one in trainings["recorded"]
    ]
    assert f"of one CPU core | | | {trainings['ships']['validation']['iou']:.3f} |" in TEXT
    first, second = zip(*(trainings["same_seed_twice"][step] for step in ("20", "1500")), strict=True)
    assert f"losses of {first[0]:.1f} and {second[0]:.1f} after 20 steps, of {first[1]:.1f} and {second[1]:.1f}" in said


def test_steps_on_a_gpu() -> None:
    step, said = GPU["step"], re.sub(r"\s+", " ", TEXT)
    milliseconds, kernels = step["median_milliseconds"], step["milliseconds_of_kernels"]
    assert f"A step takes {milliseconds:.1f} ms" in said
    assert f"({round(64e3 / milliseconds, -2):,.0f} pictures a second)" in said
    assert f"of which {kernels:.1f} ms are kernels" in said
    assert round(step["kernels"], -2) == 1300
    assert round(1000 * kernels / step["kernels"]) == 4
    paper = [one for one in GPU["benchmark"]["trainings"] if one["preset"] == "paper"]
    anew, recorded = (f"{one['pictures_per_second']:,.0f}" for one in sorted(paper, key=lambda one: one["recorded"]))
    assert f"{recorded} pictures a second instead of {anew}" in said
    assert f"is {step['paper']['milliseconds_of_kernels']:.0f} ms of kernels" in said
    assert f"{GPU['tests']['passed']} tests" in said
