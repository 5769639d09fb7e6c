"""What a model makes of the pictures of an object: the most probable shape, poses and lights."""

from typing import NamedTuple

from jaxtyping import Float
from torch import Tensor

from trainer.model.posterior import most_probable_azimuth, most_probable_light
from trainer.model.vae import Model


class Reconstruction(NamedTuple):
    """Shapes in the model's own frame, and how each picture shows them; angles in radians."""

    vertices: Float[Tensor, "B V 3"]
    azimuths: Float[Tensor, "B N"]
    light_azimuths: Float[Tensor, "B N"] | None
    """None where the light is fixed."""


def reconstruct(model: Model, images: Float[Tensor, "B N 3 H W"]) -> Reconstruction:
    """One shape for the N pictures of each of B objects, and a pose for each picture.

    The shape is that of the mean of Q(z), which is pooled over the N pictures (section 4, "Shape").
    """
    objects, views = images.shape[:2]
    posterior = model.encode_views(images)
    light = most_probable_light(posterior)
    return Reconstruction(
        model.decode(posterior.shape_mean[::views]),
        most_probable_azimuth(posterior).reshape(objects, views),
        None if light is None else light.reshape(objects, views),
    )
