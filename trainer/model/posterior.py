"""Q_ω(z, θ | x): the variational posterior, and its KL divergences from the prior (section 4 of the paper)."""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from trainer.geometry.conventions import wrap_angle

# Keeps a standard deviation away from zero, and its logarithm finite.
SMALLEST_DEVIATION = 1e-4


class Posterior(NamedTuple):
    """The parameters of Q for a batch of pictures; angles in radians."""

    shape_mean: Float[Tensor, "B Z"]
    shape_deviation: Float[Tensor, "B Z"]
    azimuth_logits: Float[Tensor, "B R"]
    azimuth_fine_mean: Float[Tensor, "B"]  # ξ in (-π/R, π/R)
    azimuth_fine_deviation: Float[Tensor, "B"]  # ζ


class PosteriorHeads(nn.Module):
    """A fully connected layer for each parameter of Q (Appendix A)."""

    def __init__(self, features: int, latent: int, azimuth_bins: int) -> None:
        super().__init__()
        self.bins = azimuth_bins
        self.shape_mean = nn.Linear(features, latent)
        self.shape_deviation = nn.Linear(features, latent)
        self.azimuth_logits = nn.Linear(features, azimuth_bins)
        self.azimuth_fine_mean = nn.Linear(features, 1)
        self.azimuth_fine_deviation = nn.Linear(features, 1)

    def forward(self, features: Float[Tensor, "B features"]) -> Posterior:
        half_bin = math.pi / self.bins
        # The deviations start at softplus(0.54) ≈ 1 prior deviation for z, and at that share of a bin for θ_fine.
        return Posterior(
            self.shape_mean(features),
            functional.softplus(self.shape_deviation(features) + 0.54) + SMALLEST_DEVIATION,
            self.azimuth_logits(features),
            torch.tanh(self.azimuth_fine_mean(features)).squeeze(1) * half_bin,
            functional.softplus(self.azimuth_fine_deviation(features)).squeeze(1) * half_bin + SMALLEST_DEVIATION,
        )


def bin_centres(bins: int, like: Tensor) -> Float[Tensor, "R"]:
    """-π + r · 2π/R, the azimuths of the coarse bins in radians (Eq. 8)."""
    return torch.arange(bins, dtype=like.dtype, device=like.device) * (2 * math.pi / bins) - math.pi


def most_probable_azimuth(posterior: Posterior) -> Float[Tensor, "B"]:
    """Centre of the most probable coarse bin plus the mean of the fine angle, in [-π, π)."""
    centres = bin_centres(posterior.azimuth_logits.shape[1], posterior.azimuth_fine_mean)
    return wrap_angle(centres[posterior.azimuth_logits.argmax(1)] + posterior.azimuth_fine_mean)


def shape_divergence(posterior: Posterior) -> Float[Tensor, "B Z"]:
    """KL[Q(z) || Normal(0, 1)] of each dimension, nats."""
    return _normal_divergence(posterior.shape_mean, posterior.shape_deviation, 1.0)


def azimuth_fine_divergence(posterior: Posterior) -> Float[Tensor, "B"]:
    """KL[Q(θ_fine) || Normal(0, π/R)], nats (Eq. 10; π/R is a standard deviation)."""
    prior = math.pi / posterior.azimuth_logits.shape[1]
    return _normal_divergence(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, prior)


def _normal_divergence(mean: Tensor, deviation: Tensor, prior_deviation: float) -> Tensor:
    ratio = deviation / prior_deviation
    return 0.5 * (ratio.square() + (mean / prior_deviation).square() - 1.0) - ratio.log()
