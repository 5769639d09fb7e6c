"""T(v_object, θ) of Eq. 3 and the projection: object frame → screen."""

import math

import torch
from jaxtyping import Float
from torch import Tensor

from trainer.config import CameraConfig
from trainer.geometry.conventions import rotation_about_y
from trainer.rendering.constants import constant

# Closer than this to the camera (unit: the object's diagonal) a vertex is treated as being at this depth.
NEAREST_DEPTH = 0.05


def project(
    vertices: Float[Tensor, "*B V 3"],
    azimuth: Float[Tensor, "*B"],
    camera: CameraConfig,
    width: int,
    height: int,
) -> Float[Tensor, "*B V 3"]:
    """Screen coordinates (x, y, w) of an object turned by `azimuth` radians about +Y.

    x and y are pixels from the top left corner (the centre of the first pixel is at 0.5, 0.5); w is the inverse
    depth, which is linear on the screen and larger for what is nearer.
    """
    elevation = math.radians(camera.elevation_degrees)
    focal = height / 2 / math.tan(math.radians(camera.field_of_view_degrees) / 2)
    sine, cosine = math.sin(elevation), math.cos(elevation)
    # Rows: the camera's right, up and forward axes in the world.
    view = constant(((1.0, 0.0, 0.0), (0.0, cosine, -sine), (0.0, -sine, -cosine)), vertices)
    seen = vertices @ (view @ rotation_about_y(azimuth)).transpose(-1, -2)
    right, up, forward = seen.unbind(-1)
    inverse_depth = (forward + camera.distance).clamp(min=NEAREST_DEPTH).reciprocal()
    return torch.stack(
        (width / 2 + focal * right * inverse_depth, height / 2 - focal * up * inverse_depth, inverse_depth), -1
    )
