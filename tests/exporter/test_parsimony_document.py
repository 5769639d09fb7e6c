"""docs/parsimony.md says what docs/results/parsimony.json says, of every model that ships."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from benchmarks.parsimony import LITTLE_NATS
from benchmarks.parsimony_page import carries_table, precision_table, write_tables
from exporter.assembly import LEAST_PICTURES
from exporter.slimming import LARGEST_CHANGE
from service.exposure import LEAST_AREA
from service.generation import LARGEST_NUMBER

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "parsimony.md"
REPORT: dict[str, Any] = json.loads((ROOT / "docs" / "results" / "parsimony.json").read_text())
MODELS: dict[str, Any] = REPORT["models"]


def words() -> str:
    """The page's text in one line, without its tables."""
    lines = PAGE.read_text().splitlines()
    return " ".join(" ".join(line for line in lines if not line.startswith("|")).split())


def test_the_tables_are_those_of_the_figures(tmp_path: Path) -> None:
    text = PAGE.read_text()
    for table in (carries_table(REPORT), precision_table(REPORT)):
        assert "\n".join(table) in text
    copy = tmp_path / "page.md"
    copy.write_text(re.sub(r"^\|.*\n", "", text, flags=re.MULTILINE))
    write_tables(REPORT, copy)
    assert copy.read_text() == text


def test_every_model_that_ships_is_there() -> None:
    assert set(MODELS) == {path.parent.name for path in (ROOT / "models").glob("*/manifest.json")}


def bytes_as_shipped(name: str) -> int:
    manifest = json.loads((ROOT / "models" / name / "manifest.json").read_text())
    precision = manifest["precision"]["encoder"] if manifest["precision"] else "float32"
    return int(MODELS[name]["precisions"][precision]["bytes"])


@pytest.mark.parametrize("name", sorted(MODELS))
def test_the_bytes_are_those_of_the_bundle(name: str) -> None:
    bundle = ROOT / "models" / name
    weights = sum((bundle / file).stat().st_size for file in ("encoder.onnx", "decoder.onnx"))
    told = bytes_as_shipped(name)
    # Manifest and probe are the rest; the manifest may have been written anew.
    assert weights < told
    assert abs(told - sum(file.stat().st_size for file in bundle.iterdir())) < 20_000


def test_what_the_page_says_of_all_models() -> None:
    text = words()
    nothing_goes = all(
        model["carries"]["numbers"] == model["carries"]["numbers_that_move"]
        and model["carries"]["blocks"] == model["carries"]["blocks_that_show"]
        for model in MODELS.values()
    )
    assert nothing_goes == ("**In the models that ship, that is nothing.**" in text)
    shares = [
        100 * (ROOT / "models" / name / "encoder.onnx").stat().st_size / bytes_as_shipped(name) for name in MODELS
    ]
    assert f"{sum(shares) / len(shares):.0f} % of a bundle are the encoder's weights" in text


def test_what_the_page_says_of_limits() -> None:
    text = words()
    assert f"for it, −{LARGEST_NUMBER:g} to {LARGEST_NUMBER:g}, moves" in text
    assert LARGEST_CHANGE == 1e-4
    assert "more than 1e-4 diagonals" in text
    assert LEAST_AREA == 1 / 32**2
    assert "1/32² square diagonals" in text
    assert f"less than {LITTLE_NATS:g} nats" in text
    assert f"{2 * LEAST_PICTURES} held-out pictures at least" in text
