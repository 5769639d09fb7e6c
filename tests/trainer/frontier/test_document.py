"""Every figure of docs/frontier.md is in docs/results/frontier.json, and its charts are there."""

import re
from pathlib import Path

import pytest

from trainer.frontier.files import read_report
from trainer.frontier.page import as_markdown
from trainer.frontier.plan import DEFAULT, load_plan
from trainer.frontier.report import Report, as_csv

DOCS = Path(__file__).parents[3] / "docs"
PAGE = DOCS / "frontier.md"
README = (DOCS.parent / "README.md").read_text()


@pytest.fixture(scope="module")
def report() -> Report:
    return read_report(DOCS)


def test_the_page_s_figures_are_the_data_s(report: Report) -> None:
    assert as_markdown(report) in PAGE.read_text()
    assert as_csv(report) == (DOCS / "results/frontier.csv").read_text()


def test_the_page_shows_every_chart() -> None:
    shown = re.findall(r"!\[[^\]]+\]\(images/(frontier-[a-z]+\.png)\)", PAGE.read_text())
    assert sorted(shown) == sorted(file.name for file in (DOCS / "images").glob("frontier-*.png"))


def test_what_was_measured_are_the_points_of_the_full_budget(report: Report) -> None:
    plan = load_plan("full")
    assert (report.budget, report.scale) == ("full", plan.scale)
    known = {(point.choice.name, category): point for point in plan.points for category in point.choice.classes}
    assert {(point.name, point.category) for point in report.points} <= known.keys()
    # What could not be measured is told.
    missing = known.keys() - {(point.name, point.category) for point in report.points}
    assert all(
        any(sentence.startswith(f"{name}, {category}: ") for sentence in report.skipped) for name, category in missing
    )
    assert len(report.skipped) == len(missing)
    for point in report.points:
        config = known[point.name, point.category].variant.config
        assert (point.width, point.height, point.steps) == (config.width, config.height, config.optimiser.steps)


def test_seeds_tell_how_sure_the_page_is(report: Report) -> None:
    assert len(report.default(report.categories[0]).runs) >= 2
    assert all(report.noise(category, "iou") > 0 for category in report.categories)
    assert {"paper", DEFAULT} <= {point.name for point in report.points}


@pytest.mark.parametrize(
    ("preset", "name"), [("fast", DEFAULT), ("balanced", "balanced"), ("sharp", "sharp"), ("detailed", "detailed")]
)
def test_what_the_readme_says_of_presets_is_on_the_chart(report: Report, preset: str, name: str) -> None:
    (row,) = (line for line in README.splitlines() if line.startswith(f"| `{preset}`"))
    points = {point.category: point for point in report.points if point.name == name}
    one = next(iter(points.values()))
    _, size, steps, minutes, *found = (cell.strip() for cell in row.strip("|").split("|"))
    assert size.startswith(f"{one.width} × {one.height}")
    assert steps == f"{one.steps:,}"
    assert minutes == f"{one.training_minutes:.1f}"
    assert found == [
        f"{points[category].iou:.2f}, {points[category].azimuth_accuracy:.2f}" if category in points else ""
        for category in ("car", "chair")
    ]
