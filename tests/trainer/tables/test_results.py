"""What is made of figures: means with intervals, and orderings."""

import math
from itertools import groupby
from pathlib import Path

import pytest

from trainer.presets import load_preset
from trainer.tables.cells import entries_of, tasks_of
from trainer.tables.page import as_markdown
from trainer.tables.results import Result, mean_figure, orderings_of, paper_difference
from trainer.tables.statistics import mean_of
from trainer.tables.study import Study
from trainer.tables.table import PaperOrdering, Reference, Table, load_table


def test_the_interval_is_student_s() -> None:
    assert mean_of([]) is None
    assert mean_of([0.5]) == (0.5, None, 1)
    mean = mean_of([1.0, 2.0, 3.0])
    assert mean is not None
    # t of two degrees of freedom at 97.5 % is 4.3027, the standard deviation is 1.
    assert mean.value == pytest.approx(2.0)
    assert mean.margin == pytest.approx(4.302653 / math.sqrt(3), rel=1e-6)


def results(table: Table, iou: dict[str, float], seeds: tuple[int, ...]) -> list[Result]:
    """Of car and chair (0.2 less), each seed 0.01 more than the one before."""
    found = []
    for entry in entries_of(table, ("car", "chair"), seeds):
        value = iou[entry.row.name] - 0.2 * (entry.cell.category == "chair") + 0.01 * entry.cell.seed
        value += 0.1 * (entry.figures == ("iou_pose_given",))
        metrics = {"iou": value, "azimuth_error_degrees": 5.0, "azimuth_accuracy": 0.9}
        found.append(Result(entry, 10, 60.0, metrics))
    return found


def test_a_figure_is_the_mean_over_the_seeds_of_its_own_trainings() -> None:
    table = load_table("table-2")
    found = results(table, {"ortho-block": 0.5, "full-block": 0.6, "subdivision": 0.7}, (0, 1, 2))
    for figure, expected in (("iou", 0.41), ("iou_pose_given", 0.51), ("err", 5.0), ("acc", 0.9)):
        mean = mean_figure(found, "chair", "full-block", figure)
        assert mean is not None
        assert (mean.value, mean.size) == (pytest.approx(expected), 3)
    assert mean_figure(found, "sofa", "full-block", "iou") is None


def test_an_ablation_compares_without_the_paper() -> None:
    table = load_table("ablation")
    iou = dict.fromkeys((row.name for row in table.rows), 0.5) | {"recipe": 0.6}
    found = results(table, iou, (0, 1, 2))
    assert [(one.paper, one.verdict) for one in orderings_of(table, found)] == [(None, "found")] * 9
    study = Study(Path("out"), "sharp", load_preset("sharp"), 4000, 100, 6, None)
    page = as_markdown(table, study, ("car", "chair"), found, ())
    assert "## What each is worth" in page
    assert "| recipe | no-zoom | +0.100 ± 0.000 | 6 of 6 | found | +0.100 ± 0.000 | +0.100 ± 0.000 |" in page
    # Each line of a table has as many cells as its head.
    for _, lines in groupby(page.splitlines(), lambda line: line.startswith("|")):
        assert len({line.count("|") for line in lines if line.startswith("|")}) <= 1
    assert "ShapeNet" not in page


def test_many_seeds_are_told_by_how_far_they_lie_apart() -> None:
    table, study = load_table("seeds"), Study(Path("out"), "sharp", load_preset("sharp"), 4000, 100, 6, None)
    found = results(table, {"recipe": 0.5}, tuple(range(10)))
    page = as_markdown(table, study, ("car", "chair"), found, ())
    assert "| class | setting | best IoU | median | worst | within 0.05 of the best |" in page
    assert "| car | recipe | 0.59 | 0.55 | 0.50 | 6 of 10 |" in page
    assert "| chair | recipe | 0.39 | 0.34 | 0.30 | 6 of 10 |" in page
    assert "Seed by seed" not in as_markdown(table, study, ("car", "chair"), found[:6], ())


def test_an_ordering_is_found_reversed_or_not_decided() -> None:
    table = load_table("comparisons")
    iou = dict.fromkeys((row.name for row in table.rows), 0.5)
    iou |= {"white": 0.4, "silhouette": 0.6}
    found = {(o.comparison.better, o.comparison.worse): o for o in orderings_of(table, results(table, iou, (0, 1, 2)))}
    white = found["baseline", "white"]
    assert white.ours is not None
    assert (white.ours.value, white.ours.size, white.agreeing, white.verdict) == (pytest.approx(0.1), 6, 6, "found")
    assert white.by_class["chair"].value == pytest.approx(0.1)
    assert found["baseline", "silhouette"].verdict == "reversed"
    assert found["baseline", "varying"].verdict == "not decided"
    alone = {(o.comparison.better, o.comparison.worse): o for o in orderings_of(table, results(table, iou, (0,))[:8])}
    # One pair has no interval, however large its difference.
    assert alone["baseline", "white"].ours == (pytest.approx(0.1), None, 1)
    assert alone["baseline", "white"].verdict == "not decided"
    assert all(o.ours is None and o.verdict == "not decided" for o in orderings_of(table, []))


def test_the_paper_s_orderings_hold_in_the_paper() -> None:
    for comparison in load_table("comparisons").comparisons:
        assert comparison.paper is not None
        assert paper_difference(comparison.paper) > 0
    views = PaperOrdering("table-5", Reference("train-3-test-1", "iou"), Reference("train-1-test-1", "iou"))
    assert paper_difference(views) == pytest.approx(((0.82 - 0.77) + (0.50 - 0.46)) / 2)


def test_a_training_that_rows_share_is_done_once() -> None:
    tasks = tasks_of(entries_of(load_table("table-5"), ("car", "chair"), (0, 1)))
    # For each class and seed: one view and three, with and without poses.
    assert len(tasks) == len({task.cell for task in tasks}) == 2 * 2 * 4
    assert {task.test_views for task in tasks if task.cell.setting.views == 3} == {(1, 3)}
    assert {task.test_views for task in tasks if task.cell.setting.views == 1} == {(1,)}
    # Interrupted after the first half, the first seed is whole.
    assert {task.cell.seed for task in tasks[: len(tasks) // 2]} == {0}
    assert len(tasks_of(entries_of(load_table("comparisons"), ("car", "chair", "airplane", "sofa"), (0, 1, 2)))) == 96
