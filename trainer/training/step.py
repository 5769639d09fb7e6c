"""One step's forward pass: pictures → posterior → shapes → every coarse bin's likelihood → loss."""

import math
from typing import Any, Literal, NamedTuple, Protocol

import torch
from jaxtyping import Float, Int64
from torch import Tensor, nn

from rasteriser.pictures import HARD
from rasteriser.topology import Topology
from trainer import processes, recording
from trainer.config import LossConfig, SceneConfig
from trainer.geometry.solid import inverted_volume
from trainer.model.encoder import Encoder
from trainer.model.front_back import Sides, unlikeness
from trainer.model.loss import LossTerms, LossWeights, balanced_posterior, nearest_bin, training_loss
from trainer.model.posterior import Posterior, PosteriorHeads, bin_centres, pooled_over_views
from trainer.model.vae import Model, sample_normal
from trainer.rendering import renderer
from trainer.training.moving import moved_onto
from trainer.training.neighbours import Memory, lent_codes
from trainer.training.views import Views, bin_views, views_at

# Every so many shapes of a batch are asked what they turn inside out: that is enough for the decoder they share.
INVERSION_STRIDE = 4
# Jump in the colour's change per pixel from which an edge inside the surface is antialiased; from 0.3 on it shows.
CREASES = {"none": HARD, "contours": math.inf, "borders": 0.3}


class StepResult(NamedTuple):
    terms: LossTerms
    posterior: Posterior
    expected_log_likelihood: Float[Tensor, "B"]
    """Of each picture, over its coarse bins."""
    azimuth: Float[Tensor, "B"]
    """Of each picture the most probable one, radians; without gradient."""

    def loss(self) -> Tensor:
        return self.terms.total()


class FixedGeometry(NamedTuple):
    """What depends on the base mesh alone."""

    topology: Topology
    laplacian: Float[Tensor, "V V"] | None
    """Identity minus the mean over neighbours; None for blocks, which are no displaced surface."""
    solid: tuple[Float[Tensor, "I V"], Int64[Tensor, "T 4"]] | None
    """What fills a displaced cube (`geometry.solid.Solid`); None for other meshes, and where nothing asks for it."""
    sides: Sides | None = None
    """None for blocks, and where nothing asks how unlike front and back are."""


class Step(nn.Module):
    """`forward` as a module, which is what torch's DistributedDataParallel averages the gradients of."""

    def __init__(self, model: Model) -> None:
        super().__init__()
        self.model = model

    def forward(self, *arguments: Any) -> StepResult:
        return forward(self.model, *arguments)


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
    views_per_instance: int = 1,
    memory: Memory | None = None,
) -> StepResult:
    """The loss of one batch; the fine angles are sampled once per picture, z once per object, of which each
    `views_per_instance` consecutive pictures show one.

    The paper's objective weighs the coarse bins by the encoder's ρ (Eq. loss). The exact one finds their posterior
    first (`e_step`). A known azimuth leaves one bin, and of varying light the bins of λ. `memory` is where neighbours
    are looked for, if their shapes are asked to explain pictures, too.
    """
    posterior = pooled_over_views(encode_mixed(model, images, convolutions), views_per_instance)
    shape_code = sample_normal(
        posterior.shape_mean[::views_per_instance], posterior.shape_deviation[::views_per_instance], generator
    ).repeat_interleave(views_per_instance, 0)
    azimuth_fine = sample_normal(posterior.azimuth_fine_mean, posterior.azimuth_fine_deviation, generator)
    light = posterior.light
    light_fine = None if light is None else sample_normal(light.fine_mean, light.fine_deviation, generator)
    known = None if true_azimuth is None else nearest_bin(true_azimuth, model.config.azimuth_bins)
    vertices = model.decode(shape_code)
    check_vertices(vertices)

    def hypotheses(
        vertices: Float[Tensor, "B V 3"],
        azimuth_fine: Float[Tensor, "B"],
        light_fine: Float[Tensor, "B"] | None,
        moved: bool,
    ) -> Views:
        everywhere = bin_views(model, scene, vertices, azimuth_fine, light_fine)
        if moved:
            everywhere = moved_onto(everywhere, images, model.faces)
        return everywhere if known is None else views_at(everywhere, known)

    views = hypotheses(vertices, azimuth_fine, light_fine, weights.moved)
    log_rho = coarse_log_rho(posterior, known)
    crease, eta = CREASES[config.antialias], binarisation(config)
    responsibility = None
    if log_rho[0].numel() == 1:
        responsibility = torch.ones_like(log_rho)
    elif config.objective == "exact":
        with torch.no_grad():
            compared = hypotheses(
                vertices,
                weights.e_step_fine * posterior.azimuth_fine_mean,
                None if light is None else weights.e_step_fine * light.fine_mean,
                moved=config.moved_steps > 0,
            )
            responsibility = e_step(config, weights, compared, log_rho, images, geometry.topology)
    if responsibility is not None:
        expected = renderer.expected_log_likelihood(*views, images, responsibility, geometry.topology, crease, eta)
    else:
        values = renderer.log_likelihood(*views, images, geometry.topology, crease, eta)
        expected = (values * log_rho.exp()).flatten(1).sum(1)
    with torch.no_grad():
        taken_for = log_rho.exp() if responsibility is None else responsibility
        by_azimuth = taken_for.reshape(*taken_for.shape[:2], -1).sum(2) if known is None else known
        centres = bin_centres(model.config.azimuth_bins, azimuth_fine)
        azimuth = centres[by_azimuth.argmax(1)] + posterior.azimuth_fine_mean
    lent = None
    if weights.neighbours and memory is not None and responsibility is not None:
        directions = uniform_azimuths(images, generator)
        codes = lent_codes(memory, posterior.shape_mean, azimuth, directions, model.config.symmetry)
        borrowed = hypotheses(
            model.decode(codes),
            azimuth_fine.detach(),
            None if light_fine is None else light_fine.detach(),
            weights.moved,
        )
        lent = renderer.expected_log_likelihood(*borrowed, images, responsibility, geometry.topology, crease, eta)
    displaced = None
    if geometry.laplacian is not None:
        displaced = geometry.laplacian @ (vertices - model.decoder.base_vertices)
    taught, light_taught = known, None
    if responsibility is not None:
        light_taught = None if light is None else responsibility.sum(1)
        if known is None:
            taught = responsibility if light is None else responsibility.sum(2)
    inverted = inverted_by(model, geometry, shape_code, vertices, config.inversion_margin)
    unlike = None if geometry.sides is None else unlikeness(vertices, geometry.sides, config.front_back_knee)
    terms = training_loss(weights, expected, posterior, displaced, taught, light_taught, lent, inverted, unlike)
    return StepResult(terms, posterior, expected, azimuth)


