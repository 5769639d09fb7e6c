"""The bound against the formula written out, the integral that it bounds, and the training objective."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.trainer.new_model import HEIGHT, WIDTH, new_model
from trainer.config import LossConfig, ModelConfig, SceneConfig
from trainer.evaluation.gallery import render
from trainer.model.loss import training_loss
from trainer.model.vae import Model
from trainer.rendering import reference
from trainer.selection.bound import empty_log_likelihood, held_out_bound, noise_variance
from trainer.training.schedule import weights_at

SCENE, LOSS = SceneConfig(WIDTH, HEIGHT), LossConfig(kl_weight=8.0)
VARIANCE = 8.0 * WIDTH * HEIGHT / (128 * 96)


def pictures(count: int) -> torch.Tensor:
    """Of cubes from other sides, so that no model explains them well, and none not at all."""
    model = new_model()
    return render(model.faces, SCENE, model.decode(torch.zeros(count, 3)), torch.linspace(-2.0, 2.5, count)).detach()


def log_density(model: Model, image: torch.Tensor, code: torch.Tensor, azimuth: float, light: float | None) -> float:
    """log p(x | z, θ, λ) up to the constant, by the reference's pyramid."""
    turn = None if light is None else torch.tensor([light])
    with torch.no_grad():
        drawn = render(model.faces, SCENE, model.decode(code[None]), torch.tensor([azimuth]), turn)[0]
    return float(reference.log_likelihood(drawn.double(), image.double())) / VARIANCE


def test_the_bound_is_the_formula_written_out() -> None:
    model, images, samples = new_model(), pictures(2), 3
    found = held_out_bound(model, SCENE, LOSS, images, samples, torch.Generator().manual_seed(5))
    with torch.no_grad():
        posterior = model.encode(images)
    light = posterior.light
    assert light is not None
    noise = torch.Generator().manual_seed(5)
    expected = np.zeros(2)
    for _ in range(samples):
        codes = posterior.shape_mean + posterior.shape_deviation * torch.randn(2, 3, generator=noise)
        fine = posterior.azimuth_fine_mean + posterior.azimuth_fine_deviation * torch.randn(2, generator=noise)
        turn = light.fine_mean + light.fine_deviation * torch.randn(2, generator=noise)
        for picture in range(2):
            densities = [
                log_density(
                    model,
                    images[picture],
                    codes[picture],
                    -math.pi + bin_ * 2 * math.pi / 12 + float(fine[picture]),
                    (side + 0.5) * math.pi / 3 + float(turn[picture]),
                )
                for bin_ in range(12)
                for side in range(3)
            ]
            top = max(densities)
            total = sum(math.exp(density - top) for density in densities)
            expected[picture] += (top + math.log(total / 36)) / samples
    np.testing.assert_allclose(found.log_likelihood, expected, atol=2e-3)

    def divergence(mean: torch.Tensor, deviation: torch.Tensor, prior: float) -> np.ndarray:
        s, m = deviation.detach().numpy() / prior, mean.detach().numpy() / prior
        return (s**2 + m**2 - 1) / 2 - np.log(s)

    shape = divergence(posterior.shape_mean, posterior.shape_deviation, 1.0).sum(1)
    angles = divergence(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, math.pi / 12)
    angles = angles + divergence(light.fine_mean, light.fine_deviation, math.pi / 6)
    np.testing.assert_allclose(found.shape_nats, shape, rtol=1e-4)
    np.testing.assert_allclose(found.angle_nats, angles, rtol=1e-4)
    np.testing.assert_allclose(found.value, expected - shape - angles, atol=5e-3)


