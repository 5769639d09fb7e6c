"""The two graphs of a bundle: all of the model's mathematics, in the frame that the service shows.

Training without labels defines the object's frame only up to a rotation about +Y: the true azimuth is the predicted one
plus an offset δ that the judge measures. Here that offset becomes part of the model. Azimuths grow by δ, and the object
turns by −δ, so that its front is +Z and every rendering stays as it was: R(θ + δ) · R(−δ) v = R(θ) v. So does the
temperature, with which the judge's bins are as probable as they are right.
"""

import math

import torch
from jaxtyping import Float
from torch import Tensor, nn

from trainer.geometry.conventions import rotation_about_y, wrap_angle
from trainer.model.posterior import bin_centres, light_bin_centres, most_probable_azimuth, most_probable_light
from trainer.model.vae import Model


class EncoderGraph(nn.Module):
    """Pictures → posterior, and the most probable azimuth; angles in radians."""

    def __init__(self, model: Model, azimuth_offset: float, azimuth_temperature: float = 1.0) -> None:
        super().__init__()
        self.model = model
        self.azimuth_offset, self.azimuth_temperature = azimuth_offset, azimuth_temperature

    def forward(self, images: Float[Tensor, "B 3 H W"]) -> tuple[Tensor, ...]:
        """Shape mean and deviation [B, Z], bin probabilities [B, R], fine mean, fine deviation and azimuth [B].

        Bin r stands for the azimuth `exported_bin_centres[r]`; the azimuth is the most probable bin's centre plus the
        fine mean, in [-π, π). Where the light varies, its bin probabilities [B, L], fine mean, fine deviation and
        azimuth [B] follow. They need no offset: lights stand with the camera, whatever the object's frame is.
        """
        posterior = self.model.encode(images)
        lights: tuple[Tensor, ...] = ()
        light_azimuth = most_probable_light(posterior)
        if posterior.light is not None and light_azimuth is not None:
            logits, fine_mean, fine_deviation = posterior.light
            lights = (logits.softmax(1), fine_mean, fine_deviation, light_azimuth)
        return (
            posterior.shape_mean,
            posterior.shape_deviation,
            (posterior.azimuth_logits / self.azimuth_temperature).softmax(1),
            posterior.azimuth_fine_mean,
            posterior.azimuth_fine_deviation,
            wrap_angle(most_probable_azimuth(posterior) + self.azimuth_offset),
            *lights,
        )


class DecoderGraph(nn.Module):
    """Shape codes → mesh in the object frame, front +Z."""

    rotation: Tensor
    up: Tensor

    def __init__(self, model: Model, azimuth_offset: float) -> None:
        super().__init__()
        self.model = model
        rotation = rotation_about_y(torch.tensor(-azimuth_offset, dtype=torch.float64)).float()
        self.register_buffer("rotation", rotation)
        self.register_buffer("up", torch.tensor([0.0, 1.0, 0.0]))

    def forward(self, shape_codes: Float[Tensor, "B Z"]) -> tuple[Tensor, Tensor]:
        """Vertices [B, V, 3] and unit normals [B, V, 3]; where the surface has no area, the normal is +Y."""
        vertices = self.model.decode(shape_codes) @ self.rotation.T
        normals = self.model.decoder.normals(shape_codes) @ self.rotation.T
        length = normals.square().sum(-1, keepdim=True).sqrt()
        return vertices, torch.where(length > 0.5, normals / length, self.up)


def exported_bin_centres(bins: int, azimuth_offset: float) -> list[float]:
    """The azimuths of the coarse bins with the offset, degrees in [-180, 180)."""
    centres = bin_centres(bins, torch.zeros((), dtype=torch.float64)) + azimuth_offset
    # Ten digits: −180 then stays −180 where rounding would have made it 180 − 1e-14.
    degrees = [round(math.degrees(centre), 10) for centre in centres.tolist()]
    return [(centre + 180.0) % 360.0 - 180.0 for centre in degrees]


def exported_light_bin_centres(bins: int) -> list[float]:
    """The coarse bins of the lights' turn, degrees in (0, 180)."""
    centres = light_bin_centres(bins, torch.zeros((), dtype=torch.float64))
    return [round(math.degrees(centre), 10) for centre in centres.tolist()]
