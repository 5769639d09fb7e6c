"""From trainings that are done to a report: judged, exported, timed."""

import datetime
import os
import platform
from dataclasses import replace
from pathlib import Path

import onnxruntime
import torch

from trainer.errors import DataError
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.subject import Subject, from_checkpoint
from trainer.frontier.accuracy import Run, evaluation_of, judged
from trainer.frontier.bundles import exported
from trainer.frontier.costs import Architecture, Cost, architecture_of, costs_of
from trainer.frontier.plan import DEFAULT, Plan, Point
from trainer.frontier.refinement import refinement_ms
from trainer.frontier.report import Machine, Report, measured
from trainer.frontier.trainings import Trained, trained_points
from trainer.tables.cells import Cell
from trainer.tables.study import Study
from trainer.training.checkpoint import load_checkpoint


def measure(plan: Plan, study: Study, budget: str) -> Report:
    """A report on the points whose trainings are done.

    What cannot be exported or judged is left out, and the report says why. Raises DataError where that is the default.
    """
    there: list[tuple[Trained, list[Run], float]] = []
    bundles: dict[Architecture, Path] = {}
    skipped: list[str] = []
    for trained in trained_points(plan):
        cells = [cell for cell in trained.cells if study.is_trained(cell)]
        if not cells:
            skipped.append(f"{trained.point.choice.name}, {trained.category}: not trained")
            continue
        try:
            architecture = architecture_of(trained.point)
            if architecture not in bundles:
                bundles[architecture] = exported(study, cells[0], trained.point.choice.bundle)
            subjects = [_subject(study, trained.point, cell) for cell in cells]
            runs = [judged(study, cell, *subject) for cell, subject in zip(cells, subjects, strict=True)]
            there.append((trained, runs, _refinement_ms(study, cells[0], *subjects[0])))
        except DataError as error:
            skipped.append(f"{trained.point.choice.name}, {trained.category}: {error}")
    for category in {trained.category for trained, _, _ in there}:
        if not any((t.point.choice.name, t.category) == (DEFAULT, category) for t, _, _ in there):
            raise DataError(
                f"Expected the point {DEFAULT} of {category}, which others are compared with, found: {skipped}"
            )
    costs = costs_of(bundles, study.root)
    points = tuple(
        measured(trained.point, trained.category, runs, _dearer(costs[architecture_of(trained.point)], added))
        for trained, runs, added in there
    )
    date = datetime.datetime.now(datetime.UTC).date().isoformat()
    return Report(budget, date, _machine(), plan.scale, points, tuple(skipped))


def _subject(study: Study, point: Point, cell: Cell) -> tuple[Subject, str]:
    """(what is judged, by what its files are told from the training's own)"""
    choice = point.choice
    if choice.bundle == "float32" and not choice.refine:
        return from_checkpoint(load_checkpoint(study.run_directory(cell))), ""
    subject = replace(from_bundle(exported(study, cell, choice.bundle)), refinement=choice.refine)
    return subject, f"{choice.bundle}-refined-{choice.refine}"


def _refinement_ms(study: Study, cell: Cell, subject: Subject, kind: str) -> float:
    """What refinement adds to an answer's latency; nothing where there is none."""
    if not subject.refinement:
        return 0.0
    file = evaluation_of(study, cell, kind) / "refinement.json"
    return refinement_ms(subject, study.test_pictures(cell).path, file)


def _dearer(cost: Cost, added_ms: float) -> Cost:
    return replace(cost, latency_ms=round(cost.latency_ms + added_ms, 4))


def _machine() -> Machine:
    information = Path("/proc/cpuinfo")
    lines = information.read_text().splitlines() if information.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return Machine(
        cpu=names[0] if names else platform.processor() or platform.machine(),
        cores=len(os.sched_getaffinity(0)),
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        torch=torch.__version__,
        onnxruntime=onnxruntime.__version__,
    )
