"""Charts of what was found of models and their pictures, one message each. Needs matplotlib, of the extra `bench`."""

from collections.abc import Callable, Iterable

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trainer.stability.tables import Results

COLOURS = ("#0b6e4f", "#c1121f", "#4c6ef5", "#e08e0b", "#7a3e9d", "#8d99ae", "#2a9d8f", "#5c4033")
_COLUMNS = 6
_GREY = "#8d99ae"
_FEWEST = 10


def severities_chart(models: Results, title: str, label: str, quantities: tuple[str, ...]) -> Figure:
    """A panel for each condition, a colour for each model; a ring where it breaks."""
    conditions = next(iter(models.values()))["conditions"]

    def panel(axis: Axes, name: str) -> None:
        for colour, (model_name, model) in zip(COLOURS, models.items(), strict=False):
            condition = model["conditions"][name]
            for quantity, style in zip(quantities, ("-", "--"), strict=False):
                values = [point[quantity] for point in condition["points"]]
                axis.plot(values, style, color=colour, label=model_name if style == "-" else None, linewidth=1.4)
                for place, point in enumerate(condition["points"]):
                    if style == "-" and point["severity"] == condition["breaks_at"]:
                        axis.plot(place, values[place], "o", color=colour, fillstyle="none", markersize=9)
        points = conditions[name]["points"]
        axis.set_xticks(range(len(points)), [f"{point['severity']:g}" for point in points], fontsize=7)
        axis.set_title(conditions[name]["title"], fontsize=10)
        axis.set_xlabel(conditions[name]["unit"], fontsize=7)
        axis.set_ylim(0, 1.02)

    figure = _panels(conditions, panel, label)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(models), fontsize=9)
    figure.suptitle(f"{title}; rings: broken", fontsize=12)
    return figure


def _panels(names: Iterable[str], panel: Callable[[Axes, str], None], label: str) -> Figure:
    listed = list(names)
    rows = -(-len(listed) // _COLUMNS)
    figure = Figure(figsize=(2.45 * _COLUMNS, 2.35 * rows + 0.8), layout="constrained")
    axes = figure.subplots(rows, _COLUMNS, squeeze=False, sharey=True)
    for axis, name in zip(axes.flat, listed, strict=False):
        panel(axis, name)
        axis.grid(alpha=0.3)
        axis.tick_params(labelsize=7)
    for axis in axes.flat[len(listed) :]:
        axis.remove()
    for row in axes:
        row[0].set_ylabel(label, fontsize=8)
    return figure


def uploads_chart(models: Results) -> Figure:
    """Stacked bars at each condition's worst."""
    figure = Figure(figsize=(4.2 * len(models) + 1.6, 5.6), layout="constrained")
    axes = figure.subplots(1, len(models), squeeze=False, sharey=True)[0]
    parts = (("right", "right", COLOURS[0]), ("refused", "refused", _GREY), ("wrong", "wrong", COLOURS[1]))
    for axis, (name, model) in zip(axes, models.items(), strict=True):
        sent = [condition["points"][-1]["upload"] for condition in model["conditions"].values()]
        ends = [0.0] * len(sent)
        for part, title, colour in parts:
            widths = [one[part] + (one["refused_at_once"] if part == "refused" else 0) for one in sent]
            axis.barh(range(len(sent)), widths, left=ends, color=colour, label=title)
            ends = [end + width for end, width in zip(ends, widths, strict=True)]
        axis.set_yticks(
            range(len(sent)),
            [f"{one['title']}, {one['points'][-1]['severity']:g}" for one in model["conditions"].values()],
            fontsize=8,
        )
        axis.invert_yaxis()
        axis.set_xlim(0, 1)
        axis.set_xlabel("share of pictures sent")
        axis.set_title(name, fontsize=10)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    figure.suptitle("What the sender of a picture gets, at each condition's worst")
    return figure


def risk_chart(models: Results) -> Figure:
    """Risk against coverage of all pictures, a panel for each model."""
    figure = Figure(figsize=(4.2 * len(models) + 1.6, 4.3), layout="constrained")
    axes = figure.subplots(1, len(models), squeeze=False, sharey=True)[0]
    orders = (
        ("risk_ideal", "ideal order", _GREY, ":"),
        ("risk_confidence", "by confidence", COLOURS[2], "-"),
        ("risk_score", "by out-of-class score", COLOURS[3], "-"),
        ("risk_combined", "by both", COLOURS[0], "-"),
    )
    for axis, (name, model) in zip(axes, models.items(), strict=True):
        risk = model["risk"]["all"]
        for order, title, colour, style in orders:
            axis.plot(risk["coverage"], risk["wrong_azimuth"][order], style, color=colour, label=title)
        random = risk["wrong_azimuth"]["aurc_random"]
        axis.axhline(random, color="black", linewidth=0.8, linestyle="--", label="random order")
        axis.set_title(f"{name}, {risk['pictures']:,} pictures", fontsize=10)
        axis.set_xlabel("coverage: share answered, the most trusted first")
        axis.grid(alpha=0.3)
        axis.set_ylim(bottom=0)
        axis.set_xlim(0, 1)
    axes[0].set_ylabel("risk: share of these with an azimuth error > 30°")
    axes[0].legend(fontsize=8)
    figure.suptitle("What answering less is worth: all pictures")
    return figure


def reliability_chart(models: Results) -> Figure:
    """How often answers are right, by their confidence."""
    figure = Figure(figsize=(6.4, 4.9), layout="constrained")
    axis = figure.subplots()
    for colour, (name, model) in zip(COLOURS, models.items(), strict=False):
        for pictures, style in (("clean", "--"), ("all", "-")):
            parts = [part for part in model["reliability"][pictures] if part["pictures"] >= _FEWEST]
            label = f"{name}, {'untouched' if pictures == 'clean' else 'all pictures'}"
            axis.plot(
                [part["mean_confidence"] for part in parts],
                [part["right"] for part in parts],
                f"o{style}", color=colour, markersize=4, label=label,
            )  # fmt: skip
    axis.plot((0, 1), (0, 1), ":", color="black", linewidth=0.8, label="honest")
    axis.set_xlabel("reported confidence (mean of a range)")
    axis.set_ylabel("share of azimuths within 30°")
    axis.set_title(f"Is confidence honest? Ranges with {_FEWEST} pictures or more")
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8)
    return figure


