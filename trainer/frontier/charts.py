"""The charts of a frontier, one message each."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("agg")

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from trainer.frontier.labels import Label, write_labels
from trainer.frontier.plan import DEFAULT, Expense
from trainer.frontier.report import Accuracy, Fronts, Measured, Report, fronts

FRONT, NEAR, OTHER, CHOSEN, BASELINE = "#0b6e4f", "#2a9d8f", "#9aa3ad", "#c1121f", "#7a5c00"
PAPER = "paper"
# Places along each piece of the front's line that labels keep clear of.
_ALONG = 80

Place = tuple[float, float]

AXES: dict[Accuracy | Expense, str] = {
    "iou": "IoU at 32³ (higher is better)",
    "azimuth_error_degrees": "median azimuth error, degrees (lower is better)",
    "picture_error": "mean error of the drawn-again picture,\nlinear RGB 0 to 1 (lower is better)",
    "latency_ms": "latency of a picture on one core, milliseconds",
    "training_minutes": "training, minutes of one core",
    "bundle_mb": "size of the bundle, MB",
    "memory_mb": "peak memory of a process that answers, MB",
}
SHORT: dict[Accuracy | Expense, str] = {
    "iou": "IoU",
    "azimuth_error_degrees": "azimuth error",
    "picture_error": "picture error",
    "latency_ms": "latency",
    "training_minutes": "training time",
    "bundle_mb": "bundle size",
    "memory_mb": "memory",
}
_FILES: dict[str, tuple[Accuracy, Expense]] = {
    "latency": ("iou", "latency_ms"),
    "training": ("iou", "training_minutes"),
    "size": ("iou", "bundle_mb"),
    "memory": ("iou", "memory_mb"),
    "azimuth": ("azimuth_error_degrees", "training_minutes"),
    "picture": ("picture_error", "latency_ms"),
}


def write_charts(report: Report, folder: Path) -> list[Path]:
    """All charts, as frontier-….png in `folder`; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    first, *others = report.categories
    for name, (accuracy, expense) in _FILES.items():
        written.append(_saved(_trade(report, first, accuracy, expense), folder / f"frontier-{name}.png"))
    for category in others:
        figure = _trade(report, category, "iou", "training_minutes")
        written.append(_saved(figure, folder / f"frontier-{category}.png"))
    written.append(_saved(_factors(report, first), folder / "frontier-factors.png"))
    return written


def _saved(figure: Figure, file: Path) -> Path:
    figure.savefig(file, dpi=110, metadata={"Software": None})
    plt.close(figure)
    return file


def _trade(report: Report, category: str, accuracy: Accuracy, expense: Expense) -> Figure:
    """All points of a class by one figure and one cost, and the front."""
    points = report.of(category)
    found = fronts(report, points, accuracy, expense)
    figure, axes = plt.subplots(figsize=(9.2, 6.2), layout="constrained")
    costs = [point.expense(expense) for point in points]
    values = [getattr(point, accuracy) for point in points]
    _logarithmic(axes.xaxis, costs)
    line = _front_line(axes, found, accuracy, expense, max(costs) * 1.3)
    for point, cost, value in zip(points, costs, values, strict=True):
        on = point in found.on
        axes.plot(cost, value, "o", color=_colour(point, found), markersize=9 if on else 6, zorder=3)
        if len(point.runs) > 1:
            own = [getattr(run, accuracy) for run in point.runs]
            axes.plot([cost, cost], [min(own), max(own)], color=_colour(point, found), linewidth=1.2, zorder=2)
    if accuracy == "iou":
        _baselines(axes, report, category)
    axes.margins(x=0.12, y=0.08)
    axes.set_xlabel(AXES[expense])
    axes.set_ylabel(AXES[accuracy])
    axes.grid(alpha=0.2)
    axes.set_title(_message(report, category, found, accuracy, expense), loc="left", fontsize=11)
    labels = [
        Label(p.expense(expense), getattr(p, accuracy), p.label, _style(p, found), _is_told(p, found))
        for p in sorted(points, key=lambda point: _rank(point, found))
    ]  # fmt: skip
    write_labels(axes, labels, [*zip(costs, values, strict=True), *line])
    return figure


def _message(report: Report, category: str, found: Fronts, accuracy: Accuracy, expense: Expense) -> str:
    """What the chart says, from its own figures."""
    default = report.default(category)
    best = found.on[-1]
    lines = [f"{category}: {SHORT[accuracy]} against {SHORT[expense]}"]
    if default in found.on:
        lines.append("The default lies on the front (green).")
    else:
        cheaper = [point for point in found.on if point.expense(expense) <= default.expense(expense)]
        nearest = cheaper[-1] if cheaper else best
        share = nearest.expense(expense) / default.expense(expense)
        close = "within what seeds differ by" if default in found.near else "by more than seeds differ"
        told = f"{getattr(nearest, accuracy):.3g} for {share:.0%} of its {SHORT[expense]}"
        lines.append(f"The default ({getattr(default, accuracy):.3g}) lies behind the front (green), {close}:")
        lines.append(f"{nearest.label} has {told}.")
    return "\n".join(lines)


