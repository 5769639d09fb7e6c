"""Pictures of what a model has learnt: reconstructions, the same shapes from other sides, and samples."""

import math

import numpy as np
from jaxtyping import Float, Float32, Int64
from torch import Tensor

from trainer.config import SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.model.posterior import most_probable_azimuth, most_probable_light
from trainer.model.vae import Model
from trainer.rendering import renderer
from trainer.rendering.camera import project
from trainer.rendering.cpu import topology_of
from trainer.rendering.lighting import shade, shade_by_light

Picture = Float32[np.ndarray, "H W 3"]

# The canonical sides that are shown beside a reconstruction, degrees.
SIDES_DEGREES = (-45.0, 90.0, 180.0)
COMFORTABLE_WIDTH = 128


def render(
    faces: Int64[Tensor, "F 3"],
    scene: SceneConfig,
    vertices: Float[Tensor, "N V 3"],
    azimuth: Float[Tensor, "N"],
    light_azimuth: Float[Tensor, "N"] | None = None,
) -> Float[Tensor, "N 3 H W"]:
    """Pictures of shapes turned by `azimuth` radians, in the training's own scene, its lights turned by `light_azimuth`
    radians. Drawn as trainings draw them, with contours antialiased: crumpled shapes interpenetrate so often that all
    borders would take up to a hundred times as long."""
    screen = project(vertices, azimuth, scene.camera, scene.width, scene.height)
    normals = vertex_normals(vertices, faces)
    if light_azimuth is None:
        colours = shade(normals, azimuth, scene)
    else:
        colours = shade_by_light(normals, azimuth, light_azimuth[:, None], scene).squeeze(2)
    pictures = renderer.draw(screen, colours, topology_of(faces), scene.width, scene.height, crease=math.inf)
    return pictures[:, :-1]


def reconstruction_rows(
    model: Model, scene: SceneConfig, images: Float[Tensor, "B 3 H W"]
) -> tuple[list[str], list[list[Picture]]]:
    """(titles, rows) of what a model makes of pictures, its canonical frame as it is."""
    posterior = model.encode(images)
    vertices, azimuth = model.decode(posterior.shape_mean), most_probable_azimuth(posterior)
    reconstructions = render(model.faces, scene, vertices, azimuth, most_probable_light(posterior))
    return comparison_rows(model.faces, scene, images, reconstructions, vertices)


def comparison_rows(
    faces: Int64[Tensor, "F 3"],
    scene: SceneConfig,
    images: Float[Tensor, "N 3 H W"],
    reconstructions: Float[Tensor, "N 3 H W"],
    vertices: Float[Tensor, "N V 3"],
    azimuth_offset: float = 0.0,
) -> tuple[list[str], list[list[Picture]]]:
    """(titles, rows): input, reconstruction from the same view, then the shape from three fixed sides.

    `azimuth_offset` (radians) turns the model's own canonical frame into that of the class: true ≈ predicted + offset.
    """
    columns = [images, reconstructions]
    for side in SIDES_DEGREES:
        azimuth = vertices.new_full((len(images),), math.radians(side) - azimuth_offset)
        columns.append(render(faces, scene, vertices, azimuth))
    titles = ["input", "reconstruction", *(f"from {side:+.0f}°" for side in SIDES_DEGREES)]
    return titles, [list(row) for row in zip(*(as_pictures(column) for column in columns), strict=True)]


def sample_rows(
    model: Model, scene: SceneConfig, shape_codes: Float[Tensor, "N Z"]
) -> tuple[list[str], list[list[Picture]]]:
    """(titles, rows): each shape from four sides."""
    vertices = model.decode(shape_codes)
    sides = (-45.0, 45.0, 135.0, -135.0)
    columns = [
        as_pictures(render(model.faces, scene, vertices, vertices.new_full((len(vertices),), math.radians(side))))
        for side in sides
    ]
    return [f"from {side:+.0f}°" for side in sides], [list(row) for row in zip(*columns, strict=True)]


def as_pictures(images: Float[Tensor, "N 3 H W"]) -> list[Picture]:
    """Pictures for a sheet; the pixels of small ones are repeated, so that they can be looked at."""
    factor = max(1, round(COMFORTABLE_WIDTH / images.shape[3]))
    enlarged = images.detach().clamp(0, 1).repeat_interleave(factor, 2).repeat_interleave(factor, 3)
    return list(enlarged.permute(0, 2, 3, 1).cpu().numpy().astype(np.float32))
