"""Charts of what was found, one message each. Needs matplotlib, which comes with the extra `bench`."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from trainer.stability.picture_charts import (
    COLOURS,
    groups_chart,
    others_chart,
    reliability_chart,
    risk_chart,
    severities_chart,
    uploads_chart,
)
from trainer.stability.tables import Results


def write_charts(results: Results, folder: Path) -> list[Path]:
    """Every chart whose figures are there, as stability-*.png in a folder; returns the files."""
    models, drawn = results["models"], dict[str, Figure]()
    if models:
        drawn |= {
            "iou": severities_chart(models, "How far shapes hold: IoU at 32³", "IoU", ("iou",)),
            "azimuths": severities_chart(
                models,
                "Does confidence fall where poses go wrong? Azimuths within 30° (solid), mean confidence (dashed)",
                "share; confidence",
                ("symmetric_azimuth_accuracy", "confidence"),
            ),
            "refusals": severities_chart(
                models,
                "What is seen of it: pictures refused for their score (solid); wrong, sure and answered (dashed)",
                "share of pictures",
                ("refused", "deceptive"),
            ),
            "uploads": uploads_chart(models),
            "risk": risk_chart(models),
            "confidence": reliability_chart(models),
            "groups": groups_chart(models),
            "other-classes": others_chart(models),
        }
    if results["trainings"]:
        drawn["trainings"] = _trainings(results["trainings"])
    if results["rasteriser"]:
        drawn["rasteriser"] = _rasteriser(results["rasteriser"])
    files = []
    for name, figure in drawn.items():
        files.append(folder / f"stability-{name}.png")
        figure.savefig(files[-1], dpi=100)
    return files


def _trainings(trainings: Results) -> Figure:
    """A row for each regime, a mark for each seed."""
    figure = Figure(figsize=(9.6, 0.42 * len(trainings) + 1.6), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    quantities = (("iou", "IoU at 32³"), ("symmetric_azimuth_accuracy", "share of azimuths within 30°"))
    for axis, (quantity, title) in zip(axes, quantities, strict=True):
        for row, regime in enumerate(trainings.values()):
            for run in regime["seeds"]:
                if run["figures"] is None:
                    axis.plot(0, row, "x", color=COLOURS[1], clip_on=False)
                else:
                    axis.plot(run["figures"][quantity], row, "o", color=COLOURS[0], alpha=0.8)
        axis.set_yticks(range(len(trainings)), [regime["title"] for regime in trainings.values()], fontsize=8)
        axis.set_ylim(len(trainings) - 0.5, -0.5)
        axis.set_xlim(0, 1)
        axis.set_xlabel(title)
        axis.grid(alpha=0.3)
    figure.suptitle("Short trainings of cars, a mark a seed (cross: not finished)")
    return figure


def _rasteriser(kinds: Results) -> Figure:
    """Errors of pictures and gradients by angle."""
    figure = Figure(figsize=(11.0, 7.4), layout="constrained")
    rows: tuple[tuple[str, str, float], ...] = (
        ("picture_error", "mean error of touched pixels, 1/255", 1.0),
        ("gradient_error", "error of the gradient, %", 100.0),
    )
    axes: Any = figure.subplots(2, len(kinds), squeeze=False)
    for column, kind in enumerate(kinds.values()):
        places = range(len(kind["points"]))
        for axis, (quantity, label, factor) in zip(axes[:, column], rows, strict=True):
            for colour, crease, title in (
                (COLOURS[0], "exact", "all borders antialiased"),
                (COLOURS[1], "contours", "contours alone, as trainings draw"),
            ):
                values = [max(1e-3, factor * point[f"{quantity}_{crease}"]) for point in kind["points"]]
                axis.plot(places, values, "o-", color=colour, label=title)
            axis.set_yscale("log")
            axis.set_xticks(places, [f"{point['angle_degrees']:g}" for point in kind["points"]])
            axis.set_xlabel(f"{kind['title']}, degrees")
            axis.set_ylabel(label)
            axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=8)
    figure.suptitle("The rasteriser against brute force")
    return figure
