"""Who goes on and who is dropped, with trainings that are only pretended."""

from collections.abc import Sequence

import numpy as np
import pytest

from trainer.selection.candidates import Candidate, grid
from trainer.selection.halving import WARM_UP_STEPS, Budget, Judged, halve
from trainer.selection.record import Record

CANDIDATES = grid(
    ["subdivision-3", "subdivision-4", "ortho-block-6", "full-block-12"], [6, 12], ["fixed", "varying"], ["none"]
)


class Pretended:
    """Candidate n's bound is −n at first, and then what `late` says of it; a step takes it `pace` seconds."""

    def __init__(self, late: dict[int, float] | None = None, pace: float = 0.1, failing: frozenset[int] = frozenset()):
        self.late, self.pace, self.failing = late or {}, pace, failing
        self.calls: list[tuple[list[int], int]] = []

    def __call__(self, candidates: Sequence[Candidate], step: int) -> Judged:
        numbers = [CANDIDATES.index(candidate) for candidate in candidates]
        self.calls.append((numbers, step))
        return {candidate: self.record(number, step) for candidate, number in zip(candidates, numbers, strict=True)}

    def record(self, number: int, step: int) -> Record:
        if number in self.failing and step > WARM_UP_STEPS:
            return Record(step, 0.0, 0.0, problem="no finite gradients")
        bound = self.late.get(number, -float(number)) if step > 100 else -float(number)
        values = tuple((bound + np.array([-1.0, 0.0, 1.0])).tolist())
        return Record(step, step * self.pace, 2.0, values, (0.0,) * 3, (0.0,) * 3)

    @property
    def seconds(self) -> float:
        """Of training and judging in all."""
        furthest = {number: step for numbers, step in self.calls for number in numbers}
        judged = {(number, step) for numbers, step in self.calls for number in numbers}
        return sum(step * self.pace for step in furthest.values()) + 2.0 * len(judged)


def test_half_are_dropped_at_each_rung_and_steps_double() -> None:
    pretended = Pretended()
    rungs = halve(CANDIDATES, Budget(500, None, 3), pretended)
    assert [(len(numbers), step) for numbers, step in pretended.calls] == [(16, 125), (8, 250), (4, 500)]
    assert [len(rung.kept) for rung in rungs] == [8, 4, 4]
    assert list(rungs[-1].kept) == CANDIDATES[:4]


def test_one_that_is_late_is_kept_only_if_it_is_not_dropped_before() -> None:
    """The weakness of halving, which docs/select.md tells."""
    late = {7: 5.0, 8: 6.0}
    assert [CANDIDATES.index(found) for found in halve(CANDIDATES, Budget(400, None, 3), Pretended(late))[-1].kept] == [
        7, 0, 1, 2,
    ]  # fmt: skip


def test_two_are_left_for_the_last_rung_to_choose_from() -> None:
    assert [len(rung.judged) for rung in halve(CANDIDATES[:3], Budget(64, None, 5), Pretended())] == [3, 2, 2, 2, 2]


def test_a_single_rung_compares_all_at_the_end() -> None:
    (rung,) = halve(CANDIDATES, Budget(300, None, 1), Pretended())
    assert (rung.step, len(rung.kept)) == (300, 16)


@pytest.mark.parametrize("minutes", [4, 10])
def test_each_rung_gets_an_even_share_of_the_time(minutes: int) -> None:
    pretended = Pretended()
    rungs = halve(CANDIDATES, Budget(100_000, 60.0 * minutes, 3), pretended)
    assert pretended.calls[0] == (list(range(16)), WARM_UP_STEPS)
    # All of the time, but for what does not make a step more of each that is left.
    assert 0.97 * 60 * minutes < pretended.seconds <= 60 * minutes
    steps = [rung.step for rung in rungs]
    trained = [16 * (steps[0] - WARM_UP_STEPS), 8 * (steps[1] - steps[0]), 4 * (steps[2] - steps[1])]
    judged = [2.0 * 16, 2.0 * 8, 2.0 * 4]
    shares = [0.1 * steps + seconds for steps, seconds in zip(trained, judged, strict=True)]
    assert max(shares) < 1.1 * min(shares)


def test_time_that_is_up_trains_nobody_further() -> None:
    pretended = Pretended()
    rungs = halve(CANDIDATES, Budget(500, 10.0, 3), pretended)
    assert [rung.step for rung in rungs] == [WARM_UP_STEPS] * 3
    assert [len(rung.kept) for rung in rungs] == [8, 4, 4]


def test_time_to_spare_goes_no_further_than_the_recipe() -> None:
    assert [rung.step for rung in halve(CANDIDATES, Budget(500, 1e6, 2), Pretended())] == [500, 500]


def test_what_fails_is_dropped_and_told() -> None:
    rungs = halve(CANDIDATES, Budget(400, None, 3), Pretended(failing=frozenset({0, 3})))
    assert rungs[0].judged[CANDIDATES[3]].problem == "no finite gradients"
    assert len(rungs[0].kept) == 7
    assert CANDIDATES[0] not in rungs[0].kept


@pytest.mark.parametrize("seconds", [None, 1000.0])
def test_where_all_fail_nobody_is_left(seconds: float | None) -> None:
    rungs = halve(CANDIDATES, Budget(400, seconds, 3), Pretended(failing=frozenset(range(16))))
    assert rungs[-1].kept == ()
    assert len(rungs) == 1
    assert len(rungs[0].judged) == 16


def test_what_fails_while_warming_up_is_told_at_the_first_rung(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.trainer.selection.test_halving.WARM_UP_STEPS", 1)
    pretended = Pretended(failing=frozenset({5}))
    rungs = halve(CANDIDATES, Budget(400, 600.0, 2), pretended)
    assert rungs[0].judged[CANDIDATES[5]].problem == "no finite gradients"
    assert 5 not in pretended.calls[1][0]


def test_begun_again_it_does_the_same() -> None:
    first, second = Pretended(), Pretended()
    budget = Budget(1000, 300.0, 3)
    assert halve(CANDIDATES, budget, first) == halve(CANDIDATES, budget, second)
    assert first.calls == second.calls
