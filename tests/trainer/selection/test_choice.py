"""The one-standard-error rule, with figures that were made up."""

import numpy as np
import pytest

from trainer.errors import DataError
from trainer.selection.candidates import Candidate, grid
from trainer.selection.choice import choose
from trainer.selection.halving import Rung
from trainer.selection.record import Record, mean_of, paired
from trainer.selection.size import Size
from trainer.selection.verdict import verdict_on

LARGE, MIDDLE, SMALL, SMALLEST = CANDIDATES = grid(["subdivision-4", "subdivision-3"], [12, 6], ["fixed"], ["none"])
SIZES = {candidate: Size(1000 - n, 100, 98, 4000) for n, candidate in enumerate(CANDIDATES)}
# How hard each of eight pictures is, for every model: far more than models differ by.
HARD = np.array([-50.0, -10.0, -30.0, -80.0, -20.0, -40.0, -60.0, -5.0])
WOBBLE = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
ONE_ERROR = float(WOBBLE.std(ddof=1) / np.sqrt(8))


def record(values: np.ndarray) -> Record:
    return Record(500, 10.0, 1.0, tuple(values.tolist()), (0.0,) * len(values), (0.0,) * len(values))


def last_rung(behind: dict[Candidate, np.ndarray]) -> Rung:
    """Candidates by how far each lies behind the first, picture by picture."""
    judged = {candidate: record(HARD - lag) for candidate, lag in behind.items()}
    return Rung(500, judged, tuple(sorted(judged, key=lambda candidate: -judged[candidate].mean)))


def test_the_smallest_within_one_standard_error_is_chosen() -> None:
    nothing = np.zeros(8)
    rung = last_rung(
        {
            LARGE: nothing,
            MIDDLE: 0.5 * ONE_ERROR + WOBBLE,
            SMALL: 0.99 * ONE_ERROR + WOBBLE,
            SMALLEST: 1.01 * ONE_ERROR + WOBBLE,
        }
    )
    choice = choose([rung], SIZES)
    assert (choice.best, choice.chosen) == (LARGE, SMALL)
    words = {candidate: verdict_on(candidate, rung, choice)[0] for candidate in CANDIDATES}
    assert words == {LARGE: "best", MIDDLE: "larger", SMALL: "chosen", SMALLEST: "worse"}


def test_differences_are_paired() -> None:
    """Pictures differ by tens of nats; a constant lag of a tenth is certain all the same."""
    rung = last_rung({LARGE: np.zeros(8), SMALL: np.full(8, 0.1)})
    choice = choose([rung], SIZES)
    assert choice.chosen == LARGE
    assert choice.finalists[SMALL].behind.value == pytest.approx(0.1)
    assert choice.finalists[SMALL].behind.standard_error == pytest.approx(0.0, abs=1e-9)
    assert mean_of(rung.judged[LARGE].values).standard_error > 8


def test_of_models_of_one_size_the_one_with_fewer_vertices_is_chosen() -> None:
    rung = last_rung({LARGE: np.zeros(8), SMALL: WOBBLE - WOBBLE.mean()})
    sizes = {LARGE: Size(10, 5, 98, 40), SMALL: Size(10, 5, 56, 40)}
    assert choose([rung], sizes).chosen == SMALL


def test_the_best_stands_within_its_own_error() -> None:
    rung = last_rung({LARGE: np.zeros(8)})
    choice = choose([rung], SIZES)
    assert (choice.best, choice.chosen) == (LARGE, LARGE)
    assert verdict_on(LARGE, rung, choice) == (
        "chosen",
        "the most likely, and none that is smaller comes within a standard error of it",
    )


def test_a_dropped_one_is_compared_with_the_last_that_went_on() -> None:
    first = last_rung({LARGE: np.zeros(8), MIDDLE: np.full(8, 1.0), SMALL: 3.0 + WOBBLE, SMALLEST: np.full(8, 9.0)})
    first = first._replace(kept=(LARGE, MIDDLE))
    choice = choose([first, last_rung({LARGE: np.zeros(8), MIDDLE: np.full(8, 1.0)})], SIZES)
    word, why = verdict_on(SMALL, first, choice)
    assert word == "dropped"
    assert why == f"place 3 of 4 after 500 steps, 2.00 ± {ONE_ERROR:.2f} behind the last of the 2 that went on"


def test_failures_are_told_and_where_all_fail_nothing_is_chosen() -> None:
    failed = Record(125, 0.0, 0.0, problem="no finite gradients")
    rung = last_rung({LARGE: np.zeros(8)})
    rung = rung._replace(judged={**rung.judged, SMALL: failed})
    assert verdict_on(SMALL, rung, choose([rung], SIZES)) == (
        "failed", "failed on the way to step 500: no finite gradients",
    )  # fmt: skip
    with pytest.raises(DataError, match="all failed; first: no finite gradients"):
        choose([Rung(125, {LARGE: failed}, ())], SIZES)


def test_the_mean_of_a_difference_is_the_difference_of_means() -> None:
    one, other = record(HARD), record(HARD * 1.1 + WOBBLE)
    assert paired(one, other).value == pytest.approx(one.mean - other.mean)
