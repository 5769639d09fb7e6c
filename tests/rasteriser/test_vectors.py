"""Each operation on vectors, in a kernel, against numpy on the same numbers."""

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from rasteriser.vectors import (
    LANES,
    WIDE,
    all_set_above,
    all_set_below,
    as_doubles,
    as_singles,
    beside,
    evens,
    first_lanes,
    last_above,
    last_below,
    load,
    load_twice,
    load_wide,
    odds,
    ramp,
    select,
    store,
    total,
    zeros,
    zipped_high,
    zipped_low,
)

A, B = np.array([3.0, -1, 0.5, 7, 2, 2, -9, 1e-3]), np.array([2.0, -1, 4, 0.25, 2, -2, 9, 5])


@njit
def arithmetic(a, b, out):
    x, y = load(a, 0), load(b, 0)
    store(out[0], 0, x + y)
    store(out[1], 0, x - 2.5)
    store(out[2], 0, 3 * x)
    store(out[3], 0, 1.0 / y)
    store(out[4], 0, zeros() - x)


def test_operators_work_lane_by_lane_and_plain_numbers_stand_for_vectors() -> None:
    out = np.empty((5, LANES))
    arithmetic(A, B, out)
    np.testing.assert_array_equal(out, [A + B, A - 2.5, 3 * A, 1 / B, -A])


@njit
def chosen(a, b, faces, out, kept):
    x, y = load(a, 0), load(b, 0)
    store(out[0], 0, select(x > y, x, y))
    store(out[1], 0, select((x >= y) & (y >= 2.0), 1.0, y))
    store(kept, 0, select(load(faces, 0) == 3, 7, load(kept, 0)))


def test_masks_choose() -> None:
    out, faces, kept = np.empty((2, LANES)), np.array([3, 1, 3, 0, 0, 0, 0, 3], np.int32), np.arange(8, dtype=np.int32)
    chosen(A, B, faces, out, kept)
    np.testing.assert_array_equal(out, [np.maximum(A, B), np.where((A >= B) & (B >= 2), 1.0, B)])
    np.testing.assert_array_equal(kept, [7, 1, 7, 3, 4, 5, 6, 7])


def test_nothing_compares_with_what_is_not_a_number() -> None:
    out = np.empty((2, LANES))
    nan = np.where(A > 0, np.nan, A)
    chosen(nan, B, np.zeros(8, np.int32), out, np.zeros(8, np.int32))
    np.testing.assert_array_equal(out[0], np.where(np.isnan(nan), B, np.maximum(A, B)))


@njit
def reduced(a):
    x = load(a, 0)
    return total(x), last_below(x), last_above(x)


def test_vectors_reduce_to_numbers() -> None:
    assert reduced(A) == (pytest.approx(A.sum(), rel=1e-15), A[3], A[7])


@njit
def in_halves(b, out):
    x = load_twice(b, 1)
    store(out[0], 0, x)
    store(out[1], 0, beside(2, 0.5))
    below = beside(-1.0, -0.5)
    return all_set_below(x >= below), all_set_above(x >= below), all_set_below(x > below), all_set_above(x > -2.0)


def test_halves_hold_two_things_at_once_and_are_asked_apart() -> None:
    out = np.empty((2, LANES))
    assert in_halves(B, out) == (True, False, False, True)
    np.testing.assert_array_equal(out, [[*B[1:5], *B[1:5]], [2, 2, 2, 2, 0.5, 0.5, 0.5, 0.5]])


@njit
def converted(a, singles, out):
    store(singles, 0, as_singles(load(a, 0)))
    store(out, 0, as_doubles(load(singles, 0)) + ramp(10.5))


def test_doubles_and_singles_convert() -> None:
    singles, out = np.empty(8, np.float32), np.empty(8)
    converted(A, singles, out)
    np.testing.assert_array_equal(singles, A.astype(np.float32))
    np.testing.assert_array_equal(out, A.astype(np.float32) + (np.arange(8) + 10.5))


@njit
def shuffled(numbers, out):
    x, y = load_wide(numbers, 1), load_wide(numbers, 1 + WIDE)
    store(out[0], 0, evens(x, y))
    store(out[1], 0, odds(x, y))
    store(out[2], 0, zipped_low(x, y))
    store(out[3], 0, zipped_high(x, y))


def test_shuffles_take_rows_apart_and_put_them_together() -> None:
    numbers, out = np.arange(1 + 2 * WIDE, dtype=np.float32), np.empty((4, WIDE), np.float32)
    shuffled(numbers, out)
    x, y = numbers[1:].reshape(2, WIDE)
    np.testing.assert_array_equal(out[:2], [numbers[1::2], numbers[2::2]])
    np.testing.assert_array_equal(np.concatenate(out[2:]), np.stack((x, y), 1).reshape(-1))


@njit
def cut_off(numbers, count, out):
    store(out, 0, select(first_lanes(count), load_wide(numbers, 0), 0.0))


@pytest.mark.parametrize("count", [-3, 0, 1, WIDE - 1, WIDE, 100])
def test_first_lanes_are_as_many_as_said(count: int) -> None:
    out = np.empty(WIDE, np.float32)
    cut_off(np.ones(WIDE, np.float32), count, out)
    assert out.sum() == min(max(count, 0), WIDE)


def test_what_does_not_fit_together_does_not_compile() -> None:
    for kernel in (
        njit(lambda a, b: total(load(a, 0) + load_wide(b, 0))),
        njit(lambda a, b: total(load(a, 0) & load(b, 0))),
        njit(lambda a, b: total(select(load(a, 0), load(a, 0), load(b, 0)))),
    ):
        with pytest.raises(TypingError):
            kernel(A, B)
