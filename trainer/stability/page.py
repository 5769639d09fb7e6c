"""What was found, as tables for people; and pages whose every figure is filled in from the results.

`results` are those of stability.json throughout.
"""

from collections.abc import Sequence
from typing import Any

from trainer.errors import ConfigError

Results = dict[str, Any]


def tables_of(results: Results) -> dict[str, str]:
    """Tables by name, as far as their figures are there: `clean`, `uploads`, `risk`, `reliability`, `others`,
    `trainings`, `rasteriser`; `conditions_MODEL` and `groups_MODEL` of each model."""
    models = results["models"]
    found: dict[str, str] = {}
    if models:
        found |= {
            "clean": _clean(models),
            "uploads": _uploads(models),
            "risk": _risk(models),
            "reliability": _reliability(models),
            "others": _others(models),
        }
        found |= {f"conditions_{name}": _conditions(model) for name, model in models.items()}
        found |= {f"groups_{name}": _groups(model) for name, model in models.items()}
    if results["trainings"]:
        found["trainings"] = _trainings(results["trainings"])
    if results["rasteriser"]:
        found["rasteriser"] = _rasteriser(results["rasteriser"])
    return found


def page_of(results: Results, images: Sequence[str]) -> str:
    """All tables and charts, a heading each."""
    lines = [f"# Stability ({results['budget']['name']} budget)"]
    for name, table in tables_of(results).items():
        lines += ["", f"## {name.replace('_', ', ')}", "", table]
    lines += [f"\n![{name}]({name})" for name in images]
    return "\n".join(lines) + "\n"


def filled(template: str, results: Results) -> str:
    """A text in which `{tables[NAME]}` and such as `{models[car][clean][iou]:.2f}` stand for tables and figures.

    Raises ConfigError where one of them is not there.
    """
    try:
        return template.format(tables=tables_of(results), **results)
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise ConfigError(
            f"Expected a page whose {{…}} name figures of stability.json, found {type(error).__name__}: {error}. "
            "Correct the page, or examine what it tells of: all its models, and all parts."
        ) from error


def _clean(models: Results) -> str:
    titles = [
        "model",
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
                _number(clean["iou"]),
                _number(clean["symmetric_azimuth_accuracy"]),
                f"{clean['symmetric_azimuth_error_degrees']:.1f}°",
                _number(clean["confidence"]),
                _percent(clean["refused"]),
                _percent(1 - clean["symmetric_azimuth_accuracy"]),
                _percent(clean["sure_of_wrong"]),
                f"{broken} of {len(model['conditions'])}",
            ]
        )
    return _table(titles, rows)


def _conditions(model: Results) -> str:
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
                _number(shown["iou"]),
                _number(shown["symmetric_azimuth_accuracy"]),
                _number(shown["confidence"]),
                f"{shown['out_of_class_score']:.1f}",
                _percent(shown["refused"]),
                _percent(shown["deceptive"]),
            ]
        )
    return _table(titles, rows)


def _uploads(models: Results) -> str:
    """At the worst severity of each condition, what a sender of such pictures gets."""
    titles = ["condition, at its worst", *(f"{name}: right / wrong / refused" for name in models)]
    first = next(iter(models.values()))
    rows = []
    for name, condition in first["conditions"].items():
        cells = []
        for model in models.values():
            sent = model["conditions"][name]["points"][-1]["upload"]
            refused = sent["refused_at_once"] + sent["refused"]
            cells.append(" / ".join(_percent(value) for value in (sent["right"], sent["wrong"], refused)))
        rows.append([f"{condition['title']}, {condition['points'][-1]['severity']:g}", *cells])
    return _table(titles, rows)


def _risk(models: Results) -> str:
    titles = ["model", "pictures", "loss", "ideal", "by confidence", "by score", "by both", "random", "gained by both"]
    rows = []
    for name, model in models.items():
        for pictures, title in (("clean", "untouched"), ("all", "all")):
            for loss, label in (("wrong_azimuth", "azimuth"), ("one_minus_iou", "1 − IoU")):
                risk = model["risk"][pictures][loss]
                figures = [risk[f"aurc_{order}"] for order in ("ideal", "confidence", "score", "combined", "random")]
                gained = "–" if risk["gained_combined"] is None else _percent(risk["gained_combined"])
                rows.append([name, title, label, *(f"{figure:.3f}" for figure in figures), gained])
    return _table(titles, rows)


def _reliability(models: Results) -> str:
    titles = ["model", "confidence", "pictures", "mean confidence", "right", "wrong, but refused"]
    rows = [
        [
            name,
            " to ".join(f"{edge:g}" for edge in part["confidence"]),
            f"{part['pictures']:,}",
            _number(part["mean_confidence"]),
            _number(part["right"]),
            _percent(part["wrong_and_refused"]),
        ]
        for name, model in models.items()
        for part in model["reliability"]["all"]
    ]
    return _table(titles, rows)


def _groups(model: Results) -> str:
    titles = ["told apart by", "group", "pictures", "IoU", "within 30°", "median error", "confidence", "deceptive"]
    names = {"side": "turned from front or back", "thinness": "share of voxels at the surface", "symmetry": "symmetry"}
    rows = [
        [
            names[kind],
            part["group"],
            str(part["pictures"]),
            _number(part["iou"]),
            _number(part["symmetric_azimuth_accuracy"]),
            f"{part['symmetric_azimuth_error_degrees']:.1f}°",
            _number(part["confidence"]),
            _percent(part["deceptive"]),
        ]
        for kind, parts in model["groups"].items()
        for part in parts
    ]
    return _table(titles, rows)


def _others(models: Results) -> str:
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
                else f"{_percent(told['refused'])} / {_percent(told['sure'])} / {_number(told['confidence'])}"
            )
        rows.append([category, *cells])
    return _table(titles, rows)


def _trainings(trainings: Results) -> str:
    titles = [
        "training",
        "seed",
        "ends",
        "skipped steps",
        "IoU",
        "within 30°",
        "confidence",
        "sure of wrong",
        "code, nats",
    ]
    rows = []
    for regime in trainings.values():
        for run in regime["seeds"]:
            figures = run["figures"]
            told = (
                ["–"] * 4
                if figures is None
                else [
                    _number(figures["iou"]),
                    _number(figures["symmetric_azimuth_accuracy"]),
                    _number(figures["confidence"]),
                    "–" if figures["sure_of_wrong"] is None else _percent(figures["sure_of_wrong"]),
                ]
            )
            ends = "yes" if run["finished"] else f"no, after {run['step']} steps"
            nats = "–" if run["shape_nats"] is None else f"{run['shape_nats']:.1f}"
            rows.append([regime["title"], str(run["seed"]), ends, str(run["skipped_steps"]), *told, nats])
    return _table(titles, rows)


def _rasteriser(kinds: Results) -> str:
    titles = ["scene", "angle", "picture, exact", "contours alone", "gradient, exact", "contours alone"]
    rows = [
        [
            kind["title"],
            f"{point['angle_degrees']:g}°",
            *(f"{point[f'picture_error_{crease}']:.2f}" for crease in ("exact", "contours")),
            *(_percent(point[f"gradient_error_{crease}"], 1) for crease in ("exact", "contours")),
        ]
        for kind in kinds.values()
        for point in kind["points"]
    ]
    return _table(titles, rows)


def _table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(titles)} |", f"|{'---|' * len(titles)}"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def _number(value: float) -> str:
    return f"{value:.2f}"


def _percent(value: float | None, digits: int = 0) -> str:
    return "–" if value is None else f"{value:.{digits}%}".replace("%", " %")
