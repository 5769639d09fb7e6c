"""The two graphs of a bundle: all of the model's mathematics, in the frame that the service shows.

Training without labels defines the object's frame only up to a rotation about +Y: the true azimuth is the predicted one
plus an offset δ that the judge measures. Here that offset becomes part of the model. Azimuths grow by δ, and the object
turns by −δ, so that its front is +Z and every rendering stays as it was: R(θ + δ) · R(−δ) v = R(θ) v.
"""

import math

import torch
from jaxtyping import Float
from torch import Tensor, nn

from trainer.geometry.conventions import rotation_about_y, wrap_angle
from trainer.geometry.normals import vertex_normals
from trainer.model.posterior import bin_centres, most_probable_azimuth
from trainer.model.vae import Model


class EncoderGraph(nn.Module):
    """Pictures → posterior, and the most probable azimuth; angles in radians."""

    def __init__(self, model: Model, azimuth_offset: float) -> None:
        super().__init__()
        self.model = model
        self.azimuth_offset = azimuth_offset

    def forward(self, images: Float[Tensor, "B 3 H W"]) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]:
        """Shape mean and deviation [B, Z], bin probabilities [B, R], fine mean, fine deviation and azimuth [B].

        Bin r stands for the azimuth `exported_bin_centres[r]`; the azimuth is the most probable bin's centre plus the
        fine mean, in [-π, π).
        """
        posterior = self.model.encode(images)
        return (
            posterior.shape_mean,
            posterior.shape_deviation,
            posterior.azimuth_logits.softmax(1),
            posterior.azimuth_fine_mean,
            posterior.azimuth_fine_deviation,
            wrap_angle(most_probable_azimuth(posterior) + self.azimuth_offset),
        )


class DecoderGraph(nn.Module):
    """Shape codes → mesh in the object frame, front +Z."""

    rotation: Tensor
    faces: Tensor
    up: Tensor

    def __init__(self, model: Model, azimuth_offset: float) -> None:
        super().__init__()
        self.model = model
        rotation = rotation_about_y(torch.tensor(-azimuth_offset, dtype=torch.float64)).float()
        self.register_buffer("rotation", rotation)
        self.register_buffer("faces", model.faces)
        self.register_buffer("up", torch.tensor([0.0, 1.0, 0.0]))

    def forward(self, shape_codes: Float[Tensor, "B Z"]) -> tuple[Tensor, Tensor]:
        """Vertices [B, V, 3] and unit normals [B, V, 3]; where the surface has no area, the normal is +Y."""
        vertices = self.model.decode(shape_codes) @ self.rotation.T
        normals = vertex_normals(vertices, self.faces)
        length = normals.square().sum(-1, keepdim=True).sqrt()
        return vertices, torch.where(length > 0.5, normals / length, self.up)


def exported_bin_centres(bins: int, azimuth_offset: float) -> list[float]:
    """The azimuths of the coarse bins with the offset, degrees in [-180, 180)."""
    centres = bin_centres(bins, torch.zeros((), dtype=torch.float64)) + azimuth_offset
    # Ten digits: −180 then stays −180 where rounding would have made it 180 − 1e-14.
    degrees = [round(math.degrees(centre), 10) for centre in centres.tolist()]
    return [(centre + 180.0) % 360.0 - 180.0 for centre in degrees]
