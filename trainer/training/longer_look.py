"""A longer look at pictures: from what an encoder says at a glance to what explains them best.

What is minimised, of each picture by itself, is the negative log posterior that the training ends with,

    E(z, θ, λ) = ½ Σ_l 4^l ‖K_l (I(z, θ, λ) − x)‖²  +  ½ β ‖z‖²,

in units where ε = 1. The descent is Adam's over z and the fine angles; coarse ones stay the encoder's. What
`imaging.refinement` does for one answer, without a renderer's gradient, this does for a folder.
"""

import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from trainer.config import SceneConfig, TrainConfig
from trainer.geometry.normals import vertex_normals
from trainer.model.loss import PAPER_PIXELS
from trainer.model.posterior import Posterior, bin_centres, half_light_bin, light_bin_centres
from trainer.model.vae import Model
from trainer.rendering import renderer
from trainer.rendering.camera import project
from trainer.rendering.cpu import topology_of
from trainer.rendering.lighting import shade, shade_by_light
from trainer.training.step import CREASES, binarisation

STEPS: Final = 20
MOST_STEPS: Final = 1000
_RATE: Final = 0.1
"""Learning rate of the first step, which falls to 0 as half a cosine: of z, and of fine angles in `_ANGLE`."""
_ANGLE: Final = 0.2
"""Radians for an unknown of 1, so that one rate does for all."""
_BETAS: Final = (0.8, 0.95)
"""Adam's, for so few steps."""


class Look(NamedTuple):
    """What explains N pictures best; angles in radians."""

    shape_code: Float[Tensor, "N Z"]
    azimuth_fine: Float[Tensor, "N"]
    """Beside the centre of the encoder's most probable bin, within that bin."""
    light_fine: Float[Tensor, "N"] | None
    """The same of λ; None where the light is fixed."""

    def each(self, change: Callable[[Tensor], Tensor]) -> "Look":
        """All parts, changed in the same way."""
        light = None if self.light_fine is None else change(self.light_fine)
        return Look(change(self.shape_code), change(self.azimuth_fine), light)


def look_longer(
    model: Model, scene: SceneConfig, config: TrainConfig, pictures: Float[Tensor, "N 3 H W"], steps: int = STEPS
) -> Look:
    """What so many steps downhill from the encoder's word find in linear pictures; where E is no less then, that word.

    Raises FloatingPointError where the model decodes what cannot be drawn.
    """
    with torch.no_grad():
        posterior = model.encode(pictures)
    first = Look(
        posterior.shape_mean,
        posterior.azimuth_fine_mean,
        None if posterior.light is None else posterior.light.fine_mean,
    )
    energy = energy_of(model, scene, config, pictures, posterior)
    half_bin = math.pi / model.config.azimuth_bins, half_light_bin(model.config.light_bins)
    code = first.shape_code.clone().requires_grad_()
    angles = pictures.new_zeros(2, len(pictures)).requires_grad_()

    def look() -> Look:
        azimuth = (first.azimuth_fine + _ANGLE * angles[0]).clamp(-half_bin[0], half_bin[0])
        light = None
        if first.light_fine is not None:
            light = (first.light_fine + _ANGLE * angles[1]).clamp(-half_bin[1], half_bin[1])
        return Look(code, azimuth, light)

    optimiser = torch.optim.Adam([code, angles], lr=_RATE, betas=_BETAS)
    for step in range(steps):
        optimiser.param_groups[0]["lr"] = 0.5 * _RATE * (1 + math.cos(math.pi * step / steps))
        code.grad, angles.grad = torch.autograd.grad(energy(look()).sum(), (code, angles))
        optimiser.step()
    with torch.no_grad():
        # Pictures by which nothing is gained stay where they began: unknowns of 0 are the encoder's word.
        better = energy(look()) < energy(first)
        code.copy_(torch.where(better[:, None], code, first.shape_code))
        angles.mul_(better)
        return look().each(Tensor.clone)


def joined(looks: Sequence[Look]) -> Look:
    """Of all pictures in a row, on the CPU."""
    lights = [look.light_fine for look in looks if look.light_fine is not None]
    codes, azimuths = (torch.cat(parts) for parts in zip(*(look[:2] for look in looks), strict=True))
    return Look(codes, azimuths, torch.cat(lights) if lights else None).each(Tensor.cpu)


def energy_of(
    model: Model, scene: SceneConfig, config: TrainConfig, pictures: Float[Tensor, "N 3 H W"], posterior: Posterior
) -> Callable[[Look], Float[Tensor, "N"]]:
    """E of each picture, at the coarse angles that the encoder finds most probable."""
    loss = config.loss
    prior = loss.kl_weight * scene.width * scene.height / PAPER_PIXELS
    topology, crease, eta = topology_of(model.faces), CREASES[loss.antialias], binarisation(loss)
    turned = bin_centres(model.config.azimuth_bins, pictures)[posterior.azimuth_logits.argmax(1)]
    # One hypothesis of each picture, under one of its light.
    lit, sure = None, pictures.new_ones(len(pictures), 1)
    if posterior.light is not None:
        sure = sure[:, None]
        lit = light_bin_centres(model.config.light_bins, pictures)[posterior.light.logits.argmax(1)]

    def energy(look: Look) -> Float[Tensor, "N"]:
        vertices = model.decode(look.shape_code)
        azimuth, normals = turned + look.azimuth_fine, vertex_normals(vertices, model.faces)
        screen = project(vertices, azimuth, scene.camera, scene.width, scene.height)
        if lit is None or look.light_fine is None:
            colours = shade(normals, azimuth, scene)
        else:
            colours = shade_by_light(normals, azimuth, (lit + look.light_fine)[:, None], scene)
        explained = renderer.expected_log_likelihood(
            screen[:, None], colours[:, None], pictures, sure, topology, crease, eta
        )
        return 0.5 * prior * look.shape_code.square().sum(1) - explained

    return energy
