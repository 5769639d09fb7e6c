"""Which shapes stand a quarter of a turn, or a half or three, beside others that they are like.

A corner sofa of one hand looks like one of the other hand that is turned by a quarter, and is its mirror image where it
stands right. So each shape is turned to where it is most like the others and their mirror images: a synchronisation
over the group of four turns, in which all choose by how the others stand, again and again.
"""

from typing import Final, NamedTuple

import numpy as np
from jaxtyping import Float, Integer
from numpy import ndarray

from trainer.evaluation.fronts import unit_occupancies

MOST_REFERENCES: Final = 1000
"""So many shapes, evenly chosen, settle among themselves how they stand; all others join them."""
TURNS: Final = 4

_POWER: Final = 4
"""Of the likeness: few that are very like say more than many that are hardly so."""
_ROUNDS: Final = 30
_BATCH: Final = 400


class _Likeness(NamedTuple):
    """Powers of the cosine of each pair's occupancies, the first of it turned by so many quarters."""

    same_hand: Float[ndarray, "4 N M"]
    other_hand: Float[ndarray, "4 N M"]
    """To the mirror image of the second, across x = 0."""


def quarter_turns(shapes: Float[ndarray, "N V 3"], faces: Integer[ndarray, "F 3"]) -> Integer[ndarray, "N"]:
    """By how many quarters, 0 to 3, each shape is to be turned about +Y, left-handed, from +x towards +z.

    The shapes' plane of symmetry, if they have one, is x = 0 or z = 0. All of them turned alike would be as much alike:
    they begin as they stand, so that what most have stays. Where they do not settle, the last of the rounds counts.
    """
    chosen = np.linspace(0, len(shapes) - 1, min(MOST_REFERENCES, len(shapes))).round().astype(np.int64)
    references = unit_occupancies(shapes[chosen], faces)
    settled = _settled(_likeness(references, references))
    turns = np.empty(len(shapes), np.int64)
    for start in range(0, len(shapes), _BATCH):
        batch = slice(start, start + _BATCH)
        turns[batch] = _chosen(_likeness(unit_occupancies(shapes[batch], faces), references), settled)
    turns[chosen] = settled
    return turns


def _likeness(solids: Float[ndarray, "N R R R"], others: Float[ndarray, "M R R R"]) -> _Likeness:
    images = others[:, ::-1]
    turned = [np.rot90(solids, turn, axes=(1, 3)).reshape(len(solids), -1) for turn in range(TURNS)]
    flat, mirrored = (shapes.reshape(len(others), -1).T for shapes in (others, images))
    return _Likeness(
        np.stack([solid @ flat for solid in turned]) ** _POWER,
        np.stack([solid @ mirrored for solid in turned]) ** _POWER,
    )


def _settled(likeness: _Likeness) -> Integer[ndarray, "M"]:
    """The turns of those that settle it, beginning as they stand."""
    for part in likeness:
        for turn in range(TURNS):
            np.fill_diagonal(part[turn], 0)
    turns = np.zeros(likeness.same_hand.shape[1], np.int64)
    for _ in range(_ROUNDS):
        before, turns = turns, _chosen(likeness, turns)
        if np.array_equal(before, turns):
            break
    return turns


def _chosen(likeness: _Likeness, others: Integer[ndarray, "M"]) -> Integer[ndarray, "N"]:
    """The turns by which shapes are most like those that stand as `others` are turned, or their mirror images."""
    scores = np.zeros((TURNS, likeness.same_hand.shape[1]))
    for turn in range(TURNS):
        for other in range(TURNS):
            those = others == other
            # A mirror image of what is turned to one side is the mirror image, turned to the other.
            same, mirrored = likeness.same_hand[turn - other], likeness.other_hand[(turn + other) % TURNS]
            scores[turn] += np.maximum(same[:, those], mirrored[:, those]).sum(1)
    return np.asarray(scores.argmax(0))