def uniform_azimuths(images: Float[Tensor, "B 3 H W"], generator: torch.Generator) -> Float[Tensor, "B"]:
    """A direction for each picture, radians."""
    plane = sample_normal(images.new_zeros(len(images), 2), images.new_ones(len(images), 2), generator)
    return torch.atan2(plane[:, 0], plane[:, 1])


def inverted_by(
    model: Model,
    geometry: FixedGeometry,
    shape_code: Float[Tensor, "B Z"],
    vertices: Float[Tensor, "B V 3"],
    margin: float,
) -> Float[Tensor, "N"] | None:
    """`inverted_volume` of one shape in `INVERSION_STRIDE`; None where nothing asks for it."""
    if geometry.solid is None:
        return None
    carrying, tetrahedra = geometry.solid
    surface = vertices[::INVERSION_STRIDE]
    inner = carrying @ surface
    if model.lattice is not None:
        inner = inner + model.inner_offsets(shape_code[::INVERSION_STRIDE])
    return inverted_volume(torch.cat((surface, inner), 1), tetrahedra, margin)


def check_vertices(vertices: Float[Tensor, "B V 3"]) -> None:
    """Raises FloatingPointError, in all processes that train together, where one of them has decoded what cannot be
    drawn."""
    if processes.anywhere(not recording.is_sound(vertices.isfinite().all())):
        raise FloatingPointError("expected finite vertices, found NaN or infinity")


class Encoding(Protocol):
    """What says Q of pictures."""

    encoder: Encoder
    heads: PosteriorHeads


def encode_mixed(model: Encoding, images: Float[Tensor, "B 3 H W"], convolutions: torch.dtype) -> Posterior:
    """`Model.encode` with the convolutions, and only those, in another number format."""
    with torch.autocast(images.device.type, convolutions, enabled=convolutions != torch.float32):
        maps = model.encoder.convolutions(images)
    posterior: Posterior = model.heads(model.encoder.features(maps.to(images.dtype)))
    return posterior


def number_format(precision: Literal["auto", "float32", "bfloat16"], device: torch.device) -> torch.dtype:
    """The format of the convolutions; `auto` asks processor or GPU whether it multiplies bfloat16 matrices."""
    match precision:
        case "float32":
            return torch.float32
        case "bfloat16":
            return torch.bfloat16
        case "auto":
            if device.type == "cuda":
                able = torch.cuda.is_bf16_supported(including_emulation=False)
            else:
                known = torch.cpu.get_capabilities()
                able = bool(known.get("avx512_bf16") or known.get("amx_bf16"))
            return torch.bfloat16 if able else torch.float32


def coarse_log_rho(posterior: Posterior, known: Float[Tensor, "B R"] | None) -> Float[Tensor, "B bins *L"]:
    """The encoder's log ρ of each coarse hypothesis; of a single azimuth where that is known, and with an axis for the
    bins of λ where the light varies."""
    log_rho = posterior.azimuth_logits.log_softmax(1)
    if known is not None:
        log_rho = torch.zeros_like(log_rho[:, :1])
    if posterior.light is None:
        return log_rho
    return log_rho[:, :, None] + posterior.light.logits.log_softmax(1)[:, None]


def e_step(
    config: LossConfig,
    weights: LossWeights,
    compared: Views,
    log_rho: Float[Tensor, "B R *L"],
    images: Float[Tensor, "B 3 H W"],
    topology: Topology,
) -> Float[Tensor, "B R *L"]:
    """The posterior of the coarse bins, whose views are compared at their centres or at the encoder's fine angle.

    Were the fine angle sampled here, a bin and its neighbour could explain a picture alike, and the encoder would never
    learn the fine angle. Bins differ by far more than what antialiasing changes.
    """
    crease = CREASES[config.antialias_e_step]
    log_likelihood = renderer.log_likelihood(*compared, images, topology, crease, binarisation(config))
    evidence = log_likelihood / weights.temperature + weights.encoder_prior * log_rho
    whole = processes.whole(evidence)
    return balanced_posterior(whole, config.sinkhorn_iterations)[processes.share(len(whole))]


def binarisation(config: LossConfig) -> float:
    """The renderer's `binarise`: η of the silhouette loss, or 0 for shading."""
    return config.eta if config.kind == "silhouette" else 0.0
