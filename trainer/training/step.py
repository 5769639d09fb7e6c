"""One step's forward pass: pictures → posterior → shapes → every coarse bin's likelihood → loss."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from rasteriser.topology import Topology
from trainer.config import LossConfig, SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.model.loss import LossTerms, LossWeights, training_loss
from trainer.model.posterior import Posterior, bin_centres
from trainer.model.vae import Model, sample_normal
from trainer.rendering import cpu
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade


class StepResult(NamedTuple):
    terms: LossTerms
    posterior: Posterior
    log_likelihood: Float[Tensor, "B R"]


class FixedGeometry(NamedTuple):
    """What depends on the base mesh alone."""

    topology: Topology
    laplacian: Float[Tensor, "V V"]
    """Identity minus the mean over neighbours."""


def forward(
    model: Model,
    geometry: FixedGeometry,
    scene: SceneConfig,
    config: LossConfig,
    weights: LossWeights,
    images: Float[Tensor, "B 3 H W"],
    true_azimuth: Float[Tensor, "B"] | None,
    generator: torch.Generator,
    convolutions: torch.dtype = torch.float32,
) -> StepResult:
    """Eq. loss for one batch. All coarse azimuth bins are summed over; z and θ_fine are sampled once per picture."""
    posterior = encode_mixed(model, images, convolutions)
    shape_code = sample_normal(posterior.shape_mean, posterior.shape_deviation, generator)
    azimuth_fine = sample_normal(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, generator)
    vertices = model.decode(shape_code)
    log_likelihood = bin_log_likelihoods(model, geometry.topology, scene, images, vertices, azimuth_fine)
    displaced = geometry.laplacian @ (vertices - model.decoder.base_vertices)
    terms = training_loss(config, weights, log_likelihood, posterior, displaced, true_azimuth)
    return StepResult(terms, posterior, log_likelihood)


def encode_mixed(model: Model, images: Float[Tensor, "B 3 H W"], convolutions: torch.dtype) -> Posterior:
    """`Model.encode` with the convolutions, and only those, in another number format."""
    with torch.autocast(images.device.type, convolutions, enabled=convolutions != torch.float32):
        maps = model.encoder.convolutions(images)
    posterior: Posterior = model.heads(model.encoder.features(maps.float()))
    return posterior


def bin_log_likelihoods(
    model: Model,
    topology: Topology,
    scene: SceneConfig,
    images: Float[Tensor, "B 3 H W"],
    vertices: Float[Tensor, "B V 3"],
    azimuth_fine: Float[Tensor, "B"],
) -> Float[Tensor, "B R"]:
    """log P(x | z, θ_coarse = r, θ_fine) for every coarse bin r."""
    bins = model.config.azimuth_bins
    azimuth = bin_centres(bins, azimuth_fine) + azimuth_fine[:, None]
    normals = vertex_normals(vertices, model.faces)
    everywhere = (-1, bins, -1, -1)
    screen = project(vertices[:, None].expand(everywhere), azimuth, scene.camera, scene.width, scene.height)
    colours = shade(normals[:, None].expand(everywhere), azimuth, scene)
    return cpu.log_likelihood(screen, colours, images, topology)
