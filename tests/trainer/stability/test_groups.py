"""Pictures by what they show: each in one group."""

import numpy as np
import pytest

from trainer.evaluation.pictures import Truth
from trainer.stability.answers import Examinee, answers
from trainer.stability.conditions import Sitting
from trainer.stability.groups import groups, thinness_of
from trainer.stability.objects import pictures_of


def test_a_plate_is_thin_and_a_cube_is_not() -> None:
    plate, cube = np.zeros((32, 32, 32), bool), np.zeros((32, 32, 32), bool)
    plate[4:20, 10, 4:20] = True
    cube[4:14, 4:14, 4:14] = True
    assert thinness_of(plate) == 1
    assert thinness_of(cube) == pytest.approx(1 - 8**3 / 10**3)
    assert thinness_of(np.zeros((32, 32, 32), bool)) == 1


def test_groups_hold_every_picture_once(examined: Examinee, sitting: Sitting, truth: tuple[Truth, ...]) -> None:
    pictures = pictures_of(sitting.codes, sitting.shown, truth)
    found = groups(answers(examined, pictures), pictures)
    for parts in found.values():
        assert sum(part["pictures"] for part in parts) == len(pictures.codes)
    turned = np.degrees(np.abs(pictures.azimuths))
    straight = int((np.minimum(turned, 180 - turned) < 15).sum())
    assert sum(part["pictures"] for part in found["side"] if part["group"] == "0° to 15°") == straight


def test_orders_of_symmetry_are_told_apart(examined: Examinee, sitting: Sitting, truth: tuple[Truth, ...]) -> None:
    orders = (1.0, 1.0, 2.0, 4.0, 4.0, np.inf)
    known = tuple(one._replace(order=order) for one, order in zip(truth, orders, strict=True))
    pictures = pictures_of(sitting.codes, sitting.shown, known)
    found = groups(answers(examined, pictures), pictures)["symmetry"]
    assert [(part["group"], part["pictures"]) for part in found] == [
        ("none", 2),
        ("2", 1),
        ("3 and more", 2),
        ("continuous", 1),
    ]
    assert found[-1]["symmetric_azimuth_accuracy"] == 1
