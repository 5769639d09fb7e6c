"""The judge's figures on cases whose answer is known."""

import math

import numpy as np
import pytest

from trainer.evaluation.metrics import (
    TEMPERATURES,
    accuracy,
    azimuth_error,
    bootstrap,
    calibration_error,
    fit_azimuth_offset,
    fit_temperature,
    iou,
    mean_shape,
    median_error,
    symmetric_azimuth_error,
    tempered,
)


def test_iou_counts_voxels() -> None:
    first, second = np.zeros((2, 4, 4, 4), bool), np.zeros((2, 4, 4, 4), bool)
    first[0, :2], second[0, 1:3] = True, True
    np.testing.assert_allclose(iou(first, second), [1 / 3, 1.0])
    np.testing.assert_allclose(iou(first, second[:1]), [1 / 3, 0.0])
    assert iou(first[0], ~first[0]) == 0


def test_azimuth_errors_wrap_around() -> None:
    predicted, true = np.radians([350.0, -170.0, 30.0, 180.0]), np.radians([10.0, 170.0, 30.0, 0.0])
    np.testing.assert_allclose(np.degrees(azimuth_error(predicted, true)), [20, 20, 0, 180])


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 6, 8])
def test_the_symmetric_error_is_the_least_over_the_turns(order: int) -> None:
    rng = np.random.default_rng(order)
    predicted, true = rng.uniform(-7, 7, (2, 200))
    turns = [azimuth_error(predicted, true + turn * 2 * np.pi / order) for turn in range(order)]
    found = symmetric_azimuth_error(predicted, true, np.full(200, float(order)))
    np.testing.assert_allclose(found, np.min(turns, 0), atol=1e-12)
    assert found.max() <= np.pi / order + 1e-12


def test_every_azimuth_of_a_solid_of_revolution_is_right() -> None:
    orders = np.array([1.0, 2.0, 4.0, math.inf])
    found = np.degrees(symmetric_azimuth_error(np.radians(np.full(4, 170.0)), np.zeros(4), orders))
    np.testing.assert_allclose(found, [170, 10, 10, 0])


def test_median_and_accuracy_are_the_papers() -> None:
    errors = np.radians([0.0, 10.0, 29.9, 30.1, 180.0])
    assert math.degrees(median_error(errors)) == pytest.approx(29.9)
    assert accuracy(errors) == pytest.approx(3 / 5)


@pytest.mark.parametrize("offset_degrees", [0.0, 37.0, 180.0, -121.5, 359.0])
def test_the_offset_is_found_despite_flips_and_outliers(offset_degrees: float) -> None:
    rng = np.random.default_rng(0)
    true = rng.uniform(-np.pi, np.pi, 200)
    predicted = true - math.radians(offset_degrees) + rng.normal(scale=0.1, size=200)
    predicted[:60] += np.pi
    predicted[60:80] = rng.uniform(-np.pi, np.pi, 20)
    fitted = fit_azimuth_offset(predicted, true)
    assert -np.pi <= fitted < np.pi
    assert azimuth_error(np.array([fitted]), np.radians([offset_degrees]))[0] < math.radians(2.5)
    assert fitted == fit_azimuth_offset(predicted[::-1], true[::-1])


def test_no_other_offset_is_better() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        true, predicted = rng.uniform(-np.pi, np.pi, (2, 25))

        def cost(offset: float, true: np.ndarray = true, predicted: np.ndarray = predicted) -> float:
            return float(np.minimum(azimuth_error(predicted + offset, true), np.pi / 6).mean())

        assert cost(fit_azimuth_offset(predicted, true)) <= min(map(cost, np.linspace(0, 2 * np.pi, 2000))) + 1e-12


def test_an_offset_that_turns_the_wrong_way_would_show() -> None:
    """true ≈ predicted + offset, and not the reverse."""
    assert fit_azimuth_offset(np.zeros(3), np.full(3, 0.5)) == pytest.approx(0.5)


