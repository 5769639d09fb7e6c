"""The training objective, one function a term (Eq. loss of the paper, and the exact E-step that replaces part of it).

All log-likelihoods are sums over pixels with ε = 1. `pixel_share` = pixels / (128 · 96) makes every other weight mean
the same at every resolution. Values are means over the batch, in nats.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from trainer import processes
from trainer.model.posterior import (
    Posterior,
    azimuth_fine_divergence,
    bin_centres,
    light_fine_divergence,
    shape_divergence,
)

PAPER_PIXELS = 128 * 96


class LossWeights(NamedTuple):
    """The weights at one step, cooled by `training.schedule` and scaled to the resolution."""

    kl: float
    prior_matching: float
    temperature: float
    encoder_prior: float
    distillation: float
    laplacian: float
    independence: float = 0.0
    moved: bool = False
    """Whether views are moved onto the pictures before the shape learns from them (`training.moving`)."""
    e_step_fine: bool = False
    """Whether the E-step compares poses at the encoder's fine angles, not at the centres of their bins."""
    neighbours: float = 0.0
    """Of what neighbours' shapes explain (`training.neighbours`)."""
    inversion: float = 0.0
    front_back: float = 0.0


class LossTerms(NamedTuple):
    """The weighted terms, whose sum is minimised; each a scalar."""

    reconstruction: Tensor
    kl: Tensor
    prior_matching: Tensor
    distillation: Tensor
    laplacian: Tensor
    independence: Tensor
    neighbours: Tensor
    inversion: Tensor
    front_back: Tensor

    def total(self) -> Tensor:
        return torch.stack(self).sum()


def training_loss(
    weights: LossWeights,
    expected_log_likelihood: Float[Tensor, "B"],
    posterior: Posterior,
    displacement_laplacian: Float[Tensor, "B V 3"] | None,
    responsibility: Float[Tensor, "B R"] | None,
    light_responsibility: Float[Tensor, "B L"] | None = None,
    lent_log_likelihood: Float[Tensor, "B"] | None = None,
    inverted_volume: Float[Tensor, "N"] | None = None,
    unlike_sides: Float[Tensor, "B"] | None = None,
) -> LossTerms:
    """All terms for one batch. `responsibility` is what the coarse bins were weighed by and what the encoder's ρ is
    taught: the E-step's posterior, or the truth under pose supervision. None where ρ itself weighed them, as in the
    paper; then ρ is matched to its prior instead, and nothing asks the code to be independent of the pose. The same
    goes for the light's, where it varies. What has no displacements (None) has no Laplacian term.
    `lent_log_likelihood` is the expected one under neighbours' shapes, where these are asked, and `inverted_volume`
    what N of the shapes turn inside out, and `unlike_sides` how unlike their front and back are, where these weigh."""
    zero = expected_log_likelihood.new_zeros(())
    matching, teaching, laplacian, independence, neighbours, inversion, sides = [zero] * 7
    angles = [(posterior.azimuth_logits, responsibility)]
    divergence = shape_divergence(posterior).sum(1) + azimuth_fine_divergence(posterior)
    if posterior.light is not None:
        angles.append((posterior.light.logits, light_responsibility))
        divergence = divergence + light_fine_divergence(posterior.light)
    for logits, taught in angles:
        if taught is not None:
            teaching = teaching + weights.distillation * distillation(logits, taught)
        else:
            matching = matching + weights.prior_matching * prior_matching(logits.softmax(1))
    if responsibility is not None and weights.independence:
        independence = weights.independence * pose_in_code(posterior.shape_mean, responsibility)
    if displacement_laplacian is not None:
        laplacian = weights.laplacian * displacement_laplacian.square().sum((1, 2)).mean()
    if lent_log_likelihood is not None:
        neighbours = -weights.neighbours * lent_log_likelihood.mean()
    if inverted_volume is not None:
        inversion = weights.inversion * inverted_volume.mean()
    if unlike_sides is not None:
        sides = weights.front_back * unlike_sides.mean()
    return LossTerms(
        reconstruction=-expected_log_likelihood.mean(),
        kl=weights.kl * divergence.mean(),
        prior_matching=matching,
        distillation=teaching,
        laplacian=laplacian,
        independence=independence,
        neighbours=neighbours,
        inversion=inversion,
        front_back=sides,
    )


def prior_matching(rho: Float[Tensor, "B R"]) -> Float[Tensor, ""]:
    """Σ_r |⟨ρ_r⟩ - 1/R|, Eq. 13: the batch's mean posterior against the uniform prior."""
    return (processes.mean(rho.mean(0)) - 1.0 / rho.shape[1]).abs().sum()


def pose_in_code(shape_mean: Float[Tensor, "B Z"], responsibility: Float[Tensor, "B R"]) -> Float[Tensor, ""]:
    """How much codes tell of coarse azimuths: the squared covariances of each dimension of z with cos kθ and sin kθ,
    k = 1 (front or back) and 2 (end or side), summed. The prior has none: P(z, θ) = P(z) P(θ).

    Estimated from the pairs of different pictures of a batch, so that codes are not drawn to 0 by what is chance, and
    at least 0: batch normalisation sees the whole batch, and would lower an estimate below that without end. 0 for a
    single picture.
    """
    size = processes.count() * len(shape_mean)
    if size < 2:
        return shape_mean.new_zeros(())
    angles = torch.stack([k * bin_centres(responsibility.shape[1], shape_mean) for k in (1, 2)], 1)
    pose = responsibility @ torch.cat([angles.cos(), angles.sin()], 1)
    covariances = processes.mean(shape_mean.T @ pose / len(shape_mean))
    # Of each picture with itself.
    own = processes.mean((shape_mean.square().sum(1) * pose.square().sum(1)).mean())
    return ((size * covariances.square().sum() - own) / (size - 1)).clamp_min(0)


def balanced_posterior(evidence: Float[Tensor, "B *bins"], iterations: int) -> Float[Tensor, "B *bins"]:
    """The exact E-step: softmax of the bins' evidence (log p / T + log prior), balanced over the batch.

    A few Sinkhorn rounds: each divides every column by its mean and makes every row sum to 1 again. The batch then uses
    all bins alike: the aggregate posterior matches the uniform prior by construction, as Eq. 13 asks of ρ. Where bins
    are pairs (θ, λ), each round does so for the bins of the one angle and then for those of the other.
    """
    log_q = _normalised(evidence)
    axes = range(1, evidence.ndim)
    for _ in range(iterations):
        for balanced in axes:
            others = [axis for axis in range(evidence.ndim) if axis != balanced]
            log_q = _normalised(log_q - log_q.logsumexp(others, keepdim=True))
    return log_q.exp()


def _normalised(log_q: Float[Tensor, "B *bins"]) -> Float[Tensor, "B *bins"]:
    return log_q.flatten(1).log_softmax(1).reshape(log_q.shape)


def distillation(logits: Float[Tensor, "B R"], responsibility: Float[Tensor, "B R"]) -> Float[Tensor, ""]:
    """Cross-entropy that teaches the encoder's ρ the E-step's posterior, in nats."""
    return functional.cross_entropy(logits, responsibility)


def nearest_bin(azimuth: Float[Tensor, "B"], bins: int) -> Float[Tensor, "B R"]:
    """One-hot: the coarse bin whose centre is nearest to the azimuth (radians)."""
    nearest = torch.cos(azimuth[:, None] - bin_centres(bins, azimuth)).argmax(1)
    return functional.one_hot(nearest, bins).to(azimuth.dtype)
