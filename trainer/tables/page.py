"""A table as people and as programs read it: our figures beside the paper's."""

import datetime
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import torch

from trainer.mapping import to_mapping
from trainer.tables.results import NEAR_THE_BEST, Ordering, Result, mean_figure, orderings_of, scatter_of
from trainer.tables.setting import setting_name
from trainer.tables.statistics import Mean
from trainer.tables.study import Study
from trainer.tables.table import Figure, Table

_UNKNOWN = "–"
_USUAL_SEEDS = 3
_HEADINGS: dict[Figure, str] = {
    "iou": "IoU",
    "err": "error",
    "acc": "within 30°",
    "iou_pose_given": "IoU, poses told",
}
_PAPER_S = (
    "The paper's figures stand on ShapeNet, on pictures of 128 × 96 and on long training on a GPU, ours on what is "
    "said above: compare orderings, not values."
)


def as_markdown(
    table: Table, study: Study, classes: Sequence[str], results: Sequence[Result], failures: Sequence[str]
) -> str:
    """The page that `trainer table` writes and prints."""
    heads = [head for figure in table.figures for head in (_HEADINGS[figure], *_beside(table, "paper"))]
    lines = [
        f"# {table.title}",
        "",
        _conditions(study, results),
        "",
        f"| class | setting | {' | '.join(heads)} | steps | minutes |",
        "|---" * (len(heads) + 4) + "|",
    ]
    for category in classes:
        for row in table.rows:
            known = row.paper.get(category, {})
            if row.setting is None and not known:
                continue
            told = [
                text
                for figure in table.figures
                for text in (
                    _told(mean_figure(results, category, row.name, figure), figure),
                    *_beside(table, _number(known.get(figure), figure)),
                )
            ]
            lines.append(f"| {category} | {row.name} | {' | '.join(told)} | {_effort(results, category, row.name)} |")
    if len(classes) > 1:
        lines += _averages(table, classes, results)
    lines += ["", "± is Student's 95 % interval over seeds." + (f" {_PAPER_S}" if _beside(table, "paper") else "")]
    lines += _scatter(table, classes, results)
    if table.comparisons:
        lines += ["", *_orderings(table, orderings_of(table, results))]
    if failures:
        lines += ["", f"{len(failures)} trainings failed:", "", *(f"- {sentence}" for sentence in failures)]
    return "\n".join(lines) + "\n"


def _beside(table: Table, text: str) -> tuple[str, ...]:
    """A column of the paper's, where it has figures for this table."""
    return (text,) if any(row.paper for row in table.rows) else ()


def _conditions(study: Study, results: Sequence[Result]) -> str:
    recipe, loss = study.recipe, study.recipe.loss
    length = f"{recipe.optimiser.steps} steps" if study.seconds is None else f"{study.seconds / 60:.1f} minutes"
    best = f", the best of {study.starts} starts" if study.starts > 1 else ""
    seeds = ", ".join(map(str, sorted({result.entry.cell.seed for result in results}))) or "–"
    return (
        f"Recipe `{study.recipe_name}`: {recipe.width} × {recipe.height}, batches of {recipe.optimiser.batch_size}, "
        f"objective {loss.objective}; {length} each{best}; {study.instances or 'all'} {study.objects} objects a class, "
        f"judged on {study.test_instances} others in {study.test_views} pictures each; seeds {seeds}."
    )


def _told(mean: Mean | None, figure: Figure) -> str:
    if mean is None:
        return _UNKNOWN
    margin = "" if mean.margin is None else f" ± {_number(mean.margin, figure)}"
    return _number(mean.value, figure) + margin


def _number(value: float | None, figure: Figure) -> str:
    if value is None:
        return _UNKNOWN
    return f"{value:.1f}°" if figure == "err" else f"{value:.2f}"


def _effort(results: Sequence[Result], category: str, row: str) -> str:
    """Steps and minutes of a training, from the least to the most."""
    own = [result for result in results if (result.entry.cell.category, result.entry.row.name) == (category, row)]
    if not own:
        return f"{_UNKNOWN} | {_UNKNOWN}"
    steps, minutes = sorted(result.steps for result in own), sorted(result.seconds / 60 for result in own)
    span = [f"{steps[0]}", f"{steps[-1]}"], [f"{minutes[0]:.1f}", f"{minutes[-1]:.1f}"]
    return " | ".join(first if first == last else f"{first}–{last}" for first, last in span)


def _averages(table: Table, classes: Sequence[str], results: Sequence[Result]) -> list[str]:
    """Each row's mean over the classes, where it is known of all of them."""
    lines = []
    for row in table.rows:
        told = []
        for figure in table.figures:
            ours = [mean_figure(results, category, row.name, figure) for category in classes]
            paper = [row.paper.get(category, {}).get(figure) for category in classes]
            told += [
                _number(_mean_of_all([None if mean is None else mean.value for mean in ours]), figure),
                *_beside(table, _number(_mean_of_all(paper), figure)),
            ]
        if any(text != _UNKNOWN for text in told):
            lines.append(f"| *mean* | {row.name} | {' | '.join(told)} | | |")
    return lines