def test_an_offset_needs_pictures() -> None:
    with pytest.raises(ValueError, match="one at least, found 0, 0"):
        fit_azimuth_offset(np.empty(0), np.empty(0))


def test_the_bootstrap_interval_of_a_mean_is_that_of_statistics() -> None:
    values = np.random.default_rng(0).normal(5.0, 2.0, 400)
    interval = bootstrap(values, np.arange(400), np.random.default_rng(1))
    half = 1.96 * values.std() / math.sqrt(400)
    assert interval.value == values.mean()
    assert interval.low == pytest.approx(interval.value - half, abs=0.15 * half)
    assert interval.high == pytest.approx(interval.value + half, abs=0.15 * half)


def test_views_of_one_object_are_drawn_together() -> None:
    """Ten equal views of each object say no more than one of each."""
    values = np.random.default_rng(0).normal(size=50)
    single = bootstrap(values, np.arange(50), np.random.default_rng(1))
    tenfold = bootstrap(np.repeat(values, 10), np.repeat(np.arange(50), 10), np.random.default_rng(1))
    assert (tenfold.low, tenfold.high) == pytest.approx((single.low, single.high))
    median = bootstrap(values, np.arange(50), np.random.default_rng(1), median_error)
    assert median.value == np.median(values)
    assert median.low <= median.value <= median.high


def test_the_mean_shape_is_the_best_share_of_the_training_shapes() -> None:
    training = np.zeros((10, 2, 2, 2), bool)
    training[:, 0] = True  # always
    training[:6, 1, 0] = True  # mostly
    training[:1, 1, 1] = True  # hardly ever
    expected = np.zeros((2, 2, 2), bool)
    expected[0], expected[1, 0] = True, True
    np.testing.assert_array_equal(mean_shape(training), expected)


def test_confidence_that_is_borne_out_has_no_calibration_error() -> None:
    honest = np.array([(0.75, 1), (0.75, 1), (0.75, 1), (0.75, 0), (0.5, 1), (0.5, 0)])
    assert calibration_error(honest) == pytest.approx(0)
    # Too sure by 0.25 in two thirds of the answers, too modest by 0.5 in the others: what they even out does not count.
    assert calibration_error(np.array([(1.0, 1), (1.0, 1), (1.0, 1), (1.0, 0), (0.5, 1), (0.5, 1)])) == pytest.approx(
        1 / 3
    )
    assert calibration_error(np.array([(0.3, 0)])) == pytest.approx(0.3)


def test_the_temperature_of_confidence_that_is_borne_out_is_one() -> None:
    """Bins that are drawn from the probabilities told: as they are, and told too surely and too modestly."""
    rng = np.random.default_rng(0)
    honest = rng.dirichlet(np.full(12, 0.3), 4000)
    true = (honest.cumsum(1) > rng.random((4000, 1))).argmax(1)
    assert fit_temperature(honest, true) == pytest.approx(1, abs=0.05)
    for factor in (0.4, 3.0):
        told = tempered(honest, factor)
        assert fit_temperature(told, true) == pytest.approx(1 / factor, rel=0.05)
        np.testing.assert_array_equal(told.argmax(1), honest.argmax(1))
        confidence, right = told.max(1), told.argmax(1) == true
        mended = tempered(told, fit_temperature(told, true)).max(1)
        before, after = (calibration_error(np.column_stack((values, right))) for values in (confidence, mended))
        assert after < 0.03 < before


def test_a_temperature_is_no_higher_than_it_may_be() -> None:
    """Probabilities that say nothing of the truth, with zeros that a graph may have rounded."""
    sure = np.eye(12)[np.arange(600) % 12]
    assert fit_temperature(sure, np.arange(600) // 12 % 12) == pytest.approx(max(TEMPERATURES), rel=0.01)
    flat = tempered(sure, 100)
    assert flat.sum(1) == pytest.approx(1)
    assert flat.max() < 0.2
