"""Severity curves: how a model fares as a condition grows worse, and where it breaks."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from trainer.evaluation.pictures import Truth
from trainer.stability.answers import Answers, Examinee, answers, answers_to_uploads, figures_of, upload_figures
from trainer.stability.conditions import Condition, Sitting, pictures_under
from trainer.stability.objects import pictures_of

LEAST_IOU, LEAST_ACCURACY = 0.8, 0.5
"""Shares of the untouched pictures' figures below which a model counts as broken."""


class Curve(NamedTuple):
    """A model under one condition."""

    figures: dict[str, Any]
    """Severities with their figures, and where it breaks."""
    damaged: tuple[Answers, ...]
    """At each severity but the first."""


def curve(
    examined: Examinee,
    condition: Condition,
    sitting: Sitting,
    truth: tuple[Truth, ...],
    severities: Sequence[float],
    seed: int,
) -> Curve:
    """All severities of a condition, the first of which is none."""
    points, told = [], []
    for severity in severities:
        pictures = pictures_of(pictures_under(condition, sitting, severity, seed), sitting.shown, truth)
        found = answers(examined, pictures)
        sent = upload_figures(answers_to_uploads(examined, pictures), len(pictures.codes))
        points.append({"severity": severity, **figures_of(found), "upload": sent})
        told.append(found)
    figures = {"title": condition.title, "unit": condition.unit, "breaks_at": breaks_at(points), "points": points}
    return Curve(figures, tuple(told[1:]))


def breaks_at(points: Sequence[dict[str, Any]]) -> float | None:
    """The first severity at which IoU is below LEAST_IOU, or the share of right azimuths below LEAST_ACCURACY, of what
    the first point has; None where there is none."""
    clean = points[0]
    for point in points[1:]:
        if (
            point["iou"] < LEAST_IOU * clean["iou"]
            or point["symmetric_azimuth_accuracy"] < LEAST_ACCURACY * clean["symmetric_azimuth_accuracy"]
        ):
            return float(point["severity"])
    return None
