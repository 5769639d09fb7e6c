"""Rotational symmetry of objects whose symmetry is plain to see."""

import math

import numpy as np
import pytest

from tests.trainer.evaluation.test_voxels import sphere
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, cylinder, joined, lathe, normalise, turned
from trainer.evaluation.surface import visible_surface
from trainer.evaluation.symmetry import REFERENCE_POINTS, rotational_order
from trainer.evaluation.voxels import occupy


def order(mesh: Mesh) -> float:
    shape = normalise(mesh)
    return rotational_order(visible_surface(*shape, occupy(*shape).air, REFERENCE_POINTS))


def table(x: float, z: float) -> Mesh:
    legs = [box((0.05, 0.7, 0.05), (sx * x * 0.43, 0.35, sz * z * 0.43)) for sx in (-1, 1) for sz in (-1, 1)]
    return joined(box((x, 0.04, z), (0.0, 0.7, 0.0)), *legs)


def spokes(count: int) -> Mesh:
    angles = 2 * math.pi * np.arange(count) / count
    return joined(*(cylinder((0, 0.1, 0), (0.4 * math.sin(a), 0.03, 0.4 * math.cos(a)), 0.025) for a in angles))


VASE = lathe([(0.1, 0.0), (0.3, 0.3), (0.1, 0.7), (0.15, 0.8)])
STAR = joined(spokes(5), cylinder((0, 0.1, 0), (0, 0.5, 0), 0.03))
OFFICE_CHAIR = joined(STAR, box((0.5, 0.08, 0.5), (0.0, 0.5, 0.0)), box((0.45, 0.5, 0.06), (0.0, 0.85, -0.24)))


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (table(1.2, 0.7), 2),
        (table(0.8, 0.8), 4),
        (table(0.8, 0.9), 2),
        (VASE, math.inf),
        (sphere(0.4), math.inf),
        (joined(VASE, box((0.12, 0.25, 0.04), (0.28, 0.4, 0.0))), 1),
        (joined(VASE, *(box((0.1, 0.25, 0.04), (side * 0.28, 0.4, 0.0)) for side in (-1, 1))), 2),
        (joined(spokes(3), lathe([(0.2, 0.1), (0.2, 0.15)])), 3),
        (STAR, 5),
        (joined(spokes(6), lathe([(0.2, 0.1), (0.2, 0.15)])), 6),
        (spokes(8), 8),
        (OFFICE_CHAIR, 1),
        (box((0.5, 0.3, 0.2), (0.0, 0.0, 0.0), (0.5, 1.0)), 2),
    ],
    ids=["table", "square table", "nearly square table", "vase", "ball", "mug", "two handles", "three legs", "star",
         "six legs", "eight legs", "office chair", "wedge"],
)  # fmt: skip
def test_the_symmetry_is_found(mesh: Mesh, expected: float) -> None:
    assert order(mesh) == expected
    assert order(turned(mesh, 1, 0.7)) == expected


def test_what_has_a_front_has_no_symmetry() -> None:
    assert [order(make_shape("chair", seed)) for seed in range(8)] == [1] * 8
    assert [order(make_shape("car", seed)) for seed in range(8)] == [1] * 8


def test_what_is_hidden_does_not_break_a_symmetry() -> None:
    assert order(joined(VASE, box((0.1, 0.1, 0.02), (0.05, 0.3, 0.05)))) == math.inf
