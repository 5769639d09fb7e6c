import numpy as np
import pytest

from imaging.neighbourhood import highest, lowest, total


def window(plane: np.ndarray, row: int, column: int, radius: int) -> np.ndarray:
    return plane[max(0, row - radius) : row + radius + 1, max(0, column - radius) : column + radius + 1]


def by_windows(plane: np.ndarray, radius: int, of: str) -> np.ndarray:
    """What `of` makes of the square around each pixel."""
    return np.array(
        [
            [getattr(window(plane, row, column, radius), of)() for column in range(plane.shape[1])]
            for row in range(plane.shape[0])
        ]
    )


@pytest.mark.parametrize("radius", [0, 1, 2, 3, 6])
@pytest.mark.parametrize("shape", [(9, 7), (3, 20), (1, 1)], ids=str)
def test_squares_are_those_around_each_pixel(shape: tuple[int, int], radius: int) -> None:
    values = np.random.default_rng(0).normal(size=shape).astype(np.float32)
    np.testing.assert_array_equal(highest(values, radius), by_windows(values, radius, "max"))
    mask = values > 1
    np.testing.assert_array_equal(highest(mask, radius), by_windows(mask, radius, "any"))
    np.testing.assert_array_equal(lowest(~mask, radius), by_windows(~mask, radius, "all"))
    np.testing.assert_allclose(total(values, radius), by_windows(values, radius, "sum"), atol=1e-5)


@pytest.mark.parametrize("shape", [(0, 5), (5, 0), (0, 0)], ids=str)
def test_of_nothing_there_is_nothing(shape: tuple[int, int]) -> None:
    assert highest(np.zeros(shape, bool), 2).shape == shape
