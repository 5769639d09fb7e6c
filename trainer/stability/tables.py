"""Tables of what was found of models and their pictures."""

from collections.abc import Sequence
from typing import Any

Results = dict[str, Any]
"""What stability.json holds, or a part of it."""

_WORST = 4


def clean_table(models: Results) -> str:
    """Each model on untouched pictures, and under how many conditions it breaks."""
    titles = [
        "model",
        "pictures",
        "IoU",
        "within 30°",
        "median error",
        "confidence",
        "refused",
        "wrong",
        "of these, sure",
        "breaks",
    ]
    rows = []
    for name, model in models.items():
        clean = model["clean"]
        broken = sum(condition["breaks_at"] is not None for condition in model["conditions"].values())
        rows.append(
            [
                name,
                str(clean["pictures"]),
                number(clean["iou"]),
                number(clean["symmetric_azimuth_accuracy"]),
                f"{clean['symmetric_azimuth_error_degrees']:.1f}°",
                number(clean["confidence"]),
                percent(clean["refused"]),
                percent(1 - clean["symmetric_azimuth_accuracy"]),
                percent(clean["sure_of_wrong"]),
                f"{broken} of {len(model['conditions'])}",
            ]
        )
    return markdown_table(titles, rows)


def conditions_table(model: Results) -> str:
    """Where it breaks, and what is told there; where it does not, the worst that was tried."""
    titles = [
        "condition",
        "severities",
        "breaks at",
        "IoU",
        "within 30°",
        "confidence",
        "score",
        "refused",
        "deceptive",
    ]
    rows = []
    for condition in model["conditions"].values():
        points, at = condition["points"], condition["breaks_at"]
        shown = next((point for point in points if point["severity"] == at), points[-1])
        rows.append(
            [
                condition["title"],
                f"{points[0]['severity']:g} to {points[-1]['severity']:g} {condition['unit']}",
                "–" if at is None else f"**{at:g}**",
                number(shown["iou"]),
                number(shown["symmetric_azimuth_accuracy"]),
                number(shown["confidence"]),
                f"{shown['out_of_class_score']:.1f}",
                percent(shown["refused"]),
                percent(shown["deceptive"]),
            ]
        )
    return markdown_table(titles, rows)


def uploads_table(models: Results) -> str:
    """At the worst severity of each condition, what a sender of such pictures gets."""
    titles = ["condition, at its worst", *(f"{name}: right / wrong / refused" for name in models)]
    first = next(iter(models.values()))
    rows = []
    for name, condition in first["conditions"].items():
        cells = []
        for model in models.values():
            sent = model["conditions"][name]["points"][-1]["upload"]
            refused = sent["refused_at_once"] + sent["refused"]
            cells.append(" / ".join(percent(value) for value in (sent["right"], sent["wrong"], refused)))
        rows.append([f"{condition['title']}, {condition['points'][-1]['severity']:g}", *cells])
    return markdown_table(titles, rows)


def deceptive_table(models: Results) -> str:
    """The conditions under which most answers are wrong, sure and given, each at its worst severity for that."""
    titles = ["model", "condition", "at", "deceptive", "wrong", "confidence", "refused", "sent as a file: deceptive"]
    rows = []
    for name, model in models.items():
        worst = [
            (condition, max(condition["points"], key=lambda point: float(point["deceptive"])))
            for condition in model["conditions"].values()
        ]
        for condition, point in sorted(worst, key=lambda pair: -float(pair[1]["deceptive"]))[:_WORST]:
            rows.append(
                [
                    name,
                    condition["title"],
                    f"{point['severity']:g} {condition['unit']}",
                    percent(point["deceptive"]),
                    percent(1 - point["symmetric_azimuth_accuracy"]),
                    number(point["confidence"]),
                    percent(point["refused"]),
                    percent(point["upload"]["deceptive"]),
                ]
            )
    return markdown_table(titles, rows)


def risk_table(models: Results) -> str:
    """Areas under risk-coverage curves, by what the answers are ordered by."""
    titles = ["model", "pictures", "loss", "ideal", "by confidence", "by score", "by both", "random", "gained by both"]
    rows = []
    for name, model in models.items():
        for pictures, title in (("clean", "untouched"), ("all", "all")):
            for loss, label in (("wrong_azimuth", "azimuth"), ("one_minus_iou", "1 − IoU")):
                risk = model["risk"][pictures][loss]
                figures = [risk[f"aurc_{order}"] for order in ("ideal", "confidence", "score", "combined", "random")]
                gained = "–" if risk["gained_combined"] is None else percent(risk["gained_combined"])
                rows.append([name, title, label, *(f"{figure:.3f}" for figure in figures), gained])
    return markdown_table(titles, rows)


def reliability_table(models: Results) -> str:
    """How often answers of each range of confidence are right, over all pictures."""
    titles = ["model", "confidence", "pictures", "mean confidence", "right", "wrong, but refused"]
    rows = [
        [
            name,
            " to ".join(f"{edge:g}" for edge in part["confidence"]),
            f"{part['pictures']:,}",
            number(part["mean_confidence"]),
            number(part["right"]),
            percent(part["wrong_and_refused"]),
        ]
        for name, model in models.items()
        for part in model["reliability"]["all"]
    ]
    return markdown_table(titles, rows)


def groups_table(model: Results) -> str:
    """Untouched pictures by what they show."""
    titles = ["told apart by", "group", "pictures", "IoU", "within 30°", "median error", "confidence", "deceptive"]
    names = {"side": "turned from front or back", "thinness": "share of voxels at the surface", "symmetry": "symmetry"}
    rows = [
        [
            names[kind],
            part["group"],
            str(part["pictures"]),
            number(part["iou"]),
            number(part["symmetric_azimuth_accuracy"]),
            f"{part['symmetric_azimuth_error_degrees']:.1f}°",
            number(part["confidence"]),
            percent(part["deceptive"]),
        ]
        for kind, parts in model["groups"].items()
        for part in parts
    ]
    return markdown_table(titles, rows)


def others_table(models: Results) -> str:
    """What each model says of each other class."""
    categories = dict.fromkeys(category for model in models.values() for category in model["other_classes"])
    titles = ["pictures of", *(f"{name}: refused / answered and sure / confidence" for name in models)]
    rows = []
    for category in categories:
        cells = []
        for model in models.values():
            told = model["other_classes"].get(category)
            cells.append(
                "–"
                if told is None
                else f"{percent(told['refused'])} / {percent(told['sure'])} / {number(told['confidence'])}"
            )
        rows.append([category, *cells])
    return markdown_table(titles, rows)


def markdown_table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [f"| {' | '.join(titles)} |", f"|{'---|' * len(titles)}"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def number(value: float) -> str:
    """With two digits."""
    return f"{value:.2f}"


def percent(value: float | None, digits: int = 0) -> str:
    """A share in percent; a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}%}".replace("%", " %")
