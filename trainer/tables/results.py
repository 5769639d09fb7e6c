"""What has been measured so far: our figures by class and row, and which of the paper's orderings they show."""

import statistics
from collections.abc import Iterable, Sequence
from typing import Any, Literal, NamedTuple

from trainer.tables.cells import Entry
from trainer.tables.statistics import Mean, mean_of
from trainer.tables.study import Study
from trainer.tables.table import Comparison, Figure, PaperOrdering, Table, load_table

_METRICS: dict[Figure, str] = {
    "iou": "iou",
    "err": "azimuth_error_degrees",
    "acc": "azimuth_accuracy",
    "iou_pose_given": "iou",
}
"""Each figure's name in metrics.json."""
NEAR_THE_BEST = 0.05


class Result(NamedTuple):
    """A cell that is trained and judged, for one row of the table."""

    entry: Entry
    steps: int
    seconds: float
    metrics: dict[str, Any]

    def value(self, figure: Figure) -> float:
        return float(self.metrics[_METRICS[figure]])


class Ordering(NamedTuple):
    """A comparison: IoU of the row that should be better less that of the other, at the same class and seed."""

    comparison: Comparison
    paper: float | None
    """Mean over the paper's classes; None where the paper does not compare."""
    ours: Mean | None
    """Over our classes and seeds; None where no pair is done."""
    by_class: dict[str, Mean]
    agreeing: int
    """Pairs in which it does."""
    verdict: Literal["found", "reversed", "not decided"]
    """Whether the whole interval of ours lies above 0, below it, or neither."""


class Scatter(NamedTuple):
    """How far seeds of one setting lie apart."""

    best: float
    median: float
    worst: float
    near: int
    """How many are at most `NEAR_THE_BEST` behind the best, itself included."""
    size: int
    """How many there are."""


def results_of(study: Study, entries: Iterable[Entry]) -> list[Result]:
    """The entries that are done."""
    results = []
    for entry in entries:
        metrics = study.metrics(entry.cell, entry.row.test_views)
        if metrics is not None and study.is_trained(entry.cell):
            trained = study.trained(entry.cell)
            results.append(Result(entry, trained["steps"], trained["seconds"], metrics))
    return results


def mean_figure(results: Sequence[Result], category: str, row: str, figure: Figure) -> Mean | None:
    """Over seeds."""
    return mean_of(
        [
            result.value(figure)
            for result in results
            if (result.entry.cell.category, result.entry.row.name) == (category, row) and figure in result.entry.figures
        ]
    )


def scatter_of(results: Sequence[Result], category: str, row: str) -> Scatter | None:
    """Of IoU over seeds; None where there is none."""
    found = sorted(
        result.value("iou")
        for result in results
        if (result.entry.cell.category, result.entry.row.name) == (category, row) and "iou" in result.entry.figures
    )
    if not found:
        return None
    near = sum(value > found[-1] - NEAR_THE_BEST - 1e-9 for value in found)
    return Scatter(found[-1], statistics.median(found), found[0], near, len(found))


def orderings_of(table: Table, results: Sequence[Result]) -> list[Ordering]:
    by_pair = {
        (result.entry.row.name, result.entry.cell.category, result.entry.cell.seed): result.value("iou")
        for result in results
    }
    orderings = []
    for comparison in table.comparisons:
        differences: dict[str, list[float]] = {}
        for (row, category, seed), iou in by_pair.items():
            other = by_pair.get((comparison.worse, category, seed))
            if row == comparison.better and other is not None:
                differences.setdefault(category, []).append(iou - other)
        everywhere = [difference for known in differences.values() for difference in known]
        ours = mean_of(everywhere)
        by_class = {category: mean for category, known in differences.items() if (mean := mean_of(known)) is not None}
        orderings.append(
            Ordering(
                comparison,
                None if comparison.paper is None else paper_difference(comparison.paper),
                ours,
                by_class,
                sum(difference > 0 for difference in everywhere),
                _verdict(ours),
            )
        )
    return orderings


def paper_difference(ordering: PaperOrdering) -> float:
    """The paper's own mean difference over the classes of its table."""
    table = load_table(ordering.table)
    better, worse = table.row(ordering.better.row).paper, table.row(ordering.worse.row).paper
    differences = [better[name][ordering.better.figure] - worse[name][ordering.worse.figure] for name in table.classes]
    return sum(differences) / len(differences)


def _verdict(ours: Mean | None) -> Literal["found", "reversed", "not decided"]:
    if ours is None or ours.margin is None or abs(ours.value) <= ours.margin:
        return "not decided"
    return "found" if ours.value > 0 else "reversed"
