"""Curves through points, number for number as scipy draws them."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from trainer.data.shapes.spline import monotone, smooth


@pytest.mark.parametrize("count", [3, 4, 5, 8])
def test_the_monotone_curve_is_scipy_s(count: int) -> None:
    rng = np.random.default_rng(count)
    for _ in range(100):
        x = np.insert(np.cumsum(rng.uniform(0.01, 1.0, count - 1)), 0, 0.0)
        # Rising, turning, and level from one point to the next.
        y = np.stack((np.sort(rng.normal(size=count)), rng.normal(size=count), rng.integers(0, 3, count)), 1)
        at = np.linspace(0.0, x[-1], 40)
        np.testing.assert_array_equal(monotone(x, y, at), PchipInterpolator(x, y)(at))


@pytest.mark.parametrize("count", [4, 6, 9])
def test_the_smooth_curve_is_scipy_s(count: int) -> None:
    rng = np.random.default_rng(count)
    for _ in range(100):
        x = np.insert(np.cumsum(rng.uniform(0.01, 1.0, count - 1)), 0, 0.0)
        y, at = rng.normal(size=(count, 2)), np.linspace(0.0, x[-1], 40)
        # LAPACK may fuse a product and a sum where the processor can.
        np.testing.assert_allclose(smooth(x, y, at), CubicSpline(x, y)(at), rtol=1e-12, atol=1e-12)


def test_a_cubic_is_drawn_exactly() -> None:
    x, at = np.array([0.0, 0.3, 0.5, 1.2, 2.0]), np.linspace(0.0, 2.0, 30)
    np.testing.assert_allclose(smooth(x, x[:, None] ** 3 - x[:, None], at)[:, 0], at**3 - at, atol=1e-14)
