"""What was measured, as files hold it and as page and charts read it."""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import mean
from typing import Literal, NamedTuple

from trainer.frontier.accuracy import Run
from trainer.frontier.costs import Cost
from trainer.frontier.pareto import near_front, on_front
from trainer.frontier.plan import DEFAULT, BundlePrecision, Expense, Point, Scale
from trainer.mapping import to_mapping

Accuracy = Literal["iou", "azimuth_error_degrees", "picture_error"]

ACCURACIES: tuple[Accuracy, ...] = ("iou", "azimuth_error_degrees", "picture_error")
EXPENSES: tuple[Expense, ...] = ("latency_ms", "training_minutes", "bundle_mb", "memory_mb")


@dataclass(frozen=True)
class Measured:
    """A point for one class: means over its runs, and what it costs."""

    category: str
    name: str
    factor: str
    factor_title: str
    factor_default: str
    """The default's label among this factor's points; empty where it is none of them."""
    factor_cost: Expense
    """What this factor's points are charted against."""
    label: str
    width: int
    height: int
    bundle: BundlePrecision
    refine: int
    """Steps of refinement for each picture."""
    iou: float
    azimuth_error_degrees: float
    azimuth_accuracy: float
    picture_error: float
    latency_ms: float
    training_minutes: float
    bundle_mb: float
    memory_mb: float
    multiply_adds_millions: float
    """To answer one picture."""
    parameters_thousands: float
    steps: int
    renderings_thousands: float
    """Pictures that the training compared with hypotheses: steps × batch × pose bins."""
    runs: tuple[Run, ...]

    def goodness(self, accuracy: Accuracy) -> float:
        """Larger is better."""
        value: float = getattr(self, accuracy)
        return value if accuracy == "iou" else -value

    def expense(self, expense: Expense) -> float:
        cost: float = getattr(self, expense)
        return cost


@dataclass(frozen=True)
class Machine:
    cpu: str
    cores: int
    system: str
    python: str
    torch: str
    onnxruntime: str


@dataclass(frozen=True)
class Report:
    budget: str
    date: str
    machine: Machine
    scale: Scale
    points: tuple[Measured, ...]
    skipped: tuple[str, ...]
    """A sentence for each point that could not be measured."""

    @property
    def categories(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(point.category for point in self.points))

    def of(self, category: str) -> tuple[Measured, ...]:
        return tuple(point for point in self.points if point.category == category)

    def default(self, category: str) -> Measured:
        return next(point for point in self.of(category) if point.name == DEFAULT)

    def noise(self, category: str, accuracy: Accuracy) -> float:
        """How far the class's runs of the default, which differ in their seed alone, lie apart at most; 0 for one."""
        values = [getattr(run, accuracy) for run in self.default(category).runs]
        return float(max(values) - min(values))


class Fronts(NamedTuple):
    """The points of one class, by one figure and one cost."""

    on: tuple[Measured, ...]
    """Nothing is as good for less: the Pareto front, cheapest first."""
    near: tuple[Measured, ...]
    """The others of which nothing that costs as little is better by more than seeds differ."""


def fronts(report: Report, points: Sequence[Measured], accuracy: Accuracy, expense: Expense) -> Fronts:
    costs = [point.expense(expense) for point in points]
    values = [point.goodness(accuracy) for point in points]
    on = on_front(costs, values)
    near = near_front(costs, values, report.noise(points[0].category, accuracy))
    chosen = [point for point, there in zip(points, on, strict=True) if there]
    return Fronts(
        tuple(sorted(chosen, key=lambda point: point.expense(expense))),
        tuple(point for point, there, close in zip(points, on, near, strict=True) if close and not there),
    )


def measured(point: Point, category: str, runs: Sequence[Run], cost: Cost) -> Measured:
    config, choice, factor = point.variant.config, point.choice, point.factor
    optimiser = config.optimiser
    drawn = optimiser.steps * optimiser.batch_size * config.model.azimuth_bins
    return Measured(
        category=category,
        name=choice.name,
        factor=factor.name,
        factor_title=factor.title,
        factor_default=factor.default,
        factor_cost=factor.cost,
        label=choice.label,
        width=config.width,
        height=config.height,
        bundle=choice.bundle,
        refine=choice.refine,
        iou=_mean((run.iou for run in runs), 4),
        azimuth_error_degrees=_mean((run.azimuth_error_degrees for run in runs), 3),
        azimuth_accuracy=_mean((run.azimuth_accuracy for run in runs), 4),
        picture_error=_mean((run.picture_error for run in runs), 5),
        training_minutes=_mean((run.minutes for run in runs), 3),
        steps=optimiser.steps,
        renderings_thousands=drawn / 1e3,
        runs=tuple(runs),
        **to_mapping(cost),
    )


def _mean(values: Iterable[float], digits: int) -> float:
    return round(mean(values), digits)


_COLUMNS = (
    "category", "name", "factor", "label", "width", "height", "bundle", "refine", "iou", "azimuth_error_degrees",
    "azimuth_accuracy", "picture_error", "latency_ms", "training_minutes", "bundle_mb", "memory_mb",
    "multiply_adds_millions", "parameters_thousands", "steps", "renderings_thousands",
)  # fmt: skip


def as_csv(report: Report) -> str:
    """A row a point and class, means over seeds."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((*_COLUMNS, "seeds"))
    for point in report.points:
        writer.writerow((*(getattr(point, column) for column in _COLUMNS), len(point.runs)))
    return text.getvalue()