def groups_chart(models: Results) -> Figure:
    """IoU and right azimuths of untouched pictures by what they show."""
    titles = {
        "side": "angle between the view and front or back",
        "thinness": "share of the object's voxels at its surface (quarters of each class)",
    }
    figure = Figure(figsize=(12.0, 4.6), layout="constrained")
    for axis, (kind, title) in zip(figure.subplots(1, 2, sharey=True), titles.items(), strict=True):
        for colour, (name, model) in zip(COLOURS, models.items(), strict=False):
            parts = model["groups"][kind]
            for quantity, style in (("iou", "o-"), ("symmetric_azimuth_accuracy", "s--")):
                label = f"{name}, {'IoU' if quantity == 'iou' else 'within 30°'}"
                axis.plot([part[quantity] for part in parts], style, color=colour, label=label, markersize=4)
        first = next(iter(models.values()))["groups"][kind]
        names = [part["group"] for part in first] if kind == "side" else ["thickest", "", "", "thinnest"][: len(first)]
        axis.set_xticks(range(len(first)), names, fontsize=8)
        axis.set_xlabel(title)
        axis.set_ylim(0, 1.02)
        axis.grid(alpha=0.3)
    figure.axes[0].set_ylabel("IoU at 32³; share of azimuths within 30°")
    figure.axes[1].legend(fontsize=8)
    figure.suptitle("Which untouched pictures are hard")
    return figure


def others_chart(models: Results) -> Figure:
    """What of other classes is refused, and what is answered with confidence."""
    figure = Figure(figsize=(4.2 * len(models) + 2.4, 4.6), layout="constrained")
    axes = figure.subplots(1, len(models), squeeze=False)[0]
    for axis, (name, model) in zip(axes, models.items(), strict=True):
        others = model["other_classes"]
        refused, sure = ([told[what] for told in others.values()] for what in ("refused", "sure"))
        unsure = [1 - no - yes for no, yes in zip(refused, sure, strict=True)]
        starts = [no + maybe for no, maybe in zip(refused, unsure, strict=True)]
        axis.barh(range(len(others)), refused, color=_GREY, label="refused")
        axis.barh(range(len(others)), unsure, left=refused, color=COLOURS[3], label="answered, unsure of the azimuth")
        axis.barh(range(len(others)), sure, left=starts, color=COLOURS[1], label="answered, sure of the azimuth")
        axis.set_yticks(range(len(others)), list(others), fontsize=8)
        axis.invert_yaxis()
        axis.set_xlim(0, 1)
        axis.set_xlabel("share of pictures")
        axis.set_title(f"asked: the model of the class {name}", fontsize=10)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3 if len(models) > 1 else 1)
    figure.suptitle("Pictures of other classes, by the class that they show")
    return figure
