"""The front of points whose front is known."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from trainer.frontier.pareto import near_front, on_front

POINTS = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=1, max_size=12)


def test_what_something_cheaper_beats_is_behind() -> None:
    costs, values = (1.0, 2.0, 3.0, 4.0), (0.5, 0.4, 0.7, 0.7)
    assert on_front(costs, values) == [True, False, True, False]
    assert near_front(costs, values, 0.0) == [True, False, True, True]
    assert near_front(costs, values, 0.1) == [True, True, True, True]


def test_of_equal_costs_the_better_one_is_on_the_front_and_twins_both_are() -> None:
    assert on_front((1.0, 1.0, 1.0), (0.5, 0.6, 0.6)) == [False, True, True]


@given(POINTS)
def test_the_front_is_not_empty_rises_and_leaves_nothing_better_out(points: list[tuple[int, int]]) -> None:
    costs, values = zip(*points, strict=True)
    on = on_front(costs, values)
    front = sorted({point for point, there in zip(points, on, strict=True) if there})
    assert front
    assert all(low[0] < high[0] and low[1] < high[1] for low, high in pairwise(front))
    for cost, value in points:
        assert any(there <= cost and best >= value for there, best in front)
    # Nothing on the front is beaten by any margin.
    assert all(close for there, close in zip(on, near_front(costs, values, 0.0), strict=True) if there)
