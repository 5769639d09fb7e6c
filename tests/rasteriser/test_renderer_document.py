"""docs/renderer.md says what the committed figures say."""

import json
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "renderer.md").read_text()
EDGES = json.loads((DOCS / "results" / "renderer-edges.json").read_text())["kinds"]


@pytest.mark.parametrize("kind", EDGES)
def test_how_true_the_pictures_are(kind: str) -> None:
    table = TEXT.split("\n## How true the pictures are\n")[1].split("\n## ")[0]
    told = re.search(rf"^\| {re.escape(kind)} \| (.*) \|$", table, re.M)
    assert told, f"expected a row about {kind}"
    exact = EDGES[kind][0]
    figures = [f"{row['edge']:.2f}" for row in EDGES[kind]]
    assert told[1].split(" | ") == [*figures, f"{exact['largest']:.1f}", f"{exact['inside']:.2f}"]
