"""Every coarse hypothesis of a batch of shapes, ready to be drawn: I₀ of Eq. 3 up to the rasteriser."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from trainer.config import SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.model.posterior import bin_centres, light_bin_centres
from trainer.model.vae import Model
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade, shade_by_light


class Views(NamedTuple):
    """A batch of shapes at coarse azimuth bins, each under every coarse bin of the light where that varies."""

    screen: Float[Tensor, "B R V 3"]
    colours: Float[Tensor, "B R V *L 3"]


def bin_views(
    model: Model,
    scene: SceneConfig,
    vertices: Float[Tensor, "B V 3"],
    azimuth_fine: Float[Tensor, "B"],
    light_fine: Float[Tensor, "B"] | None,
) -> Views:
    """Vertices and colours at θ_coarse = r, θ_fine for every coarse bin r; and at λ_coarse, λ_fine for those of λ,
    unless `light_fine` is None: then the light is the scene's."""
    bins = model.config.azimuth_bins
    azimuth = bin_centres(bins, azimuth_fine) + azimuth_fine[:, None]
    normals = vertex_normals(vertices, model.faces)
    everywhere = (-1, bins, -1, -1)
    screen = project(vertices[:, None].expand(everywhere), azimuth, scene.camera, scene.width, scene.height)
    facing = normals[:, None].expand(everywhere)
    if light_fine is None:
        return Views(screen, shade(facing, azimuth, scene))
    light = light_bin_centres(model.config.light_bins, light_fine) + light_fine[:, None]
    return Views(screen, shade_by_light(facing, azimuth, light[:, None].expand(-1, bins, -1), scene))


def views_at(views: Views, bins: Float[Tensor, "B R"]) -> Views:
    """Of each shape the one view whose bin is marked (R = 1)."""
    chosen = bins.argmax(1, keepdim=True)
    return Views(*(torch.take_along_dim(part, chosen.reshape(-1, 1, *(1,) * (part.ndim - 2)), 1) for part in views))
