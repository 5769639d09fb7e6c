"""A selection's figures as JSON and as a page."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.trainer.selection.test_choice import CANDIDATES, HARD, LARGE, MIDDLE, SMALL, SMALLEST, WOBBLE, record
from trainer.config import SceneConfig
from trainer.presets import load_preset
from trainer.selection.choice import choose
from trainer.selection.halving import Budget, Rung
from trainer.selection.page import as_json, as_markdown, conditions, table_lines
from trainer.selection.record import Mean, Record, mean_of, told
from trainer.selection.selection import Selection
from trainer.selection.size import size_of

BUDGET = Budget(500, 600.0, 2)
SELECTION = Selection(
    Path("out"), Path("pictures"), SceneConfig(), "car", load_preset("fast"), tuple(CANDIDATES), BUDGET, samples=4
)


def found() -> dict[str, Any]:
    """Of four, one fails, one is dropped, and of the other two the smaller is within its standard error."""
    first = {LARGE: record(HARD), SMALL: record(HARD - 0.5), SMALLEST: record(HARD - 3.0)}
    failed = Record(250, 0.0, 0.0, problem="no finite gradients")
    rungs = [
        Rung(250, {**first, MIDDLE: failed}, (LARGE, SMALL)),
        Rung(500, {LARGE: record(HARD + 1.0), SMALL: record(HARD + 0.9 + WOBBLE)}, (LARGE, SMALL)),
    ]
    sizes = {candidate: size_of(SELECTION.config(candidate)) for candidate in CANDIDATES}
    return as_json(SELECTION, sizes, rungs, choose(rungs, sizes), (90, 8), Mean(-200.0, 10.0))


def test_the_json_says_all_and_is_json() -> None:
    figures = found()
    assert json.loads(json.dumps(figures, allow_nan=False)) == figures
    assert figures["chosen"] == SMALL.name
    assert figures["best"] == LARGE.name
    candidates = {candidate["name"]: candidate for candidate in figures["candidates"]}
    assert list(candidates) == [LARGE.name, SMALL.name, SMALLEST.name, MIDDLE.name]
    assert [candidate["verdict"] for candidate in candidates.values()] == ["best", "chosen", "dropped", "failed"]
    assert [len(candidate["rungs"]) for candidate in candidates.values()] == [2, 2, 1, 0]
    small = candidates[SMALL.name]
    error = float(np.std(WOBBLE, ddof=1) / np.sqrt(8))
    assert small["behind_the_best"] == pytest.approx({"value": 0.1, "standard_error": error})
    assert candidates[MIDDLE.name]["behind_the_best"] is None


def test_the_page_is_read_off_the_json() -> None:
    page = as_markdown(found())
    assert f"Chosen: **{SMALL.name}**. 90 pictures to train on, 8 pictures of 8 other objects held out; 48 × 36" in page
    assert "10 minutes of a core in all. Trained: 4 to step 250, 2 to step 500." in page
    assert "would have -200.00 ± 10.00." in page
    lines = table_lines(found())
    assert len(lines) == 2 + 4
    assert all(line.count("|") == 9 for line in lines)
    assert f"| **{SMALL.name}** |" in lines[3]
    bound = told(mean_of(HARD + 0.9 + WOBBLE))
    assert f"| 500 | {bound} | 0.10 ± 0.38 | 0.0 | the smallest of those within a standard error" in lines[3]
    assert lines[5].endswith("| – | – | – | – | failed on the way to step 250: no finite gradients |")


def test_the_page_says_when_the_time_told_nothing() -> None:
    figures = found()
    assert "too short" not in conditions(figures)
    for rung in figures["rungs"]:
        rung["step"] = 25
    assert "it was gone when 4 candidates had made the 25 steps that tell their pace" in conditions(figures)
    assert "too short" not in conditions({**figures, "budget": {**figures["budget"], "seconds": None}})
