"""Risk, coverage and breaking points in closed form."""

import numpy as np
import pytest

from tests.trainer.stability.test_answers import answers_of
from trainer.stability.curves import breaks_at
from trainer.stability.risk import area, reliability_of, risk_of, risks


def test_risks_of_four_answers() -> None:
    loss, trust = np.array([1.0, 0.0, 1.0, 0.0]), np.array([0.1, 0.9, 0.4, 0.8])
    assert risks(loss, trust, 0) == pytest.approx([0, 0, 1 / 3, 1 / 2])
    assert area(risks(loss, trust, 0)) == pytest.approx(5 / 24)
    assert area(risks(loss, -trust, 0)) == pytest.approx((1 + 1 + 2 / 3 + 1 / 2) / 4)


def test_equal_trust_is_a_random_order() -> None:
    loss = (np.arange(2000) < 600).astype(float)
    by_count = risks(loss, np.ones(2000), 0)
    assert by_count[200:] == pytest.approx(0.3, abs=0.06)
    assert area(by_count) == pytest.approx(0.3, abs=0.04)


def test_a_confidence_that_knows_gains_all_and_one_that_errs_less_than_nothing() -> None:
    errors, knowing = [1.0, 2, 3, 90, 90, 90], [0.9, 0.8, 0.7, 0.3, 0.2, 0.1]
    risk = risk_of(answers_of(errors, knowing, [0] * 6))["wrong_azimuth"]
    assert risk["aurc_confidence"] == risk["aurc_ideal"] < risk["aurc_random"] == 0.5
    assert risk["gained_confidence"] == 1
    assert risk["risk_confidence"][-1] == 0.5
    backwards = risk_of(answers_of(errors, knowing[::-1], [0] * 6))["wrong_azimuth"]
    assert backwards["gained_confidence"] < 0
    # All alike, with one of them badly explained: only the score tells.
    strange = risk_of(answers_of([1.0, 1, 1, 90], [0.9] * 4, [0, 0, 0, 5]))["wrong_azimuth"]
    assert strange["gained_combined"] == 1
    assert risk_of(answers_of([1.0, 1], [0.9, 0.8], [0, 0]))["wrong_azimuth"]["gained_confidence"] is None


def test_reliability_counts_every_answer_once() -> None:
    parts = reliability_of(answers_of([1, 90, 90, 1], [0.995, 1.0, 0.92, 0.3], [0, 0, 3, 0]))
    assert [part["pictures"] for part in parts] == [1, 1, 2]
    assert [part["right"] for part in parts] == [1, 0, 0.5]
    assert [part["wrong_and_refused"] for part in parts] == [0, 1, 0]


def point(severity: float, iou: float, accuracy: float) -> dict[str, float]:
    return {"severity": severity, "iou": iou, "symmetric_azimuth_accuracy": accuracy}


@pytest.mark.parametrize(
    ("second", "expected"),
    [((0.41, 0.46), None), ((0.39, 0.9), 3.0), ((0.5, 0.44), 3.0), ((0.4, 0.45), None)],
)
def test_a_model_breaks_where_a_fifth_of_its_iou_or_half_of_its_poses_are_lost(
    second: tuple[float, float], expected: float | None
) -> None:
    assert breaks_at([point(0, 0.5, 0.9), point(3, *second), point(5, 0.5, 0.9)]) == expected
