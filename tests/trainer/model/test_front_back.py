"""How unlike front and back are, against a transcription, and for shapes that are mirrored by what decodes them."""

import math
from typing import Literal

import pytest
import torch

from trainer.config import ModelConfig
from trainer.model.front_back import Sides, sides_of, unlikeness
from trainer.model.vae import Model

# Vertices 0 and 1 lie across z = 0 from each other, vertex 2 lies in it.
SIDES = Sides(torch.tensor([0, 0, 2]), torch.tensor([[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 0.0]]))
ALIKE = torch.tensor([[0.1, 0.2, 0.3], [0.1, 0.2, -0.3], [0.4, 0.5, 0.0]])


def test_unlikeness_is_the_sum_of_the_distances() -> None:
    moved = ALIKE + torch.tensor([[0.0, 0.0, 0.0], [0.3, 0.0, 0.4], [0.0, 0.0, 0.2]])
    found = unlikeness(torch.stack((ALIKE, moved)), SIDES)
    # A distance d counts √(d² + 0.01²) − 0.01.
    expected = sum(math.hypot(distance, 0.01) - 0.01 for distance in (0.5, 0.2))
    torch.testing.assert_close(found, torch.tensor([0.0, expected]))


@pytest.mark.parametrize("knee", [0.1, 2.0])
def test_beyond_the_knee_it_counts_as_its_logarithm(knee: float) -> None:
    distances = torch.tensor([0.0, 0.001, 1000.0])
    moved = ALIKE.repeat(3, 1, 1)
    moved[:, 1, 0] += distances
    plain, found = unlikeness(moved, SIDES), unlikeness(moved, SIDES, knee)
    torch.testing.assert_close(found, torch.tensor([knee * math.log(1 + one / knee) for one in plain.tolist()]))
    assert found[1] == pytest.approx(plain[1].item(), rel=0.01)
    assert found[2] < knee * math.log(1.1 * 1000 / knee)


def test_there_is_a_gradient_where_nothing_is_unlike() -> None:
    vertices = ALIKE[None].clone().requires_grad_()
    unlikeness(vertices, SIDES).sum().backward()
    assert vertices.grad is not None
    assert vertices.grad.isfinite().all()


@pytest.mark.parametrize("base", ["cube", "cup"])
@pytest.mark.parametrize(("symmetry", "alike"), [("mirror", False), ("two-mirrors", True)])
def test_two_mirrors_leave_nothing_unlike(
    base: Literal["cube", "cup"], symmetry: Literal["mirror", "two-mirrors"], alike: bool
) -> None:
    torch.manual_seed(0)
    model = Model(ModelConfig(segments=2, base=base, symmetry=symmetry), 32, 24)
    for parameter in model.decoder.parameters():
        torch.nn.init.normal_(parameter, std=0.5)
    found = unlikeness(model.decode(torch.randn(5, model.config.latent)), sides_of(model.decoder.base_vertices))
    assert (found < 1e-5).all() if alike else (found > 0.1).all()