def _factors(report: Report, category: str) -> Figure:
    """IoU against each factor's own cost, its points joined."""
    points, default = report.of(category), report.default(category)
    titles = {point.factor: point.factor_title for point in points if point.factor_default and point.name != DEFAULT}
    columns = min(4, len(titles))
    rows = -(-len(titles) // columns)
    figure, grid = plt.subplots(
        rows, columns, figsize=(3.9 * columns, 3.3 * rows), squeeze=False, layout="constrained", sharey=True
    )
    noise = report.noise(category, "iou")
    for axes, (factor, title) in zip(grid.flat, titles.items(), strict=False):
        own = [point for point in points if point.factor == factor]
        cost, own_label = own[0].factor_cost, own[0].factor_default
        own = sorted([*own, default], key=lambda point: point.expense(cost))
        _logarithmic(axes.xaxis, [point.expense(cost) for point in points])
        axes.axhspan(default.iou - noise, default.iou + noise, color=CHOSEN, alpha=0.07, linewidth=0)
        axes.plot(
            [p.expense(cost) for p in points], [p.iou for p in points], "o", color=OTHER, alpha=0.35, markersize=4
        )
        axes.plot([p.expense(cost) for p in own], [p.iou for p in own], "-o", color=FRONT, markersize=6)
        axes.plot(default.expense(cost), default.iou, "o", color=CHOSEN, markersize=8)
        axes.margins(x=0.3, y=0.12)
        axes.set_title(title, loc="left", fontsize=10)
        axes.grid(alpha=0.2)
        labels = [
            Label(p.expense(cost), p.iou, text, {"fontsize": 8, "color": "#222222"}, True)
            for p in own
            for text in (own_label if p is default else p.label,)
        ]
        write_labels(axes, labels, [(p.expense(cost), p.iou) for p in own])
        axes.set_xlabel(AXES[cost], fontsize=8)
    for axes in grid.flat[len(titles) :]:
        axes.remove()
    figure.supylabel("IoU at 32³", fontsize=10)
    figure.suptitle(
        f"{category}: what each factor buys, one changed at a time. Red: the default; band: what seeds differ by "
        f"(±{noise:.3f})",
        fontsize=11,
    )
    return figure


def _front_line(axes: Axes, found: Fronts, accuracy: Accuracy, expense: Expense, end: float) -> list[Place]:
    """Draws steps, what is to be had for a cost, and returns places along them."""
    xs = [*(point.expense(expense) for point in found.on), end]
    ys = [getattr(point, accuracy) for point in found.on]
    axes.step(xs, [*ys, ys[-1]], where="post", color=FRONT, linewidth=1.4, alpha=0.7)
    along: list[Place] = []
    for x, following, y in zip(xs, xs[1:], ys, strict=False):
        along += [(float(between), y) for between in np.geomspace(x, following, _ALONG)]
    for x, y, following in zip(xs[1:], ys, ys[1:], strict=False):
        along += [(x, float(between)) for between in np.linspace(y, following, _ALONG)]
    return along


def _baselines(axes: Axes, report: Report, category: str) -> None:
    """Guesses that know the shapes of the class, which no model here was told."""
    run = report.default(category).runs[0]
    for text, value in (("mean shape", run.mean_shape_iou), ("nearest neighbour", run.nearest_neighbour_iou)):
        axes.axhline(value, color=BASELINE, linewidth=1, linestyle="--", zorder=1)
        axes.annotate(
            f"{text} {value:.2f} (knows the class's shapes)", (0.99, value), (0, 3), xycoords=("axes fraction", "data"),
            textcoords="offset points", ha="right", fontsize=8, color=BASELINE,
        )  # fmt: skip


def _rank(point: Measured, found: Fronts) -> int:
    """Which labels come first."""
    if point.name == DEFAULT:
        return 0
    if point in found.on:
        return 1
    return 2 if point.factor == PAPER else 3


def _is_told(point: Measured, found: Fronts) -> bool:
    """Whether its label is written even where there is little room."""
    return _rank(point, found) < 3


def _colour(point: Measured, found: Fronts) -> str:
    if point.name == DEFAULT or point.factor == PAPER:
        return CHOSEN
    if point in found.on:
        return FRONT
    return NEAR if point in found.near else OTHER


def _style(point: Measured, found: Fronts) -> dict[str, object]:
    bold = _is_told(point, found)
    colour = _colour(point, found) if bold else "#555555"
    return {"fontsize": 9.5 if bold else 7.5, "color": colour, "fontweight": "bold" if bold else "normal"}


def _logarithmic(axis: Axis, values: Sequence[float]) -> None:
    """A logarithmic axis with plain numbers."""
    axis.axes.set_xscale("log")
    narrow = max(values) / min(values) < 4
    if narrow:
        axis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)))
    else:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(lambda value, _: f"{value:,.10g}")
