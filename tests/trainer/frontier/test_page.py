"""What page and data say of a report whose fronts are known."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.trainer.frontier.reports import POINTS, REPORT, measured
from trainer.frontier.files import read_report, write_report
from trainer.frontier.page import BEGIN, as_markdown, placed
from trainer.frontier.report import as_csv, fronts
from trainer.frontier.verdicts import verdicts


def test_the_front_and_what_is_near_it() -> None:
    found = fronts(REPORT, REPORT.of("car"), "iou", "latency_ms")
    assert [point.name for point in found.on] == ["quarter", "half", "large"]
    assert [point.name for point in found.near] == ["default"]
    # A smaller error is better, too.
    by_azimuth = fronts(REPORT, REPORT.of("car"), "azimuth_error_degrees", "latency_ms")
    assert [point.name for point in by_azimuth.on] == ["quarter", "half", "large"]


def test_seeds_tell_the_noise() -> None:
    assert REPORT.noise("car", "iou") == pytest.approx(0.01)
    single = tuple(replace(point, runs=point.runs[:1]) for point in REPORT.points)
    assert replace(REPORT, points=single).noise("car", "iou") == 0


def test_verdicts() -> None:
    width, size, bins = verdicts(REPORT, "car", "iou")
    assert (width.factor, width.choice, width.on_front, width.better) == ("width", "usual", False, None)
    assert [(rival.point.name, rival.expense, rival.share) for rival in width.rivals] == [
        ("half", "latency_ms", 0.5), ("quarter", "latency_ms", 0.25),
    ]  # fmt: skip
    assert (size.on_front, size.rivals) == (True, ())
    assert size.better is not None
    assert size.better.name == "large"
    assert (bins.on_front, bins.rivals, bins.better) == (True, (), None)
    near = replace(REPORT, points=tuple(point for point in REPORT.points if point.name != "half"))
    width = verdicts(near, "car", "iou")[0]
    assert (width.on_front, len(width.rivals)) == (True, 1)


def test_the_page_says_what_was_measured() -> None:
    page = as_markdown(REPORT)
    assert "| Width | the half | 0.700 [0.68, 0.72] | 30.0° | 0.90 | 0.0300 | 1.00 |" in page
    assert "| Default | the default | 0.700 (0.695, 0.705) |" in page
    assert "cheapest first: the quarter (0.693) → the half (0.700) → the large (0.750)" in page
    assert "| Width | usual | no | the half: +0.000 IoU at 50% of the latency; the quarter: -0.007 IoU" in page
    assert "| Size | usual | yes | – | the large (0.750) |" in page
    assert "| Guesses | mean shape | 0.600 |" in page
    assert "- bundle-int8, car: not trained" in page
    assert page.index("## car") < page.index("## chair")
    tables = [line for line in page.splitlines() if line.startswith("| ")]
    assert {line.count("|") for line in tables} == {14, 6}


def test_of_a_page_that_is_there_the_rest_is_kept() -> None:
    figures = as_markdown(REPORT)
    first = placed("# Mine\n\nBefore.\n", figures)
    assert first == "# Mine\n\nBefore.\n\n" + figures
    again = placed(first + "\nAfter.\n", as_markdown(replace(REPORT, budget="small")))
    assert again.startswith("# Mine\n\nBefore.\n\n" + BEGIN)
    assert again.endswith("\nAfter.\n")
    assert "`small`" in again
    assert "`full`" not in again
    assert placed("", figures) == figures


def test_data_is_read_as_it_was_written(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="charts need matplotlib: pip install 'chiaro[bench]'")
    written = write_report(REPORT, tmp_path)
    assert read_report(tmp_path) == REPORT
    assert sorted(written) == sorted(str(file.relative_to(tmp_path)) for file in tmp_path.rglob("*") if file.is_file())
    rows = list(csv.DictReader((tmp_path / "results/frontier.csv").read_text().splitlines()))
    assert [row["name"] for row in rows] == [point.name for point in REPORT.points]
    assert [float(row["iou"]) for row in rows] == [point.iou for point in REPORT.points]
    assert rows[0]["seeds"] == "2"
    assert as_csv(read_report(tmp_path)) == (tmp_path / "results/frontier.csv").read_text()
    assert json.loads((tmp_path / "results/frontier.json").read_text())["points"][1]["name"] == POINTS[1].name


def test_a_point_without_a_rival_is_the_front() -> None:
    alone = replace(REPORT, points=(measured("default", "default", 0.7, 2.0),))
    assert [point.name for point in fronts(alone, alone.of("car"), "iou", "latency_ms").on] == ["default"]
    assert verdicts(alone, "car", "iou") == []
