"""Severity curves: how a model fares as a condition grows worse, and where it breaks."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from trainer.evaluation.pictures import Pictures, Truth
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
    untouched: dict[str, Any],
    seed: int,
) -> Curve:
    """All severities of a condition; at the first, figures are those of the `untouched` pictures."""
    points, told = [{"severity": severities[0], **untouched}], []
    for severity in severities[1:]:
        pictures = pictures_of(pictures_under(condition, sitting, severity, seed), sitting.shown, truth)
        told.append(answers(examined, pictures))
        points.append({"severity": severity, **point(examined, pictures, told[-1])})
    figures = {"title": condition.title, "unit": condition.unit, "breaks_at": breaks_at(points), "points": points}
    return Curve(figures, tuple(told))


def point(examined: Examinee, pictures: Pictures, told: Answers) -> dict[str, Any]:
    """Figures of pictures as they are, to which the model said `told`, and of the same pictures when they are sent."""
    sent = upload_figures(answers_to_uploads(examined, pictures), len(pictures.codes))
    return {**figures_of(told), "upload": sent}


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
