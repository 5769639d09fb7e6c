"""All that is asked of one model: every condition, every group of pictures, other classes, and its confidence."""

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from trainer.data.shapes.catalogue import CATEGORIES
from trainer.evaluation.pictures import Validation
from trainer.evaluation.subject import predict
from trainer.stability.answers import Answers, Examinee, answers, examinee, joined, trust_of
from trainer.stability.budget import Budget, severities_of
from trainer.stability.conditions import CONDITIONS, Sitting
from trainer.stability.curves import curve, point
from trainer.stability.explanation import out_of_class_scores, rerender_errors
from trainer.stability.groups import groups
from trainer.stability.models import Contestant
from trainer.stability.objects import TEST_SEED, VALIDATION_SEED, exhibits, photographs, pictures_of, truths
from trainer.stability.risk import reliability_of, risk_of

# Poses of the pictures of other classes: any seed but those that the class's own model was made with.
_OTHERS_SEED = 3


def examine(contestant: Contestant, budget: Budget, report: Callable[[str], None]) -> dict[str, Any]:
    """What is found of a model, as JSON holds it; `report` is told what comes next.

    Raises CheckpointError where the model answers no numbers, DataError where it explains all pictures equally well.
    """
    began, subject = time.monotonic(), contestant.subject
    report("test objects")
    shown = tuple(exhibits(subject.category, TEST_SEED, budget.objects, budget.views))
    truth = truths(shown)
    examined = examinee(contestant.name, subject, _validation(contestant, budget), contestant.held_out)
    sitting = Sitting(shown, subject.scene, photographs(shown, subject.scene))
    pictures = pictures_of(sitting.codes, shown, truth)
    clean = answers(examined, pictures)
    untouched = point(examined, pictures, clean)
    curves, told = {}, [clean]
    for condition in CONDITIONS:
        report(condition.title)
        severities = severities_of(budget, condition.severities)
        found = curve(examined, condition, sitting, truth, severities, untouched, TEST_SEED)
        curves[condition.name] = found.figures
        told += found.damaged
    report("groups")
    all_views = pictures_of(photographs(shown, subject.scene, budget.views), shown, truth, budget.views)
    report("other classes")
    everything = joined(told)
    return {
        "category": subject.category,
        "digest": contestant.digest,
        "training": subject.training,
        "azimuth_offset_degrees": round(math.degrees(examined.offset), 4),
        "held_out": {way: errors._asdict() for way, errors in examined.yardstick._asdict().items()},
        "held_out_measured": contestant.held_out is None,
        "clean": untouched,
        "conditions": curves,
        "groups": groups(answers(examined, all_views), all_views),
        "other_classes": _others(examined, budget),
        "risk": {"clean": risk_of(clean), "all": risk_of(everything)},
        "reliability": {"clean": reliability_of(clean), "all": reliability_of(everything)},
        "seconds": round(time.monotonic() - began, 1),
    }


def _validation(contestant: Contestant, budget: Budget) -> Validation:
    shown = exhibits(contestant.subject.category, VALIDATION_SEED, budget.validation_objects)
    azimuths = np.array([exhibit.azimuths[0] for exhibit in shown])
    return Validation(photographs(shown, contestant.subject.scene), azimuths, np.arange(len(shown)), None)


def _others(examined: Examinee, budget: Budget) -> dict[str, dict[str, Any]]:
    """What the model says of objects of each other class: nothing of it is right."""
    return {
        category: {"pictures": budget.others, **trust_of(_strangers(examined, category, budget))}
        for category in CATEGORIES
        if category != examined.subject.category
    }


def _strangers(examined: Examinee, category: str, budget: Budget) -> Answers:
    codes = photographs(exhibits(category, _OTHERS_SEED, budget.others), examined.subject.scene)
    prediction = predict(examined.subject, codes)
    errors = rerender_errors(examined.subject, prediction, codes)
    unknown = np.full(len(codes), np.nan)
    return Answers(
        overlaps=unknown,
        errors=unknown,
        plain_errors=unknown,
        confidences=prediction.probabilities.amax(1).double().numpy(),
        rerender_errors=errors,
        scores=out_of_class_scores(errors, examined.yardstick.framed),
        objects=np.arange(len(codes)),
    )
