"""docs/renderer.md says what the committed figures say."""

import json
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "renderer.md").read_text()
COSTS = json.loads((DOCS.parent / "benchmarks" / "render.json").read_text())["cases"]
EDGES = json.loads((DOCS / "results" / "renderer-edges.json").read_text())["kinds"]


@pytest.mark.parametrize("kind", EDGES)
def test_how_true_the_pictures_are(kind: str) -> None:
    table = TEXT.split("\n## How true the pictures are\n")[1].split("\n## ")[0]
    told = re.search(rf"^\| {re.escape(kind)} \| (.*) \|$", table, re.M)
    assert told, f"expected a row about {kind}"
    exact = EDGES[kind][0]
    figures = [f"{row['edge']:.2f}" for row in EDGES[kind]]
    assert told[1].split(" | ") == [*figures, f"{exact['largest']:.1f}", f"{exact['inside']:.2f}"]


def test_what_it_costs() -> None:
    table = TEXT.split("\n## What it costs\n")[1]
    told = [line.strip("| ").split(" | ") for line in re.findall(r"^\| [\d,]+ \|.*$", table, re.M)]
    names = [
        "chiaro fused likelihood",
        "chiaro kernels",
        "chiaro torch",
        "chiaro composed likelihood",
        "chiaro kernels, exact",
        "DEODR core, silhouettes given",
        "DEODR core",
        "DEODR torch",
        "Mitsuba 3",
    ]
    cases = [case for case in COSTS if case["mode"] == "forward+backward" and case["cores"] == 2]
    assert told == [
        [f"{case['faces']:,}", f"{case['width']} × {case['height']}"]
        + [f"{round(case['pictures_per_second'][name]['median']):,}" for name in names]
        for case in cases
    ]
