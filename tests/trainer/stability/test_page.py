"""docs/stability.md holds no figure that does not come from docs/results/stability.json; pages and charts."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from trainer.errors import ConfigError
from trainer.stability.page import filled, page_of, tables_of

DOCS = Path(__file__).parents[3] / "docs"
TEMPLATE = (DOCS / "stability.template.md").read_text()
RESULTS: dict[str, Any] = json.loads((DOCS / "results" / "stability.json").read_text())

# Defined and not measured: limits that the code holds, and names.
DEFINED = {"30°", "0.9", "0.99", "64", "1", "255"}


def test_no_figure_stands_in_the_text_by_itself() -> None:
    """But for what is defined, numbers come from braces, or stand in code and links."""
    text = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)|\{[^}]*\}", "", TEMPLATE, flags=re.DOTALL)
    assert set(re.findall(r"[\d.,]*\d°?", text)) <= DEFINED


def test_the_page_is_its_text_filled_with_the_committed_figures() -> None:
    assert filled(TEMPLATE, RESULTS) == (DOCS / "stability.md").read_text()


def test_every_chart_is_shown_and_there() -> None:
    shown = re.findall(r"\]\(images/(stability-[a-z-]+\.png)\)", TEMPLATE)
    assert sorted(shown) == sorted(path.name for path in (DOCS / "images").glob("stability-*.png"))
    assert len(shown) == len(set(shown))


def test_the_committed_figures_are_those_of_the_full_budget() -> None:
    assert RESULTS["budget"]["name"] == "full"
    for model in RESULTS["models"].values():
        for condition in model["conditions"].values():
            assert len(condition["points"]) == 6
            assert {name: condition["points"][0][name] for name in model["clean"]} == model["clean"]


def test_a_page_that_names_what_is_not_there_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"name figures of stability\.json, found KeyError: 'nobody'"):
        filled("{models[nobody][clean][iou]}", RESULTS)


def test_a_page_of_one_s_own_has_all_tables_and_charts() -> None:
    page = page_of(RESULTS, ["stability-iou.png"])
    for name, table in tables_of(RESULTS).items():
        assert f"## {name.replace('_', ', ')}\n\n{table}\n" in page
    assert "![stability-iou.png](stability-iou.png)" in page


def test_all_charts_are_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="comes with the extra bench")
    from trainer.stability.charts import write_charts  # noqa: PLC0415

    files = write_charts(RESULTS, tmp_path)
    assert sorted(path.name for path in files) == sorted(
        path.name for path in (DOCS / "images").glob("stability-*.png")
    )
    assert all(path.stat().st_size > 10_000 for path in files)
    assert write_charts({"models": {}, "trainings": {}, "rasteriser": {}}, tmp_path) == []
