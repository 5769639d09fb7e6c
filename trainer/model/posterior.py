"""Q_ω(z, θ, λ | x): the variational posterior, and its KL divergences from the prior (section 4 of the paper)."""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from trainer.geometry.conventions import wrap_angle

# Keeps a standard deviation away from zero, and its logarithm finite.
SMALLEST_DEVIATION = 1e-4


class LightPosterior(NamedTuple):
    """The parameters of Q(λ) for a batch of pictures; angles in radians."""

    logits: Float[Tensor, "B L"]
    fine_mean: Float[Tensor, "B"]  # ξ in (-π/2R, π/2R)
    fine_deviation: Float[Tensor, "B"]  # ζ


class Posterior(NamedTuple):
    """The parameters of Q for a batch of pictures; angles in radians."""

    shape_mean: Float[Tensor, "B Z"]
    shape_deviation: Float[Tensor, "B Z"]
    azimuth_logits: Float[Tensor, "B R"]
    azimuth_fine_mean: Float[Tensor, "B"]  # ξ in (-π/R, π/R)
    azimuth_fine_deviation: Float[Tensor, "B"]  # ζ
    light: LightPosterior | None = None
    """None where the light is fixed."""


class PosteriorHeads(nn.Module):
    """A fully connected layer for each parameter of Q (Appendix A); none for λ where `light_bins` is 0."""

    def __init__(self, features: int, latent: int, azimuth_bins: int, light_bins: int = 0) -> None:
        super().__init__()
        self.bins = azimuth_bins
        self.shape_mean = nn.Linear(features, latent)
        self.shape_deviation = nn.Linear(features, latent)
        self.azimuth_logits = nn.Linear(features, azimuth_bins)
        self.azimuth_fine_mean = nn.Linear(features, 1)
        self.azimuth_fine_deviation = nn.Linear(features, 1)
        self.light = LightHeads(features, light_bins) if light_bins else None

    def forward(self, features: Float[Tensor, "B features"]) -> Posterior:
        half_bin = math.pi / self.bins
        # The deviations start near softplus(0.54) ≈ 1 prior deviation for z, and softplus(0) ≈ 0.7 for θ_fine.
        return Posterior(
            self.shape_mean(features),
            functional.softplus(self.shape_deviation(features) + 0.54) + SMALLEST_DEVIATION,
            self.azimuth_logits(features),
            torch.tanh(self.azimuth_fine_mean(features)).squeeze(1) * half_bin,
            functional.softplus(self.azimuth_fine_deviation(features)).squeeze(1) * half_bin + SMALLEST_DEVIATION,
            None if self.light is None else self.light(features),
        )


class LightHeads(nn.Module):
    """A fully connected layer for each parameter of Q(λ) (Appendix A)."""

    def __init__(self, features: int, bins: int) -> None:
        super().__init__()
        self.bins = bins
        self.logits = nn.Linear(features, bins)
        self.fine_mean = nn.Linear(features, 1)
        self.fine_deviation = nn.Linear(features, 1)

    def forward(self, features: Float[Tensor, "B features"]) -> LightPosterior:
        half_bin = half_light_bin(self.bins)
        return LightPosterior(
            self.logits(features),
            torch.tanh(self.fine_mean(features)).squeeze(1) * half_bin,
            functional.softplus(self.fine_deviation(features)).squeeze(1) * half_bin + SMALLEST_DEVIATION,
        )


def pooled_over_views(posterior: Posterior, views: int) -> Posterior:
    """Q where each `views` consecutive pictures show one object: their means and deviations of z become the largest
    over all of them, dimension by dimension (section 4, "Shape"). Each picture keeps its own pose and light."""
    if views == 1:
        return posterior
    mean, deviation = (
        part.unflatten(0, (-1, views)).amax(1).repeat_interleave(views, 0)
        for part in (posterior.shape_mean, posterior.shape_deviation)
    )
    return posterior._replace(shape_mean=mean, shape_deviation=deviation)


def bin_centres(bins: int, like: Tensor) -> Float[Tensor, "R"]:
    """-π + r · 2π/R, the azimuths of the coarse bins in radians (Eq. 8)."""
    return torch.arange(bins, dtype=like.dtype, device=like.device) * (2 * math.pi / bins) - math.pi


