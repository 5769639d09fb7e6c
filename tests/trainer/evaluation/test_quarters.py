"""Shapes of which some stand by quarters of a turn beside the others, or beside mirror images of these."""

import numpy as np
import pytest

from trainer.data.picture import rotation_about_y
from trainer.data.shapes.solid import box, joined, mirrored
from trainer.evaluation import quarters as module
from trainer.evaluation.quarters import quarter_turns

RNG = np.random.default_rng(5)


def corner_sofas(left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Seats before a back, with a longer part at +x, or at -x for the other hand."""
    made = []
    for hand in left:
        depth, reach = RNG.uniform((0.25, 0.3), (0.3, 0.4))
        seat = box((0.8, 0.25, depth), (0.0, -0.1, -0.2))
        back = box((0.8, 0.2, 0.1), (0.0, 0.1, -0.3))
        sofa = joined(seat, back, box((0.25, 0.25, reach), (0.27, -0.1, reach / 2)))
        made.append(mirrored(sofa) if hand else sofa)
    return np.stack([vertices for vertices, _ in made]), made[0].faces


def stood(shapes: np.ndarray, quarters: np.ndarray) -> np.ndarray:
    """Turned such that they are to be turned by so many quarters to stand as they were."""
    return np.stack(
        [shape @ rotation_about_y(np.pi / 2 * turn).T for shape, turn in zip(shapes, quarters, strict=True)]
    )


@pytest.mark.parametrize("share", [0.0, 0.1, 0.4])
def test_those_that_stand_otherwise_are_turned_back(share: float) -> None:
    shapes, faces = corner_sofas(np.zeros(40, np.bool_))
    quarters = np.where(np.arange(40) < share * 40, np.arange(40) % 3 + 1, 0)
    np.testing.assert_array_equal(quarter_turns(stood(shapes, quarters), faces), quarters)


def test_those_of_the_other_hand_are_like_mirror_images() -> None:
    left = np.arange(60) % 2 == 1
    shapes, faces = corner_sofas(left)
    quarters = np.where(np.arange(60) % 7 == 3, 1, 0)
    np.testing.assert_array_equal(quarter_turns(stood(shapes, quarters), faces), quarters)


def test_more_than_settle_it_join_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_REFERENCES", 30)
    shapes, faces = corner_sofas(np.zeros(25, np.bool_))
    many = np.concatenate([shapes] * 4)
    quarters = np.where(np.arange(len(many)) % 7 == 3, 3, 0)
    np.testing.assert_array_equal(quarter_turns(stood(many, quarters), faces), quarters)
