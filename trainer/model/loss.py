"""The training objective, one function a term (Eq. loss of the paper, and the exact E-step that replaces part of it).

All log-likelihoods are sums over pixels with ε = 1. `pixel_share` = pixels / (128 · 96) makes every other weight mean
the same at every resolution. Values are means over the batch, in nats.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from trainer.model.posterior import Posterior, azimuth_fine_divergence, bin_centres, shape_divergence

PAPER_PIXELS = 128 * 96


class LossWeights(NamedTuple):
    """The weights at one step, cooled by `training.schedule` and scaled to the resolution."""

    kl: float
    prior_matching: float
    temperature: float
    encoder_prior: float
    distillation: float
    laplacian: float


class LossTerms(NamedTuple):
    """The weighted terms, whose sum is minimised; each a scalar."""

    reconstruction: Tensor
    kl: Tensor
    prior_matching: Tensor
    distillation: Tensor
    laplacian: Tensor

    def total(self) -> Tensor:
        return self.reconstruction + self.kl + self.prior_matching + self.distillation + self.laplacian


def training_loss(
    weights: LossWeights,
    expected_log_likelihood: Float[Tensor, "B"],
    posterior: Posterior,
    displacement_laplacian: Float[Tensor, "B V 3"],
    responsibility: Float[Tensor, "B R"] | None,
) -> LossTerms:
    """All terms for one batch. `responsibility` is what the coarse bins were weighed by and what the encoder's ρ is
    taught: the E-step's posterior, or the truth under pose supervision. None where ρ itself weighed them, as in the
    paper; then ρ is matched to its prior instead."""
    zero = expected_log_likelihood.new_zeros(())
    matching, teaching = zero, zero
    if responsibility is not None:
        teaching = weights.distillation * distillation(posterior.azimuth_logits, responsibility)
    else:
        matching = weights.prior_matching * prior_matching(posterior.azimuth_logits.softmax(1))
    divergence = shape_divergence(posterior).sum(1) + azimuth_fine_divergence(posterior)
    return LossTerms(
        reconstruction=-expected_log_likelihood.mean(),
        kl=weights.kl * divergence.mean(),
        prior_matching=matching,
        distillation=teaching,
        laplacian=weights.laplacian * displacement_laplacian.square().sum((1, 2)).mean(),
    )


def prior_matching(rho: Float[Tensor, "B R"]) -> Float[Tensor, ""]:
    """Σ_r |⟨ρ_r⟩ - 1/R|, Eq. 13: the batch's mean posterior against the uniform prior."""
    return (rho.mean(0) - 1.0 / rho.shape[1]).abs().sum()


def balanced_posterior(evidence: Float[Tensor, "B R"], iterations: int) -> Float[Tensor, "B R"]:
    """The exact E-step: softmax of the bins' evidence (log p / T + log prior), balanced over the batch.

    A few Sinkhorn rounds: each divides every column by its mean and makes every row sum to 1 again. The batch then uses
    all bins alike: the aggregate posterior matches the uniform prior by construction, as Eq. 13 asks of ρ.
    """
    log_q = evidence.log_softmax(1)
    for _ in range(iterations):
        log_q = (log_q - log_q.logsumexp(0, keepdim=True)).log_softmax(1)
    return log_q.exp()


def distillation(logits: Float[Tensor, "B R"], responsibility: Float[Tensor, "B R"]) -> Float[Tensor, ""]:
    """Cross-entropy that teaches the encoder's ρ the E-step's posterior, in nats."""
    return functional.cross_entropy(logits, responsibility)


def nearest_bin(azimuth: Float[Tensor, "B"], bins: int) -> Float[Tensor, "B R"]:
    """One-hot: the coarse bin whose centre is nearest to the azimuth (radians)."""
    nearest = torch.cos(azimuth[:, None] - bin_centres(bins, azimuth)).argmax(1)
    return functional.one_hot(nearest, bins).to(azimuth.dtype)
