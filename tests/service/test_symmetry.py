"""Which turns a posterior does not tell apart."""

import numpy as np
import pytest

from service.symmetry import symmetry_order


@pytest.mark.parametrize(
    ("likely", "order"),
    [([3], 1), ([0, 6], 2), ([2, 6, 10], 3), ([1, 4, 7, 10], 4), ([0, 2, 4, 6, 8, 10], 6), (range(12), 12)],
)
@pytest.mark.parametrize("turn", [0, 1, 5])
def test_bins_that_repeat_tell_the_order(likely: list[int], order: int, turn: int) -> None:
    probabilities = np.full(12, 0.002, np.float32)
    probabilities[(np.array(likely) + turn) % 12] = 1
    assert symmetry_order(probabilities / probabilities.sum()) == order


def test_what_nearly_repeats_counts_and_what_hardly_does_does_not() -> None:
    def of(share: float) -> int:
        return symmetry_order(np.array([1 - share, 0, 0, share, 0, 0]))

    assert of(0.5) == of(0.35) == 2
    assert of(0.2) == of(0.0) == 1


def test_a_wide_guess_is_no_symmetry() -> None:
    """Neighbouring bins are about as probable, and opposite ones are not."""
    around = np.exp(2 * np.cos(2 * np.pi * np.arange(12) / 12))
    assert symmetry_order(around / around.sum()) == 1


def test_a_single_bin_has_nothing_to_turn() -> None:
    assert symmetry_order(np.ones(1, np.float32)) == 1
