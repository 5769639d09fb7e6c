"""What became of a candidate, and why."""

from trainer.selection.candidates import Candidate
from trainer.selection.choice import Choice
from trainer.selection.halving import Rung
from trainer.selection.record import paired, told


def verdict_on(candidate: Candidate, rung: Rung, choice: Choice) -> tuple[str, str]:
    """(a word, a sentence); `rung` is the last one that the candidate came to."""
    problem = rung.judged[candidate].problem
    if problem is not None:
        return "failed", f"failed on the way to step {rung.step}: {problem}"
    if candidate not in choice.finalists:
        return "dropped", _dropped(candidate, rung)
    return _of_finalist(candidate, choice)


def _of_finalist(candidate: Candidate, choice: Choice) -> tuple[str, str]:
    behind = f"{told(choice.finalists[candidate].behind)} behind the best"
    match candidate == choice.chosen, candidate == choice.best, choice.finalists[candidate].close:
        case True, True, _:
            return "chosen", "the most likely, and none that is smaller comes within a standard error of it"
        case True, False, _:
            return "chosen", f"the smallest of those within a standard error of the best ({behind})"
        case False, True, _:
            return "best", "the most likely, but one that is smaller comes within a standard error of it"
        case _, _, True:
            return "larger", f"within a standard error ({behind}), but not the smallest that is"
    return "worse", f"{behind}, more than a standard error"


def _dropped(candidate: Candidate, rung: Rung) -> str:
    judged = {other: record.mean for other, record in rung.judged.items() if record.problem is None}
    place = 1 + sum(mean > judged[candidate] for mean in judged.values())
    ahead = paired(rung.judged[rung.kept[-1]], rung.judged[candidate])
    return (
        f"place {place} of {len(judged)} after {rung.step} steps, {told(ahead)} behind the last of the "
        f"{len(rung.kept)} that went on"
    )