def _mean_of_all(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known and len(known) == len(values) else None


def _scatter(table: Table, classes: Sequence[str], results: Sequence[Result]) -> list[str]:
    """How far seeds lie apart, where there are more of them than usual."""
    found = [(name, row.name, scatter_of(results, name, row.name)) for name in classes for row in table.rows]
    rows = [
        f"| {category} | {row} | {scatter.best:.2f} | {scatter.median:.2f} | {scatter.worst:.2f} | "
        f"{scatter.near} of {scatter.size} |"
        for category, row, scatter in found
        if scatter is not None and scatter.size > _USUAL_SEEDS
    ]
    if not rows:
        return []
    head = f"| class | setting | best IoU | median | worst | within {NEAR_THE_BEST:g} of the best |"
    return ["", "## Seed by seed", "", head, "|---|---|---|---|---|---|", *rows]


def _orderings(table: Table, orderings: Sequence[Ordering]) -> list[str]:
    classes = dict.fromkeys(category for ordering in orderings for category in ordering.by_class)
    of_paper = any(ordering.paper is not None for ordering in orderings)
    heads = ["better, says the paper", "than", "paper"] if of_paper else ["better?", "than"]
    lines = [
        "## The paper's orderings" if of_paper else "## What each is worth",
        "",
        f"| {' | '.join(heads)} | ours | pairs | verdict | {' | '.join(classes) or '–'} |",
        "|---" * (len(heads) + 3 + max(1, len(classes))) + "|",
    ]
    for ordering in orderings:
        ours = _UNKNOWN if ordering.ours is None else _signed(ordering.ours)
        pairs = _UNKNOWN if ordering.ours is None else f"{ordering.agreeing} of {ordering.ours.size}"
        own = [_signed(ordering.by_class[name]) if name in ordering.by_class else _UNKNOWN for name in classes]
        paper = [_UNKNOWN if ordering.paper is None else f"{ordering.paper:+.2f}"] if of_paper else []
        told = [ordering.comparison.better, ordering.comparison.worse, *paper, ours, pairs, ordering.verdict]
        lines.append(f"| {' | '.join([*told, *(own or [_UNKNOWN])])} |")
    paper_s = (
        " The paper's differences are means over the classes of its own table, some with other parameterisations than "
        "here."
    )
    return [
        *lines,
        "",
        "Differences of IoU, at the same class and seed; ± is Student's 95 % interval over all such pairs (in a "
        "class's own column, over its seeds). *Found* and *reversed* mean that the interval excludes 0."
        f"{paper_s if of_paper else ''}",
    ]


def _signed(mean: Mean) -> str:
    margin = "" if mean.margin is None else f" ± {mean.margin:.3f}"
    return f"{mean.value:+.3f}{margin}"


def as_json(
    table: Table, study: Study, classes: Sequence[str], results: Sequence[Result], failures: Sequence[str]
) -> dict[str, Any]:
    """All of the page's figures and each cell's own, with what they were measured on."""
    figures = [
        {
            "class": category,
            "row": row.name,
            "figure": figure,
            "paper": row.paper.get(category, {}).get(figure),
            "ours": None if (mean := mean_figure(results, category, row.name, figure)) is None else mean._asdict(),
        }
        for category in classes
        for row in table.rows
        for figure in table.figures
    ]
    return {
        "table": table.name,
        "title": table.title,
        "label": table.label,
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": {"system": f"{platform.system()} {platform.machine()}", "cores": os.cpu_count()},
        "versions": {"python": platform.python_version(), "torch": torch.__version__},
        "study": _study(study),
        "figures": figures,
        "orderings": [_plain(ordering) for ordering in orderings_of(table, results)],
        "cells": [
            {
                "row": result.entry.row.name,
                "figures": list(result.entry.figures),
                "class": result.entry.cell.category,
                "seed": result.entry.cell.seed,
                "setting": asdict(result.entry.cell.setting),
                "name": setting_name(result.entry.cell.setting),
                "test_views": result.entry.row.test_views,
                "steps": result.steps,
                "seconds": result.seconds,
                "metrics": result.metrics,
            }
            for result in results
        ],
        "failures": list(failures),
    }


def _study(study: Study) -> dict[str, Any]:
    return {
        "recipe_name": study.recipe_name,
        "recipe": to_mapping(study.recipe),
        "objects": study.objects,
        "instances": study.instances,
        "test_instances": study.test_instances,
        "test_views": study.test_views,
        "seconds": study.seconds,
        "starts": study.starts,
    }


def _plain(ordering: Ordering) -> dict[str, Any]:
    return {
        "better": ordering.comparison.better,
        "worse": ordering.comparison.worse,
        "paper": ordering.paper,
        "ours": None if ordering.ours is None else ordering.ours._asdict(),
        "by_class": {category: mean._asdict() for category, mean in ordering.by_class.items()},
        "agreeing": ordering.agreeing,
        "verdict": ordering.verdict,
    }
