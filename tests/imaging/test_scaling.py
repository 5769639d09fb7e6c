"""Reduction and enlargement along an axis: exact means, nothing lost, nothing moved."""

import numpy as np
import pytest

from imaging.scaling import area_weights, block_means


def whole(count: int, origin: float, scale: float, size: int) -> np.ndarray:
    """[size, count] weights between pixels of unit width, zeros where nothing is covered."""
    weights, filled = area_weights(np.arange(count + 1.0), origin, scale, size)
    everything = np.zeros((size, count), np.float32)
    everything[filled] = weights
    return everything


def test_the_same_grid_changes_nothing() -> None:
    np.testing.assert_array_equal(whole(7, 0.0, 1.0, 7), np.eye(7))


def test_a_reduced_pixel_is_the_mean_of_what_it_covers() -> None:
    np.testing.assert_allclose(whole(6, 0.0, 0.5, 3), np.kron(np.eye(3), [0.5, 0.5]))
    # Two thirds: each covers one and a half.
    np.testing.assert_allclose(whole(3, 0.0, 2 / 3, 2), [[2 / 3, 1 / 3, 0], [0, 1 / 3, 2 / 3]], atol=1e-7)
    # Moved by half a pixel, with nothing before the first.
    np.testing.assert_allclose(whole(2, -0.5, 1.0, 3), [[0.5, 0], [0.5, 0.5], [0, 0.5]])


def test_enlargement_interpolates() -> None:
    np.testing.assert_allclose(whole(2, 0.0, 2.0, 4)[1:3], [[0.75, 0.25], [0.25, 0.75]])


@pytest.mark.parametrize(("count", "size", "scale"), [(7, 3, 0.4), (100, 64, 0.61), (33, 8, 0.2)])
def test_reduction_loses_no_light(count: int, size: int, scale: float) -> None:
    weights = whole(count, (count - size / scale) / 2, scale, size)
    np.testing.assert_allclose(weights.sum(0), scale, rtol=1e-5)


def test_pixels_that_are_cut_off_weigh_less() -> None:
    weights, filled = area_weights(np.array([0.0, 3.0, 6.0, 7.0]), 0.0, 1 / 7, 1)
    assert filled == slice(0, 1)
    np.testing.assert_allclose(weights, [[3 / 7, 3 / 7, 1 / 7]], rtol=1e-6)


def test_what_is_far_away_is_not_there() -> None:
    assert not whole(4, 10.0, 1.0, 5).any()


@pytest.mark.parametrize("factor", [1, 2, 3, 5, 20])
def test_block_means_are_means_also_of_partial_blocks(factor: int) -> None:
    planes = np.random.default_rng(factor).uniform(size=(2, 7, 11)).astype(np.float32)
    means = block_means(planes, factor)
    assert means.shape == (2, -(-7 // factor), -(-11 // factor))
    for row in range(means.shape[1]):
        for column in range(means.shape[2]):
            block = planes[:, row * factor : (row + 1) * factor, column * factor : (column + 1) * factor]
            np.testing.assert_allclose(means[:, row, column], block.mean((1, 2)), rtol=1e-5)