def half_light_bin(bins: int) -> float:
    """π/2R, radians."""
    return math.pi / (2 * bins)


def light_bin_centres(bins: int, like: Tensor) -> Float[Tensor, "L"]:
    """(r + ½) · π/R, the coarse bins of λ in radians.

    They cover [0, π) evenly, as it is no circle: turned by π, a light above the horizon comes from elsewhere.
    """
    return (torch.arange(bins, dtype=like.dtype, device=like.device) + 0.5) * (math.pi / bins)


def most_probable_bin(posterior: Posterior) -> tuple[Float[Tensor, "B"], Float[Tensor, "B"]]:
    """Centre of the most probable coarse bin of the azimuth, and its probability."""
    probability, bins = posterior.azimuth_logits.softmax(1).max(1)
    return bin_centres(posterior.azimuth_logits.shape[1], posterior.azimuth_fine_mean)[bins], probability


def most_probable_azimuth(posterior: Posterior) -> Float[Tensor, "B"]:
    """Centre of the most probable coarse bin plus the mean of the fine angle, in [-π, π)."""
    return wrap_angle(most_probable_bin(posterior)[0] + posterior.azimuth_fine_mean)


def most_probable_light(posterior: Posterior) -> Float[Tensor, "B"] | None:
    """Centre of the most probable coarse bin of λ plus the mean of the fine angle; None where the light is fixed."""
    if posterior.light is None:
        return None
    centres = light_bin_centres(posterior.light.logits.shape[1], posterior.light.fine_mean)
    return centres[posterior.light.logits.argmax(1)] + posterior.light.fine_mean


def shape_divergence(posterior: Posterior) -> Float[Tensor, "B Z"]:
    """KL[Q(z) || Normal(0, 1)] of each dimension, nats."""
    return _normal_divergence(posterior.shape_mean, posterior.shape_deviation, 1.0)


def azimuth_fine_divergence(posterior: Posterior) -> Float[Tensor, "B"]:
    """KL[Q(θ_fine) || Normal(0, π/R)], nats (Eq. 10; π/R is a standard deviation)."""
    prior = math.pi / posterior.azimuth_logits.shape[1]
    return _normal_divergence(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, prior)


def light_fine_divergence(light: LightPosterior) -> Float[Tensor, "B"]:
    """KL[Q(λ_fine) || Normal(0, π/2R)], nats: half a bin is a standard deviation, as it is for θ."""
    return _normal_divergence(light.fine_mean, light.fine_deviation, half_light_bin(light.logits.shape[1]))


def divergence_between(taught: Posterior, learnt: Posterior) -> Float[Tensor, "B"]:
    """KL[taught || learnt] of z, θ and λ together, nats."""
    divergence = _normal_divergence(
        learnt.shape_mean - taught.shape_mean, taught.shape_deviation, learnt.shape_deviation
    ).sum(1)
    divergence = divergence + _angle_divergence(
        (taught.azimuth_logits, taught.azimuth_fine_mean, taught.azimuth_fine_deviation),
        (learnt.azimuth_logits, learnt.azimuth_fine_mean, learnt.azimuth_fine_deviation),
    )
    if taught.light is not None and learnt.light is not None:
        divergence = divergence + _angle_divergence(taught.light, learnt.light)
    return divergence


def _angle_divergence(taught: tuple[Tensor, Tensor, Tensor], learnt: tuple[Tensor, Tensor, Tensor]) -> Tensor:
    """Of logits of the coarse bins, and mean and deviation of the fine angle."""
    (taught_logits, taught_mean, taught_deviation), (logits, mean, deviation) = taught, learnt
    coarse = functional.kl_div(logits.log_softmax(1), taught_logits.log_softmax(1), log_target=True, reduction="none")
    return coarse.sum(1) + _normal_divergence(mean - taught_mean, taught_deviation, deviation)


def _normal_divergence(mean: Tensor, deviation: Tensor, prior_deviation: float | Tensor) -> Tensor:
    """KL from a normal distribution to one with `prior_deviation` whose mean lies `mean` away."""
    ratio = deviation / prior_deviation
    return 0.5 * (ratio.square() + (mean / prior_deviation).square() - 1.0) - ratio.log()
