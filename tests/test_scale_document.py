"""docs/scale.md says what the committed figures say."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "scale.md").read_text()
TRAININGS = json.loads((ROOT / "benchmarks" / "training.json").read_text())["trainings"]
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
