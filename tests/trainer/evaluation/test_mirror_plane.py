"""The plane of symmetry of shapes that were turned."""

import math

import numpy as np
import pytest

from trainer.data.picture import rotation_about_y
from trainer.data.shapes.solid import box, joined, normalise
from trainer.evaluation.mirror_plane import mirror_plane

# Mirrored in x = 0, and in no other upright plane: a wedge, high behind and low in front.
VERTICES, FACES = normalise(joined(box((0.5, 0.2, 1.0), (0.0, 0.1, 0.0)), box((0.4, 0.3, 0.2), (0.0, 0.35, -0.4))))


@pytest.mark.parametrize("degrees", [0.0, 37.0, -80.0, 89.0, 150.0])
def test_it_turns_with_the_shapes(degrees: float) -> None:
    wide = VERTICES * (1.5, 1.0, 1.0)
    shapes = np.stack([VERTICES, wide]) @ rotation_about_y(math.radians(degrees)).T
    found = math.degrees(mirror_plane(shapes, FACES))
    assert -90 <= found < 90
    assert (found - degrees + 90) % 180 - 90 == pytest.approx(0, abs=2)


def test_the_plane_of_most_shapes_is_that_of_all() -> None:
    across = VERTICES @ rotation_about_y(math.pi / 2).T
    assert math.degrees(mirror_plane(np.stack([VERTICES, VERTICES, across]), FACES)) == pytest.approx(0, abs=2)
