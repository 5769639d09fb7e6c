"""Successive halving: all candidates are trained a little, the better half goes on, and so forth.

Jamieson & Talwalkar, "Non-stochastic best arm identification and hyperparameter optimization", AISTATS 2016. At a rung,
all candidates that are left have made the same number of steps: schedules that cool with the step leave nothing else
to be compared. Where time is given, each rung gets an even share of what is left of it.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from trainer.selection.candidates import Candidate
from trainer.selection.record import Record

WARM_UP_STEPS = 25
"""Steps after which a candidate's pace is known, where time is given."""

Judged = Mapping[Candidate, Record]
Judge = Callable[[Sequence[Candidate], int], Judged]
"""Trains candidates up to a step and judges them, where that is not done yet."""


class Budget(NamedTuple):
    """How long the candidates are trained."""

    steps: int
    """Steps that the last ones come to; at most so many where time is given."""
    seconds: float | None
    """Of all cores that compute, for training and judging all candidates; None: as long as the steps take."""
    rungs: int
    """How often they are judged; after each rung but the last, half of them are dropped."""


class Rung(NamedTuple):
    step: int
    judged: Judged
    """All that came this far."""
    kept: tuple[Candidate, ...]
    """Those that go on; at the last rung those that may be chosen. The best comes first."""


def halve(candidates: Sequence[Candidate], budget: Budget, judge: Judge) -> list[Rung]:
    """Trains the candidates rung by rung, and returns what came of each; a warm-up is no rung.

    A candidate whose training failed is dropped at that rung. Two go on at least, as long as there are two. What
    happens is a function of the records alone, so that a selection which is interrupted and begun again does the same.
    """
    rungs: list[Rung] = []
    history: dict[Candidate, list[Record]] = {candidate: [] for candidate in candidates}
    entrants, step, failed = list(candidates), 0, dict[Candidate, Record]()

    def at(step: int) -> Judged:
        judged = judge(entrants, step)
        for candidate, record in judged.items():
            if not history[candidate] or history[candidate][-1].step < record.step:
                history[candidate].append(record)
        return judged

    if budget.seconds is not None:
        step = min(WARM_UP_STEPS, budget.steps)
        failed = {candidate: record for candidate, record in at(step).items() if record.problem is not None}
        entrants = [candidate for candidate in entrants if candidate not in failed]
        if not entrants:
            return [Rung(step, failed, ())]
    for number in range(budget.rungs):
        step = next_step(budget, number, step, entrants, history)
        judged = at(step)
        ranked = sorted(
            (candidate for candidate in entrants if judged[candidate].problem is None),
            key=lambda candidate: -judged[candidate].mean,
        )
        last = number == budget.rungs - 1
        kept = ranked if last else ranked[: max(2, math.ceil(len(ranked) / 2))]
        rungs.append(Rung(step, {**judged, **failed}, tuple(kept)))
        entrants, failed = kept, {}
        if not entrants:
            break
    return rungs


def next_step(
    budget: Budget,
    number: int,
    before: int,
    entrants: Sequence[Candidate],
    history: Mapping[Candidate, Sequence[Record]],
) -> int:
    """The step of rung `number`, of which 0 is the first: a half, a quarter … of the last one's; or, where time is
    given, what all entrants come to in this rung's share of the time left, each at the pace of its last leg."""
    if budget.seconds is None:
        return -(-budget.steps // (1 << (budget.rungs - 1 - number)))
    spent = sum(
        records[-1].training_core_seconds + sum(record.judging_core_seconds for record in records)
        for records in history.values()
        if records
    )
    share = (budget.seconds - spent) / (budget.rungs - number)
    judging = sum(history[candidate][-1].judging_core_seconds for candidate in entrants)
    pace = sum(_seconds_per_step(history[candidate]) for candidate in entrants)
    # A tiny leg may have taken no time that a clock could tell.
    return min(budget.steps, before + max(0, int((share - judging) / max(pace, 1e-6))))


def _seconds_per_step(records: Sequence[Record]) -> float:
    """Of the last leg."""
    steps, seconds = records[-1].step, records[-1].training_core_seconds
    if len(records) > 1:
        steps, seconds = steps - records[-2].step, seconds - records[-2].training_core_seconds
    return seconds / steps
