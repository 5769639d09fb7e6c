"""How likely a model finds pictures that it was not trained on: a lower bound of log p(x), comparable between models.

The generative model has z ~ Normal(0, I), coarse bins r and s uniform over R azimuths and L lights, fine angles f and g
about them (Eqs. 9 and 10), and x given all these as in Eqs. 1 to 4 with one ε for all models. Of one picture,

    log p(x) ≥ E_{z, f, g ~ Q} [ log 1/(RL) Σ_{r,s} p(x | z, r + f, s + g) ]
               − KL[Q(z) ‖ P(z)] − KL[Q(f) ‖ P(f)] − KL[Q(g) ‖ P(g)],

by Jensen's inequality over z, f and g alone: the bins are summed out exactly, so the encoder's ρ does not enter, and
nothing is cooled. The likelihood's own constant, log |A/2πε²|/2 with A the pyramid's fixed quadratic form, is the same
for all models and left out. docs/select.md says why ε is what it is.
"""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from trainer.config import LossConfig, SceneConfig
from trainer.model.loss import PAPER_PIXELS
from trainer.model.posterior import azimuth_fine_divergence, light_fine_divergence, shape_divergence
from trainer.model.vae import Model, sample_normal
from trainer.rendering import reference, renderer
from trainer.rendering.cpu import topology_of
from trainer.training.step import CREASES, binarisation
from trainer.training.views import bin_views


class Bound(NamedTuple):
    """The bound of each picture, in its parts; nats."""

    log_likelihood: Float[Tensor, "N"]
    """The expectation over Q of the likelihood with its bins summed out."""
    shape_nats: Float[Tensor, "N"]
    """KL[Q(z) ‖ P(z)]"""
    angle_nats: Float[Tensor, "N"]
    """KL of the fine angles."""

    @property
    def value(self) -> Float[Tensor, "N"]:
        return self.log_likelihood - self.shape_nats - self.angle_nats


def noise_variance(config: LossConfig, width: int, height: int) -> float:
    """ε² under which the training's last objective, with its weight β of the KL terms, is a bound with a weight of 1:
    β, scaled to the number of pixels as in training."""
    return config.kl_weight * width * height / PAPER_PIXELS


def held_out_bound(
    model: Model,
    scene: SceneConfig,
    config: LossConfig,
    images: Float[Tensor, "N 3 H W"],
    samples: int,
    generator: torch.Generator,
) -> Bound:
    """The bound for linear pictures, its expectation taken over `samples` draws of z, f and g.

    The model is left in evaluation mode. Raises FloatingPointError for shapes that are not finite.
    """
    model.eval()
    variance = noise_variance(config, scene.width, scene.height)
    topology = topology_of(model.faces)
    with torch.no_grad():
        posterior = model.encode(images)
        light = posterior.light
        drawn = []
        for _ in range(samples):
            vertices = model.decode(sample_normal(posterior.shape_mean, posterior.shape_deviation, generator))
            azimuth = sample_normal(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, generator)
            turn = None if light is None else sample_normal(light.fine_mean, light.fine_deviation, generator)
            views = bin_views(model, scene, vertices, azimuth, turn)
            bins = renderer.log_likelihood(
                *views, images, topology, CREASES[config.antialias], binarisation(config)
            ).flatten(1)
            drawn.append((bins / variance).logsumexp(1) - math.log(bins.shape[1]))
        angles = azimuth_fine_divergence(posterior)
        if light is not None:
            angles = angles + light_fine_divergence(light)
        return Bound(torch.stack(drawn).mean(0), shape_divergence(posterior).sum(1), angles)


def empty_log_likelihood(config: LossConfig, images: Float[Tensor, "N 3 H W"]) -> Float[Tensor, "N"]:
    """What a model would reach that draws nothing at all, and pays for nothing."""
    variance = noise_variance(config, images.shape[3], images.shape[2])
    black = torch.zeros_like(images[0])
    values = [reference.log_likelihood(black, image, binarisation(config)) for image in images]
    return torch.stack(values) / variance
