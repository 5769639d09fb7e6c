"""What the smoothing takes shapes' displacements from: against numpy's least squares, and boxes that cost nothing."""

from typing import Literal

import numpy as np
import pytest
import torch
from torch import Tensor

from trainer.config import LossConfig, ModelConfig, SceneConfig
from trainer.geometry.cup import subdivided_cup
from trainer.geometry.topology import BaseMesh, subdivided_cube
from trainer.model.displacement import displacements
from trainer.model.vae import Model
from trainer.training.loop import fixed_geometry

BASES = [subdivided_cube(4), subdivided_cup(4)]
SCENE = SceneConfig(24, 18)
SIZES, PLACE = torch.tensor([2.1, 0.6, 0.9]).double(), torch.tensor([0.03, -0.2, 0.1]).double()


def crumpled(base: BaseMesh) -> Tensor:
    """Three shapes, stretched, moved, and with noise on every vertex."""
    generator = torch.Generator().manual_seed(0)
    noise = torch.randn(3, *base.vertices.shape, generator=generator, dtype=torch.float64)
    return torch.as_tensor(base.vertices) * SIZES + PLACE + 0.05 * noise


@pytest.mark.parametrize("base", BASES)
def test_they_are_the_difference_from_the_base_mesh(base: BaseMesh) -> None:
    vertices, plain = crumpled(base), torch.as_tensor(base.vertices)
    assert torch.equal(displacements(vertices, plain, "base"), vertices - plain)


@pytest.mark.parametrize("base", BASES)
def test_stretched_ones_are_what_a_least_squares_fit_leaves_up_to_where_the_shape_lies(base: BaseMesh) -> None:
    vertices = crumpled(base)
    found = displacements(vertices, torch.as_tensor(base.vertices), "stretched").numpy()
    for number, shape in enumerate(vertices.numpy()):
        for axis in range(3):
            known = np.stack((base.vertices[:, axis], np.ones(len(shape))), 1)
            fit, *_ = np.linalg.lstsq(known, shape[:, axis], rcond=None)
            left = found[number, :, axis] - (shape[:, axis] - known @ fit)
            np.testing.assert_allclose(left, left.mean(), atol=1e-12)


def test_their_gradient_is_that_of_finite_differences() -> None:
    base = subdivided_cube(1)
    vertices = crumpled(base).requires_grad_()
    plain = torch.as_tensor(base.vertices)
    assert torch.autograd.gradcheck(lambda shapes: displacements(shapes, plain, "stretched"), (vertices,))


@pytest.mark.parametrize("base", ["cube", "cup"])
def test_smoothing_asks_nothing_of_a_stretched_base_unless_it_is_told_of_the_plain_one(
    base: Literal["cube", "cup"],
) -> None:
    model = Model(ModelConfig(base=base), SCENE.width, SCENE.height)
    laplacian = fixed_geometry(model, SCENE, LossConfig()).laplacian
    assert laplacian is not None
    plain = model.decoder.base_vertices
    box = (plain * SIZES.float() + PLACE.float())[None]
    assert (laplacian @ displacements(box, plain, "stretched")).square().sum() < 1e-9
    assert (laplacian @ displacements(box, plain, "base")).square().sum() > 0.1
