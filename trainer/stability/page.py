"""What was found, as tables for people; and pages whose every figure is filled in from the results.

`results` are those of stability.json throughout.
"""

import re
from collections.abc import Sequence

from trainer.errors import ConfigError
from trainer.stability.tables import (
    Results,
    clean_table,
    conditions_table,
    deceptive_table,
    groups_table,
    markdown_table,
    number,
    others_table,
    percent,
    reliability_table,
    risk_table,
    uploads_table,
)


def tables_of(results: Results) -> dict[str, str]:
    """Tables by name, as far as their figures are there: `clean`, `uploads`, `deceptive`, `risk`, `reliability`,
    `others`, `trainings`, `rasteriser`; `conditions_MODEL` and `groups_MODEL` of each model."""
    models = results["models"]
    found: dict[str, str] = {}
    if models:
        found |= {
            "clean": clean_table(models),
            "uploads": uploads_table(models),
            "deceptive": deceptive_table(models),
            "risk": risk_table(models),
            "reliability": reliability_table(models),
            "others": others_table(models),
        }
        found |= {f"conditions_{name}": conditions_table(model) for name, model in models.items()}
        found |= {f"groups_{name}": groups_table(model) for name, model in models.items()}
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
        text = template.format(tables=tables_of(results), **results)
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise ConfigError(
            f"Expected a page whose {{…}} name figures of stability.json, found {type(error).__name__}: {error}. "
            "Correct the page, or examine what it tells of: all its models, and all parts."
        ) from error
    # Python writes percents without a space.
    return re.sub(r"(?<=\d)%", " %", text)


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
                    number(figures["iou"]),
                    number(figures["symmetric_azimuth_accuracy"]),
                    number(figures["confidence"]),
                    "–" if figures["sure_of_wrong"] is None else percent(figures["sure_of_wrong"]),
                ]
            )
            ends = "yes" if run["finished"] else f"no, after {run['step']} steps"
            nats = "–" if run["shape_nats"] is None else f"{run['shape_nats']:.1f}"
            rows.append([regime["title"], str(run["seed"]), ends, str(run["skipped_steps"]), *told, nats])
    return markdown_table(titles, rows)


def _rasteriser(kinds: Results) -> str:
    titles = ["scene", "angle", "picture, exact", "contours alone", "gradient, exact", "contours alone"]
    rows = [
        [
            kind["title"],
            f"{point['angle_degrees']:g}°",
            *(f"{point[f'picture_error_{crease}']:.2f}" for crease in ("exact", "contours")),
            *(percent(point[f"gradient_error_{crease}"], 1) for crease in ("exact", "contours")),
        ]
        for kind in kinds.values()
        for point in kind["points"]
    ]
    return markdown_table(titles, rows)
