"""Which points are worth their cost."""

from collections.abc import Sequence


def on_front(costs: Sequence[float], values: Sequence[float]) -> list[bool]:
    """Whether nothing that costs as little is better, and nothing as good costs less. Larger values are better."""
    points = list(zip(costs, values, strict=True))
    return [
        not any(
            cost <= own_cost and value >= own_value and (cost, value) != (own_cost, own_value) for cost, value in points
        )
        for own_cost, own_value in points
    ]


def near_front(costs: Sequence[float], values: Sequence[float], tolerance: float) -> list[bool]:
    """Whether nothing that costs as much or less is better by more than `tolerance`."""
    points = list(zip(costs, values, strict=True))
    return [
        not any(cost <= own_cost and value > own_value + tolerance for cost, value in points)
        for own_cost, own_value in points
    ]
