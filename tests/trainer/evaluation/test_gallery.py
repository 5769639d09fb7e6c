"""Renderings of reconstructions show what the data's own pictures show."""

import math

import numpy as np
import pytest
import torch

from tests.trainer.evaluation.conftest import SCENE
from trainer.data.picture import draw
from trainer.data.shapes.solid import lathe, normalise
from trainer.evaluation.gallery import comparison_rows, render

# Smooth, so that the data's corner normals and the model's vertex normals agree.
VASE = normalise(lathe([(0.05, 0.0), (0.3, 0.1), (0.42, 0.3), (0.4, 0.5), (0.25, 0.7), (0.05, 0.8)], 32))


@pytest.mark.parametrize("light_degrees", [0.0, 50.0, 130.0])
def test_reconstructions_are_lit_as_pictures_are(light_degrees: float) -> None:
    azimuth, light = 0.4, math.radians(light_degrees)
    expected = draw(VASE, azimuth, light, SCENE)[0]
    vertices, faces = torch.tensor(VASE.vertices, dtype=torch.float32)[None], torch.tensor(VASE.faces.copy())
    found = render(faces, SCENE, vertices, torch.tensor([azimuth]), torch.tensor([light]))[0].permute(1, 2, 0).numpy()
    unlit = render(faces, SCENE, vertices, torch.tensor([azimuth]))[0].permute(1, 2, 0).numpy()
    assert np.abs(found - expected).mean() < 0.012
    if light_degrees:
        assert np.abs(unlit - expected).mean() > 3 * np.abs(found - expected).mean()
    else:
        np.testing.assert_allclose(found, unlit, atol=1e-6)


def test_the_sides_are_those_of_the_class_s_frame() -> None:
    """A shape in a frame turned by the offset shows the same sides as the shape in the class's frame."""
    offset = 0.7
    leaning = VASE.vertices * (1.0, 1.0, 0.6) + np.stack((0.2 * VASE.vertices[:, 1],) * 3, 1) * (1.0, 0.0, 0.0)
    turn = np.array([(math.cos(offset), 0, math.sin(offset)), (0, 1, 0), (-math.sin(offset), 0, math.cos(offset))])
    images = torch.zeros(1, 3, SCENE.height, SCENE.width)
    sides = []
    for vertices, angle in ((leaning, 0.0), (leaning @ turn.T, offset)):
        shapes = torch.tensor(vertices, dtype=torch.float32)[None]
        titles, (row,) = comparison_rows(torch.tensor(VASE.faces.copy()), SCENE, images, images, shapes, angle)
        sides.append(row[2:])
    assert titles[:2] == ["input", "reconstruction"]
    np.testing.assert_allclose(sides[0], sides[1], atol=2e-3)
    assert np.abs(sides[0][0] - sides[0][1]).mean() > 0.01
