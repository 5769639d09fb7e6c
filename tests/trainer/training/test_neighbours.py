"""Which pictures lend each other shapes, against a search written out, and what is learnt from it."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from tests.trainer.training.runs import run, with_steps
from trainer.config import LossConfig, OptimiserConfig, Symmetry, TrainConfig
from trainer.data.images import ImageSet
from trainer.geometry.conventions import wrap_angle
from trainer.model.posterior import bin_centres, most_probable_azimuth
from trainer.model.vae import Model
from trainer.rendering import renderer
from trainer.training.checkpoint import load_checkpoint
from trainer.training.loop import fixed_geometry
from trainer.training.neighbours import APART, NEAR, REMEMBERED, Memory, lent_codes
from trainer.training.schedule import weights_at
from trainer.training.step import CREASES, StepResult, forward
from trainer.training.views import bin_views

LATENT = 4


def filled(count: int, seed: int = 0) -> Memory:
    generator = torch.Generator().manual_seed(seed)
    memory = Memory(LATENT)
    memory.remember(torch.randn(count, LATENT, generator=generator), 7 * torch.randn(count, generator=generator))
    return memory


def test_the_latest_are_remembered_in_memory_that_stays() -> None:
    memory = Memory(2)
    assert memory.azimuths.isnan().all()
    where = memory.codes.data_ptr(), memory.azimuths.data_ptr()
    numbers = torch.arange(REMEMBERED + 10.0)
    for part in numbers.split(64):
        memory.remember(torch.stack([part, -part], 1), part)
    assert torch.equal(memory.azimuths, numbers[10:])
    assert torch.equal(memory.codes, torch.stack([numbers[10:], -numbers[10:]], 1))
    memory.remember(torch.zeros(REMEMBERED + 1, 2), torch.arange(REMEMBERED + 1.0))
    assert (float(memory.azimuths[0]), len(memory.codes)) == (1, REMEMBERED)
    assert where == (memory.codes.data_ptr(), memory.azimuths.data_ptr())


@pytest.mark.parametrize("symmetry", ["none", "mirror", "two-mirrors"])
def test_a_neighbour_is_the_nearest_of_those_from_the_direction_that_was_drawn(symmetry: Symmetry) -> None:
    memory, generator = filled(300), torch.Generator().manual_seed(1)
    codes = torch.randn(40, LATENT, generator=generator)
    azimuths, directions = 5 * torch.randn(2, 40, generator=generator)
    found = lent_codes(memory, codes, azimuths, directions, symmetry)

    def between(one: float, other: float) -> float:
        return math.acos(max(-1.0, min(1.0, math.cos(one - other))))

    def like(seen: float) -> list[float]:
        sides = [seen] if symmetry == "none" else [seen, -seen]
        return sides + [side + math.pi for side in sides] if symmetry == "two-mirrors" else sides

    known = [(code, float(azimuth)) for code, azimuth in zip(memory.codes, memory.azimuths, strict=True)][-300:]
    alone = 0
    for code, azimuth, direction, lent in zip(codes, azimuths.tolist(), directions.tolist(), found, strict=True):
        eligible = [
            other
            for other, seen in known
            if min(between(azimuth, side) for side in like(seen)) >= APART
            and min(between(direction, side) for side in like(seen)) <= NEAR
        ]
        alone += not eligible
        expected = min(eligible, key=lambda other: float((other - code).square().sum()), default=code)
        torch.testing.assert_close(lent, expected)
    # Directions near the picture's own have nobody to lend.
    assert 0 < alone < 20


def test_a_picture_without_neighbours_keeps_its_own_code() -> None:
    codes = torch.randn(3, LATENT, requires_grad=True)
    lent = lent_codes(Memory(LATENT), codes, torch.zeros(3), torch.ones(3), False)
    assert torch.equal(lent, codes)
    assert not lent.requires_grad


def look(config: TrainConfig, images: ImageSet, memory: Memory | None, step: int) -> tuple[Model, StepResult, Tensor]:
    torch.manual_seed(0)
    # Running means of the batch normalisation, so that codes stay what they are.
    model = Model(config.model, config.width, config.height).eval()
    batch = images.batch(np.arange(8))
    weights = weights_at(config.loss, step, config.width, config.height)
    geometry = fixed_geometry(model, images.scene, config.loss)
    generator = torch.Generator().manual_seed(0)
    seen = geometry, images.scene, config.loss, weights, batch, None, generator, torch.float32, 1, memory
    return model, forward(model, *seen), batch


def test_the_term_is_the_likelihood_under_a_neighbour_s_shape_and_teaches_the_decoder_alone(
    config: TrainConfig, images: ImageSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = replace(config, loss=LossConfig(neighbour_weight=0.7, e_step_centred_steps=3))
    lent = torch.randn(8, config.model.latent, generator=torch.Generator().manual_seed(2))
    monkeypatch.setattr("trainer.training.step.lent_codes", lambda *_: lent)
    weighed: list[Tensor] = []
    original = renderer.expected_log_likelihood

    def watched(screen: Tensor, colours: Tensor, pictures: Tensor, weights: Tensor, *others: object) -> Tensor:
        weighed.append(weights)
        return original(screen, colours, pictures, weights, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(renderer, "expected_log_likelihood", watched)
    model, result, batch = look(config, images, Memory(config.model.latent), 3)
    assert len(weighed) == 2
    assert torch.equal(*weighed)

    generator = torch.Generator().manual_seed(0)
    torch.randn(8, config.model.latent, generator=generator)
    posterior = model.encode(batch)
    fine = posterior.azimuth_fine_mean + posterior.azimuth_fine_deviation * torch.randn(8, generator=generator)
    views = bin_views(model, images.scene, model.decode(lent), fine, None)
    topology = fixed_geometry(model, images.scene, config.loss).topology
    expected = original(*views, batch, weighed[0], topology, CREASES["contours"], 0.0)
    assert result.terms.neighbours.item() == pytest.approx(-0.7 * expected.mean().item(), rel=1e-5)
    gradients = torch.autograd.grad(result.terms.neighbours, list(model.parameters()), allow_unused=True)
    taught = {name for (name, _), one in zip(model.named_parameters(), gradients, strict=True) if one is not None}
    assert taught == {f"decoder.{name}" for name, _ in model.decoder.named_parameters()}


def test_neighbours_are_asked_once_bins_are_told_apart(config: TrainConfig, images: ImageSet) -> None:
    config = replace(config, loss=LossConfig(neighbour_weight=0.7, e_step_centred_steps=3))
    assert [weights_at(config.loss, step, 64, 48).neighbours for step in (0, 2, 3)] == [0, 0, 0.7]
    assert look(config, images, filled(10), 2)[1].terms.neighbours.item() == 0
    assert weights_at(LossConfig(), 10**6, 64, 48).neighbours == 0


def test_a_step_tells_the_most_probable_azimuths(
    config: TrainConfig, images: ImageSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the E-step's posterior; by the encoder's own in the paper's objective."""
    bins = config.model.azimuth_bins
    chosen = torch.arange(8) % bins
    monkeypatch.setattr("trainer.training.step.e_step", lambda *_: torch.eye(bins)[chosen])
    _, result, _ = look(config, images, None, 0)
    centres = bin_centres(bins, result.azimuth)
    torch.testing.assert_close(result.azimuth, centres[chosen] + result.posterior.azimuth_fine_mean.detach())
    paper = replace(config, loss=replace(config.loss, objective="paper"))
    _, result, _ = look(paper, images, None, 0)
    most_probable = most_probable_azimuth(result.posterior).detach()
    torch.testing.assert_close(wrap_angle(result.azimuth), wrap_angle(most_probable))


def test_a_resumed_training_has_the_same_neighbours(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    loss = replace(config.loss, neighbour_weight=1.0, e_step_centred_steps=2)
    config = replace(config, loss=loss, optimiser=OptimiserConfig(batch_size=8, steps=8))
    whole = run(config, images, tmp_path / "whole")
    run(with_steps(config, 4), images, tmp_path / "parts")
    half = load_checkpoint(tmp_path / "parts").memory
    assert half is not None
    assert int(half.azimuths.isfinite().sum()) == 4 * 8
    resumed = run(config, images, tmp_path / "parts", resume=True)
    for one, other in zip(whole.model.state_dict().values(), resumed.model.state_dict().values(), strict=True):
        assert torch.equal(one, other)
    assert whole.memory is not None
    assert resumed.memory is not None
    assert torch.equal(whole.memory.codes, resumed.memory.codes)
    without = run(replace(config, loss=replace(loss, neighbour_weight=0.0)), images, tmp_path / "without")
    assert without.memory is None
    assert any(
        not torch.equal(one, other)
        for one, other in zip(whole.model.state_dict().values(), without.model.state_dict().values(), strict=True)
    )