def test_it_lies_below_the_integral_and_near_it_where_noise_hides_most() -> None:
    """One dimension of shape and a fixed light: log p(x) is a double integral that a grid gives."""
    torch.manual_seed(3)
    small = (4, 4, 4, 4, 4, 8)
    config = ModelConfig(latent=1, parameterisation="ortho-block", blocks=1, encoder_channels=small, azimuth_bins=4)
    model = Model(config, WIDTH, HEIGHT).eval()
    with torch.no_grad():
        model.decoder.scales.weight.mul_(20)  # type: ignore[union-attr, operator]
    image, loss = pictures(1), replace(LOSS, kl_weight=200.0)
    variance = noise_variance(loss, WIDTH, HEIGHT)
    grid = torch.linspace(-4, 4, 13)
    density = torch.exp(-grid.square() / 2)
    density = density / density.sum()
    azimuths = torch.tensor([(bin_ - 2 + float(fine) / 2) * math.pi / 2 for bin_ in range(4) for fine in grid])
    integral = 0.0
    for code, weight in zip(grid, density, strict=True):
        with torch.no_grad():
            vertices = model.decode(code[None, None]).expand(len(azimuths), -1, -1)
            drawn = render(model.faces, SCENE, vertices, azimuths).double()
        values = torch.stack([reference.log_likelihood(one, image[0].double()) for one in drawn]) / variance
        integral += float(weight * (values.exp().reshape(4, -1) * density).sum() / 4)
    found = float(held_out_bound(model, SCENE, loss, image, 256, torch.Generator().manual_seed(0)).value)
    assert math.log(integral) - 2 < found < math.log(integral)


def test_with_one_bin_it_is_the_training_s_last_objective_in_other_units() -> None:
    """Which is why ε² is what it is: the loss's first two terms are −ε² times the bound."""
    torch.manual_seed(0)
    model = Model(ModelConfig(latent=2, azimuth_bins=1, encoder_channels=(4, 4, 4, 4, 4, 8)), WIDTH, HEIGHT).eval()
    images = pictures(3)
    bound = held_out_bound(model, SCENE, LOSS, images, 1, torch.Generator().manual_seed(0))
    weights = weights_at(LOSS, 10**6, WIDTH, HEIGHT)
    variance = noise_variance(LOSS, WIDTH, HEIGHT)
    with torch.no_grad():
        loss = training_loss(weights, bound.log_likelihood * variance, model.encode(images), None, None)
    assert variance == pytest.approx(VARIANCE)
    assert float(loss.reconstruction + loss.kl) == pytest.approx(-variance * float(bound.value.mean()), rel=1e-5)


def test_a_hundred_samples_scatter_less_about_the_same_mean_than_one() -> None:
    model, images = new_model(), pictures(2)[:1]

    def drawn(samples: int, seed: int) -> float:
        generator = torch.Generator().manual_seed(seed)
        return float(held_out_bound(model, SCENE, LOSS, images, samples, generator).value)

    single = np.array([drawn(1, seed) for seed in range(40)])
    many = drawn(200, 99)
    assert abs(single.mean() - many) < 4 * single.std(ddof=1) / math.sqrt(40)


def test_black_pictures_are_explained_by_nothing() -> None:
    images = torch.stack((torch.zeros(3, HEIGHT, WIDTH), torch.full((3, HEIGHT, WIDTH), 0.5)))
    empty = empty_log_likelihood(LOSS, images)
    assert float(empty[0]) == 0.0
    # The pyramid of a constant is constant: 24 · 32, 12 · 16, 6 · 8, 3 · 4, 2 · 2, 1 · 1 pixels of 3 · 0.5², times 4^l.
    total = sum(4**level * pixels for level, pixels in enumerate((768, 192, 48, 12, 4, 1)))
    assert float(empty[1]) == pytest.approx(-0.5 * 0.75 * total / VARIANCE, rel=1e-5)


def test_silhouettes_are_compared_where_training_compares_them() -> None:
    model, images = new_model(), pictures(2)
    silhouette = replace(LOSS, kind="silhouette")
    shading, outline = (
        held_out_bound(model, SCENE, config, images, 2, torch.Generator().manual_seed(0))
        for config in (LOSS, silhouette)
    )
    assert not torch.allclose(shading.log_likelihood, outline.log_likelihood)
    assert torch.equal(shading.shape_nats, outline.shape_nats)
