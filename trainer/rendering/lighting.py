"""Lambert's law at the vertices: the colours that Gouraud shading interpolates."""

import math

from jaxtyping import Float
from torch import Tensor

from trainer.config import SceneConfig
from trainer.geometry.conventions import rotation_about_y
from trainer.rendering.constants import constant


def light_directions(scene: SceneConfig, like: Tensor) -> Float[Tensor, "K 3"]:
    """Unit vectors from the surface towards each light, in the world frame."""
    angles = [(math.radians(light.elevation_degrees), math.radians(light.azimuth_degrees)) for light in scene.lights]
    vectors = tuple((math.cos(e) * math.sin(a), math.sin(e), math.cos(e) * math.cos(a)) for e, a in angles)
    return constant(vectors, like).reshape(len(angles), 3)


def shade(
    normals: Float[Tensor, "*B V 3"], azimuth: Float[Tensor, "*B"], scene: SceneConfig
) -> Float[Tensor, "*B V 3"]:
    """Linear RGB of white Lambertian vertices, lit from both sides: ambient + Σ_k colour_k · |n · l_k|, cut off at 1
    as pictures are.

    `normals` are in the object frame; the lights stay with the camera, so it is they that turn by -azimuth here.
    """
    turned = light_directions(scene, normals) @ rotation_about_y(azimuth)
    return _reflected((normals @ turned.transpose(-1, -2)).abs(), scene)


def shade_by_light(
    normals: Float[Tensor, "*B V 3"],
    azimuth: Float[Tensor, "*B"],
    light_azimuth: Float[Tensor, "*B L"],
    scene: SceneConfig,
) -> Float[Tensor, "*B V L 3"]:
    """`shade`, with all lights turned together about +Y by each light azimuth λ (radians) in the camera's frame."""
    turned = light_directions(scene, normals) @ rotation_about_y(azimuth[..., None] - light_azimuth)
    cosines = (normals @ turned.flatten(-3, -2).transpose(-1, -2)).abs()
    return _reflected(cosines.unflatten(-1, turned.shape[-3:-1]), scene)


def _reflected(cosines: Float[Tensor, "*N K"], scene: SceneConfig) -> Float[Tensor, "*N 3"]:
    colours = constant(tuple(light.colour for light in scene.lights), cosines).reshape(-1, 3)
    return (cosines @ colours + constant(scene.ambient, cosines)).clamp(max=1.0)
