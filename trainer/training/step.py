"""One step's forward pass: pictures → posterior → shapes → every coarse bin's likelihood → loss."""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from rasteriser.topology import Topology
from trainer.config import LossConfig, SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.model.loss import LossTerms, LossWeights, balanced_posterior, nearest_bin, training_loss
from trainer.model.posterior import Posterior, bin_centres
from trainer.model.vae import Model, sample_normal
from trainer.rendering import renderer
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade

# Jump in the colour's change per pixel from which an edge inside the surface is antialiased; from 0.3 on it shows.
CREASES = {"contours": math.inf, "borders": 0.3}


class StepResult(NamedTuple):
    terms: LossTerms
    posterior: Posterior
    expected_log_likelihood: Float[Tensor, "B"]
    """Of each picture, over its coarse azimuth bins."""


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
    """The loss of one batch; z and θ_fine are sampled once per picture.

    The paper's objective weighs the coarse bins by the encoder's ρ (Eq. loss). The exact one finds their posterior
    first, at the bins' centres: were the fine angle free there, a bin and its neighbour could explain a picture alike,
    and the encoder would never learn the fine angle. Which bin it is shows in contours alone.
    """
    posterior = encode_mixed(model, images, convolutions)
    shape_code = sample_normal(posterior.shape_mean, posterior.shape_deviation, generator)
    azimuth_fine = sample_normal(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, generator)
    vertices = model.decode(shape_code)
    views = bin_views(model, scene, vertices, azimuth_fine)
    responsibility = None
    if true_azimuth is not None:
        responsibility = nearest_bin(true_azimuth, model.config.azimuth_bins)
    elif config.objective == "exact":
        with torch.no_grad():
            centred = bin_views(model, scene, vertices, torch.zeros_like(azimuth_fine))
            log_likelihood = renderer.log_likelihood(*centred, images, geometry.topology, crease=math.inf)
        log_prior = weights.encoder_prior * posterior.azimuth_logits.detach().log_softmax(1)
        evidence = log_likelihood / weights.temperature + log_prior
        responsibility = balanced_posterior(evidence, config.sinkhorn_iterations)
    if responsibility is not None:
        expected = renderer.expected_log_likelihood(
            *views, images, responsibility, geometry.topology, crease=CREASES[config.antialias]
        )
    else:
        rho = posterior.azimuth_logits.softmax(1)
        values = renderer.log_likelihood(*views, images, geometry.topology, crease=CREASES[config.antialias])
        expected = (values * rho).sum(1)
    displaced = geometry.laplacian @ (vertices - model.decoder.base_vertices)
    terms = training_loss(weights, expected, posterior, displaced, responsibility)
    return StepResult(terms, posterior, expected)


def encode_mixed(model: Model, images: Float[Tensor, "B 3 H W"], convolutions: torch.dtype) -> Posterior:
    """`Model.encode` with the convolutions, and only those, in another number format."""
    with torch.autocast(images.device.type, convolutions, enabled=convolutions != torch.float32):
        maps = model.encoder.convolutions(images)
    posterior: Posterior = model.heads(model.encoder.features(maps.float()))
    return posterior


class Views(NamedTuple):
    """A batch of shapes at every coarse azimuth bin."""

    screen: Float[Tensor, "B R V 3"]
    colours: Float[Tensor, "B R V 3"]


def bin_views(
    model: Model, scene: SceneConfig, vertices: Float[Tensor, "B V 3"], azimuth_fine: Float[Tensor, "B"]
) -> Views:
    """Vertices and colours at θ_coarse = r, θ_fine for every coarse bin r: I₀ of Eq. 3 up to the rasteriser."""
    bins = model.config.azimuth_bins
    azimuth = bin_centres(bins, azimuth_fine) + azimuth_fine[:, None]
    normals = vertex_normals(vertices, model.faces)
    everywhere = (-1, bins, -1, -1)
    screen = project(vertices[:, None].expand(everywhere), azimuth, scene.camera, scene.width, scene.height)
    return Views(screen, shade(normals[:, None].expand(everywhere), azimuth, scene))
