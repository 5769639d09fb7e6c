"""Figures are the judge's on untouched pictures, and tell wrong, sure and refused answers apart."""

import numpy as np
import pytest

from trainer.evaluation.pictures import Truth, Validation
from trainer.evaluation.protocol import judge
from trainer.evaluation.subject import Subject
from trainer.stability.answers import (
    Answers,
    Examinee,
    answers,
    answers_to_uploads,
    examinee,
    figures_of,
    joined,
    trust_of,
    upload_figures,
)
from trainer.stability.conditions import Sitting
from trainer.stability.explanation import Errors, Yardstick
from trainer.stability.objects import pictures_of


def answers_of(errors_degrees: list[float], confidences: list[float], scores: list[float]) -> Answers:
    errors, told = np.radians(errors_degrees), np.array(confidences)
    overlaps = np.linspace(0, 1, len(errors))
    return Answers(overlaps, errors, errors, told, np.array(scores) / 10, np.array(scores), np.arange(len(errors)))


def test_untouched_pictures_have_the_judge_s_figures(
    examined: Examinee, subject: Subject, sitting: Sitting, truth: tuple[Truth, ...], validation: Validation
) -> None:
    pictures = pictures_of(sitting.codes, sitting.shown, truth)
    report = judge(subject, pictures, validation).report
    found = figures_of(answers(examined, pictures))
    assert report.aligned is not None
    assert report.azimuth_offset_degrees == pytest.approx(np.degrees(examined.offset))
    for name in ("iou", "symmetric_azimuth_accuracy", "azimuth_accuracy"):
        assert found[name] == pytest.approx(getattr(report.aligned, name).value, abs=1e-4)
    for name in ("symmetric_azimuth_error_degrees", "azimuth_error_degrees"):
        assert found[name] == pytest.approx(getattr(report.aligned, name).value, abs=1e-3)
    assert found["pictures"] == len(pictures.codes)


def test_wrong_sure_and_refused() -> None:
    told = answers_of([10, 40, 40, 40], [0.99, 0.99, 0.99, 0.5], [0, 0, 3, 0])
    assert told.wrong.tolist() == [False, True, True, True]
    assert told.refused.tolist() == [False, False, True, False]
    assert told.deceptive.tolist() == [False, True, False, False]
    figures = figures_of(told)
    assert figures["deceptive"] == 0.25
    assert figures["sure_of_wrong"] == pytest.approx(2 / 3, abs=1e-4)
    assert figures["refused"] == 0.25
    assert figures["sure"] == 0.5
    assert figures["iou"] == 0.5
    assert joined([told, told]).wrong.tolist() == 2 * told.wrong.tolist()
    assert trust_of(told.of(np.zeros(4, bool)))["confidence"] is None


def test_shares_of_what_was_sent_sum_to_one() -> None:
    figures = upload_figures(answers_of([10, 40, 40], [0.99, 0.99, 0.99], [0, 0, 3]), 4)
    assert figures == {
        "refused_at_once": 0.25,
        "refused": 0.25,
        "right": 0.25,
        "wrong": 0.25,
        "deceptive": 0.25,
        "confidence": 0.99,
    }


def test_a_rendering_that_is_sent_is_taken_as_it_is(
    examined: Examinee, sitting: Sitting, truth: tuple[Truth, ...]
) -> None:
    pictures = pictures_of(sitting.codes, sitting.shown, truth)
    told, sent = answers(examined, pictures, shapes=False), answers_to_uploads(examined, pictures)
    assert np.isnan(told.overlaps).all()
    for mine, other in zip(told[1:], sent[1:], strict=True):
        assert np.allclose(mine, other, atol=1e-4)


def test_pictures_of_nothing_are_all_refused_at_once(
    examined: Examinee, sitting: Sitting, truth: tuple[Truth, ...]
) -> None:
    black = pictures_of(np.zeros_like(sitting.codes), sitting.shown, truth)
    figures = upload_figures(answers_to_uploads(examined, black), len(black.codes))
    assert (figures["refused_at_once"], figures["right"], figures["confidence"]) == (1, 0, None)


def test_what_a_bundle_says_of_held_out_pictures_is_taken(subject: Subject, validation: Validation) -> None:
    told = Yardstick(Errors(0.1, 0.2), Errors(0.3, 0.4))
    assert examinee("one", subject, validation, told).yardstick == told
    measured = examinee("one", subject, validation, None).yardstick
    assert 0 < measured.framed.median < measured.framed.high
