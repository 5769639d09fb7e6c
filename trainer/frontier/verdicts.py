"""Whether the choices that the default is made of lie on the front."""

from typing import NamedTuple

from trainer.frontier.plan import DEFAULT, Expense
from trainer.frontier.report import EXPENSES, Accuracy, Measured, Report

# Times scatter by as much on a machine that others use; bytes do not.
TIME_TOLERANCE = 0.1
_BYTE_TOLERANCE = 0.02


class Alternative(NamedTuple):
    """A point that costs less than the default, and what it gives up."""

    point: Measured
    expense: Expense
    share: float
    """Its cost, as a share of the default's."""
    gain: float
    """How much better it is, in the accuracy's own unit; negative where it is worse."""


class Verdict(NamedTuple):
    """The default's choice in one factor."""

    factor: str
    title: str
    choice: str
    on_front: bool
    """Nothing in this factor is as good for less, of any cost."""
    rivals: tuple[Alternative, ...]
    """Those points of the factor that are as good for less, or worse by less than seeds differ."""
    better: Measured | None
    """The best point of the factor, where it is better than the default by more than seeds differ."""


def verdicts(report: Report, category: str, accuracy: Accuracy) -> list[Verdict]:
    """A verdict for each factor that the default is one choice of."""
    default, noise = report.default(category), report.noise(category, accuracy)
    factors = dict.fromkeys(
        point.factor for point in report.of(category) if point.factor_default and point.name != DEFAULT
    )
    found = []
    for factor in factors:
        own = [point for point in report.of(category) if point.factor == factor]
        rivals = [
            Alternative(point, expense, share, gain)
            for point in own
            for expense in EXPENSES
            if (share := point.expense(expense) / default.expense(expense)) < 1 - _tolerance(expense)
            and (gain := point.goodness(accuracy) - default.goodness(accuracy)) > -noise
        ]
        best = max(own, key=lambda point: point.goodness(accuracy))
        improved = best.goodness(accuracy) > default.goodness(accuracy) + noise
        found.append(
            Verdict(
                factor,
                own[0].factor_title,
                own[0].factor_default,
                not any(rival.gain >= 0 for rival in rivals),
                tuple(rivals),
                best if improved else None,
            )
        )
    return found


def _tolerance(expense: Expense) -> float:
    return TIME_TOLERANCE if expense in ("training_minutes", "latency_ms") else _BYTE_TOLERANCE
