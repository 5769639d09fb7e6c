"""Where shape codes lie: the mixture against distributions that are known, and what is drawn from it."""

import numpy as np
import pytest

from trainer.errors import DataError
from trainer.model.aggregate_posterior import LEAST_PICTURES, AggregatePosterior, fit_aggregate_posterior

COVARIANCE = np.array([[1.0, 0.6], [0.6, 0.5]])


def drawn(density: AggregatePosterior, count: int, latent: int, temperature: float = 1.0) -> np.ndarray:
    random = np.random.default_rng(1)
    return density.codes(random.standard_normal((count, latent)), random.random(count), temperature)


def test_one_gaussian_is_found_with_the_posteriors_own_width_in_it() -> None:
    """Means and deviations together have the covariance; the second number tells nothing, and has the prior."""
    # Another seed than that of the fit's own draws.
    random = np.random.default_rng(7)
    own = COVARIANCE - 0.04 * np.eye(2)
    means = np.zeros((2000, 3))
    means[:, [0, 2]] = random.multivariate_normal([0.5, -1.0], own, 2000)
    deviations = np.tile([0.2, 1.0, 0.2], (2000, 1))
    density = fit_aggregate_posterior(means, deviations)
    assert density.numbers == (0, 2)
    assert density.pictures == 2000
    codes = drawn(density, 100_000, 3)
    np.testing.assert_allclose(codes.mean(0), [0.5, 0, -1], atol=0.06)
    np.testing.assert_allclose(np.cov(codes.T)[np.ix_([0, 2], [0, 2])], COVARIANCE, atol=0.07)
    np.testing.assert_allclose(np.cov(codes.T)[1], [0, 1, 0], atol=0.02)


def test_nothing_is_drawn_where_no_code_is() -> None:
    """Two heaps, of which one is three times as large: the prior would draw between them."""
    random = np.random.default_rng(7)
    means = 0.1 * random.standard_normal((400, 2)) + np.where(np.arange(400) % 4, 2.0, -2.0)[:, None]
    density = fit_aggregate_posterior(means, np.full((400, 2), 0.1))
    assert len(density.weights) >= 2
    codes = drawn(density, 10_000, 2)
    assert (np.abs(codes) < 1).any(1).mean() < 1e-3
    assert (codes[:, 0] > 0).mean() == pytest.approx(0.75, abs=0.02)
    typical = drawn(density, 200, 2, temperature=0.0)
    assert len(np.unique(typical, axis=0)) == len(density.weights)
    assert np.abs(np.abs(typical) - 2).max() < 0.2


def test_what_is_doubtful_is_left_out() -> None:
    """Two heaps, of which the smaller one is doubted; a quarter of all draws are left out, and those are it."""
    random = np.random.default_rng(7)
    means = 0.1 * random.standard_normal((400, 2)) + np.where(np.arange(400) % 4, 2.0, -2.0)[:, None]
    asked = []

    def doubts(codes: np.ndarray) -> np.ndarray:
        asked.append(codes)
        doubt: np.ndarray = -codes[:, 0]
        return doubt

    density = fit_aggregate_posterior(means, np.full((400, 2), 0.1), doubts)
    assert (drawn(density, 1000, 2) > 1).all()
    assert density.pictures == 400
    assert [codes.shape for codes in asked] == [(1600, 2)]


def test_codes_that_tell_nothing_have_the_prior() -> None:
    density = fit_aggregate_posterior(np.zeros((LEAST_PICTURES, 3)), np.ones((LEAST_PICTURES, 3)))
    assert density.numbers == ()
    noise = np.random.default_rng(7).standard_normal((5, 3))
    np.testing.assert_array_equal(density.codes(noise, np.zeros(5), 0.5), 0.5 * noise)


def test_the_same_pictures_give_the_same() -> None:
    means = np.random.default_rng(7).standard_normal((LEAST_PICTURES, 2))
    first, second = (fit_aggregate_posterior(means, np.full_like(means, 0.3)) for _ in range(2))
    np.testing.assert_array_equal(first.means, second.means)
    np.testing.assert_array_equal(first.factors, second.factors)


def test_too_few_pictures_are_told() -> None:
    few = np.zeros((LEAST_PICTURES - 1, 2))
    with pytest.raises(DataError, match=r"Expected 40 pictures at least .*, found 39\. .* leave the option away"):
        fit_aggregate_posterior(few, few)
