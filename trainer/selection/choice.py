"""Who is chosen at the last rung: the smallest candidate that is about as good as the best.

Breiman's one-standard-error rule (Breiman et al., "Classification and Regression Trees", 1984), with paired
differences: all candidates are judged on the same pictures, and how hard a picture is, is no candidate's fault.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from trainer.errors import DataError
from trainer.selection.candidates import Candidate
from trainer.selection.halving import Rung
from trainer.selection.record import Mean, Record, paired
from trainer.selection.size import Size


class Finalist(NamedTuple):
    behind: Mean
    """How much likelier the held-out objects are under the best candidate; 0 ± 0 for itself."""
    close: bool
    """Whether that is at most its own standard error."""


class Choice(NamedTuple):
    best: Candidate
    """The most likely one."""
    chosen: Candidate
    """The smallest of those that are close to it."""
    finalists: Mapping[Candidate, Finalist]


def choose(rungs: Sequence[Rung], sizes: Mapping[Candidate, Size]) -> Choice:
    """Raises DataError where every training has failed."""
    last = rungs[-1]
    if not last.kept:
        first = next(record.problem for record in last.judged.values())
        raise DataError(f"Expected candidates whose training ends, found none: all failed; first: {first}")
    best = last.kept[0]
    finalists = {candidate: _compared(last.judged[best], last.judged[candidate]) for candidate in last.kept}
    close = [candidate for candidate, finalist in finalists.items() if finalist.close]
    return Choice(best, min(close, key=lambda candidate: _order(sizes[candidate])), finalists)


def _compared(best: Record, other: Record) -> Finalist:
    behind = paired(best, other)
    return Finalist(behind, behind.value <= behind.standard_error)


def _order(size: Size) -> tuple[int, int]:
    """By what is learnt; of equals, by what is drawn."""
    return size.parameters, size.vertices
