"""Shapes of which some stand back to front."""

import numpy as np
import pytest

from trainer.data.shapes.solid import Mesh, box, joined
from trainer.evaluation.fronts import MOST_REFERENCES, back_to_front

RNG = np.random.default_rng(3)


def pickup(cab: float, height: float) -> Mesh:
    """A truck, its cab in front: at +z."""
    return joined(box((0.35, 0.15, 0.9), (0.0, -0.1, 0.0)), box((0.33, height, cab), (0.0, height / 2 - 0.05, 0.25)))


def trucks(count: int) -> tuple[np.ndarray, np.ndarray]:
    made = [pickup(*RNG.uniform((0.15, 0.15), (0.35, 0.35))) for _ in range(count)]
    return np.stack([vertices for vertices, _ in made]), made[0][1]


def turned_round(shapes: np.ndarray, which: np.ndarray) -> np.ndarray:
    return np.where(which[:, None, None], shapes * (-1.0, 1.0, -1.0), shapes)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.4])
def test_those_that_stand_otherwise_are_found(share: float) -> None:
    shapes, faces = trucks(40)
    turned = np.arange(40) < share * 40
    np.testing.assert_array_equal(back_to_front(turned_round(shapes, turned), faces), turned)


def test_the_fewer_ones_are_turned() -> None:
    shapes, faces = trucks(20)
    turned = np.arange(20) < 14
    np.testing.assert_array_equal(back_to_front(turned_round(shapes, turned), faces), ~turned)


def test_where_a_shape_lies_along_the_mirror_says_nothing_of_its_front() -> None:
    """The middle of a bounding box moves with every antenna."""
    shapes, faces = trucks(30)
    turned = RNG.random(30) < 0.3
    along = RNG.choice((-0.09, 0.0, 0.09), 30)[:, None] * np.array([0.0, 0.0, 1.0])
    np.testing.assert_array_equal(back_to_front(turned_round(shapes, turned) * 0.8 + along[:, None], faces), turned)


def test_more_than_settle_it_join_them() -> None:
    shapes, faces = trucks(MOST_REFERENCES // 4)
    many = np.concatenate([shapes] * 5)
    turned = np.arange(len(many)) % 7 == 3
    np.testing.assert_array_equal(back_to_front(turned_round(many, turned), faces), turned)
