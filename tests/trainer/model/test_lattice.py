"""The lattice inside of shapes: where it begins, what it learns, and what it leaves alone."""

from dataclasses import replace

import torch
from torch import Tensor, nn

from trainer.config import LossConfig, ModelConfig, TrainConfig
from trainer.geometry.solid import cube_solid, inverted_volume
from trainer.model.vae import Model, model_of

SEGMENTS = 4
SETTINGS = ModelConfig(parameterisation="subdivision", segments=SEGMENTS)


def with_lattice() -> Model:
    torch.manual_seed(0)
    return Model(SETTINGS, 48, 36, lattice=True)


def inverted(model: Model, codes: Tensor) -> Tensor:
    carrying, tetrahedra = cube_solid(SEGMENTS)
    surface = model.decode(codes)
    inner = torch.tensor(carrying, dtype=torch.float32) @ surface + model.inner_offsets(codes)
    return inverted_volume(torch.cat((surface, inner), 1), torch.tensor(tetrahedra), 0.1).mean()


def crumpled() -> tuple[Model, Tensor]:
    """A model whose shapes are partly inside out, and codes of some."""
    model = with_lattice()
    nn.init.normal_(model.decoder.get_parameter("displacements.bias"), std=0.15)
    return model, torch.randn(8, SETTINGS.latent)


def test_a_model_has_one_where_the_loss_asks_for_it() -> None:
    assert model_of(TrainConfig(model=SETTINGS)).lattice is None
    assert model_of(TrainConfig(model=SETTINGS, loss=LossConfig(inversion_weight=1.0))).lattice is None
    learnt = LossConfig(inversion_weight=1.0, inner_points="learnt")
    assert model_of(TrainConfig(model=SETTINGS, loss=learnt)).lattice is not None


def test_it_has_the_points_of_a_cube_whose_edges_are_cut_unevenly() -> None:
    model = Model(replace(SETTINGS, segments=2, proportions=(1, 2, 3)), 48, 36, lattice=True)
    inner, _ = cube_solid(2, (1, 2, 3))
    assert model.inner_offsets(torch.zeros(1, SETTINGS.latent)).shape == (1, len(inner), 3)
    assert model.decode(torch.zeros(1, SETTINGS.latent)).shape == (1, inner.shape[1], 3)


def test_it_changes_none_of_the_other_weights_that_a_seed_gives() -> None:
    torch.manual_seed(0)
    plain, model = Model(SETTINGS, 48, 36).state_dict(), with_lattice().state_dict()
    assert all(torch.equal(tensor, model[name]) for name, tensor in plain.items())


def test_it_begins_where_the_surface_carries_it() -> None:
    offsets = with_lattice().inner_offsets(torch.randn(3, SETTINGS.latent))
    assert offsets.shape == (3, (SEGMENTS - 1) ** 3, 3)
    assert not offsets.any()


def test_learning_it_alone_makes_less_of_crumpled_shapes_inside_out() -> None:
    model, codes = crumpled()
    assert model.lattice is not None
    before, optimiser = inverted(model, codes).item(), torch.optim.Adam(model.lattice.parameters(), 1e-2)
    for _ in range(100):
        optimiser.zero_grad()
        inverted(model, codes).backward()
        optimiser.step()
    assert 0 < inverted(model, codes).item() < 0.8 * before


def test_surfaces_learn_from_where_they_are_alone() -> None:
    """Through the lattice, which shares the decoder's hidden units, no gradient reaches these."""
    model, codes = crumpled()
    assert model.lattice is not None
    nn.init.normal_(model.lattice.offsets.weight)
    model.inner_offsets(codes).square().sum().backward()
    reached = {name for name, weight in model.named_parameters() if weight.grad is not None and weight.grad.any()}
    assert reached == {"lattice.offsets.weight", "lattice.offsets.bias"}
