"""Pictures of what a model has learnt: reconstructions, the same shapes from other sides, and samples."""

import math

import numpy as np
import torch
from jaxtyping import Float, Float32
from torch import Tensor

from trainer.config import SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.model.posterior import most_probable_azimuth
from trainer.model.vae import Model
from trainer.rendering import cpu
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade

Picture = Float32[np.ndarray, "H W 3"]

# The canonical sides that are shown beside a reconstruction, degrees.
SIDES_DEGREES = (-45.0, 90.0, 180.0)
COMFORTABLE_WIDTH = 128


def render(
    model: Model, scene: SceneConfig, vertices: Float[Tensor, "N V 3"], azimuth: Float[Tensor, "N"]
) -> Float[Tensor, "N 3 H W"]:
    """Pictures of shapes turned by `azimuth` radians, in the training's own scene."""
    screen = project(vertices, azimuth, scene.camera, scene.width, scene.height)
    colours = shade(vertex_normals(vertices, model.faces), azimuth, scene)
    return cpu.draw(screen, colours, cpu.topology_of(model.faces), scene.width, scene.height)


def reconstruction_rows(
    model: Model, scene: SceneConfig, images: Float[Tensor, "B 3 H W"], azimuth_offset: float = 0.0
) -> tuple[list[str], list[list[Picture]]]:
    """(titles, rows): input, reconstruction from the same view, then the shape from three fixed sides.

    `azimuth_offset` (radians) turns the model's own canonical frame into that of the class: true ≈ predicted + offset.
    """
    posterior = model.encode(images)
    vertices = model.decode(posterior.shape_mean)
    columns = [images, render(model, scene, vertices, most_probable_azimuth(posterior))]
    for side in SIDES_DEGREES:
        azimuth = torch.full((len(images),), math.radians(side) - azimuth_offset)
        columns.append(render(model, scene, vertices, azimuth))
    titles = ["input", "reconstruction", *(f"from {side:+.0f}°" for side in SIDES_DEGREES)]
    return titles, [list(row) for row in zip(*(as_pictures(column) for column in columns), strict=True)]


def sample_rows(
    model: Model, scene: SceneConfig, shape_codes: Float[Tensor, "N Z"], azimuth_offset: float = 0.0
) -> tuple[list[str], list[list[Picture]]]:
    """(titles, rows): each shape from four sides."""
    vertices = model.decode(shape_codes)
    sides = (-45.0, 45.0, 135.0, -135.0)
    columns = [
        as_pictures(render(model, scene, vertices, torch.full((len(vertices),), math.radians(side) - azimuth_offset)))
        for side in sides
    ]
    return [f"from {side:+.0f}°" for side in sides], [list(row) for row in zip(*columns, strict=True)]


def as_pictures(images: Float[Tensor, "N 3 H W"]) -> list[Picture]:
    """Pictures for a sheet; the pixels of small ones are repeated, so that they can be looked at."""
    factor = max(1, round(COMFORTABLE_WIDTH / images.shape[3]))
    enlarged = images.detach().clamp(0, 1).repeat_interleave(factor, 2).repeat_interleave(factor, 3)
    return list(enlarged.permute(0, 2, 3, 1).numpy().astype(np.float32))
