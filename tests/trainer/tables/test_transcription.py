"""The figures of `trainer/tables/*.toml` are those of the paper's LaTeX source, and its tables agree."""

import re
from pathlib import Path

import pytest

from trainer.data.shapes.catalogue import CATEGORIES
from trainer.tables.setting import setting_for
from trainer.tables.table import Table, load_table, table_names

PAPER = Path(__file__).parents[4] / "shared/paper.tex"
TABLES = [name for name in table_names() if name.startswith("table-")]


def figures_in_source(label: str) -> list[float]:
    """All decimal numbers in the body of the table that holds a label, in order."""
    (body,) = (part for part in re.split(r"\\begin\{table\*?\}", PAPER.read_text()) if f"\\label{{{label}}}" in part)
    body = body.partition(f"\\label{{{label}}}")[2].partition("\\end{tabular}")[0]
    rows = [line for line in body.splitlines() if "&" in line and line.rstrip().endswith("\\\\")]
    return [float(number) for row in rows for number in re.findall(r"\d+\.\d+", row)]


def figures_in_table(table: Table) -> list[float]:
    return [figure for row in table.rows for figures in row.paper.values() for figure in figures.values()]


@pytest.mark.parametrize("name", TABLES)
def test_every_figure_is_the_source_s(name: str) -> None:
    if not PAPER.exists():
        pytest.skip(f"the paper's LaTeX source is not at {PAPER}")
    table = load_table(name)
    assert figures_in_table(table) == figures_in_source(table.label)


def test_figure_9_is_one_of_the_source_s() -> None:
    if not PAPER.exists():
        pytest.skip(f"the paper's LaTeX source is not at {PAPER}")
    assert f"\\label{{{load_table('figure-9').label}}}" in PAPER.read_text()


def test_tables_that_share_a_model_share_its_figures() -> None:
    """Also says that `best` is what the paper took: Table 3's figures with coloured light are those of one of Table 2's
    parameterisations, and Tables 4 and 5 repeat them."""
    by_parameterisation = {
        row.setting.parameterisation: row.paper for row in load_table("table-2").rows if row.setting is not None
    }
    colour = load_table("table-3").row("colour")
    assert colour.setting is not None
    for category, figures in colour.paper.items():
        assert figures == by_parameterisation[setting_for(colour.setting, category).parameterisation][category]
    assert load_table("table-4").row("fixed-colour").paper == colour.paper
    assert load_table("table-4").row("fixed-white").paper == load_table("table-3").row("white").paper
    for category, figures in load_table("table-5").row("train-1-test-1").paper.items():
        assert figures == colour.paper[category]
    first = load_table("table-1").row("subdivision").paper
    for category, figures in by_parameterisation["subdivision"].items():
        assert figures == first[category]
    for row in ("white-silhouette", "white-shading", "colour-shading"):
        told = load_table("table-6").row(row).paper
        for category, figures in load_table("table-7").row(row).paper.items():
            assert figures["iou_pose_given"] == told[category]["iou_pose_given"]


@pytest.mark.parametrize("name", table_names())
def test_classes_and_rows_can_be_trained(name: str) -> None:
    table = load_table(name)
    assert set(table.classes) <= set(CATEGORIES)
    ours = [row.name for row in table.rows if row.setting is not None]
    assert len(set(ours)) == len(ours) >= 1
    assert all(re.fullmatch(r"[a-z0-9-]+", row) for row in ours)
    for comparison in table.comparisons:
        assert {comparison.better, comparison.worse} <= set(ours)
