"""From the object frame to the screen of the manifest's camera."""

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from service.manifest import Camera

NEAREST_DEPTH: Final = 0.05
"""Closer than this to the camera (unit: the object's diagonal) a vertex is treated as being at this depth."""


def project(
    vertices: NDArray[np.float32], azimuth: ArrayLike, camera: Camera, width: float, height: float
) -> NDArray[np.float64]:
    """Screen coordinates x, y, w [..., V, 3] of vertices [..., V, 3] of objects turned by `azimuth` [...] radians
    about +Y.

    x and y are from the top left corner of a picture that is `width` × `height` units large; w is the inverse depth,
    larger for what is nearer. It is the camera that training drew with.
    """
    elevation = math.radians(camera.elevation_degrees)
    focal = height / 2 / math.tan(math.radians(camera.field_of_view_degrees) / 2)
    sine, cosine = math.sin(elevation), math.cos(elevation)
    # Rows: the camera's right, up and forward axes in the world.
    view = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, -sine, -cosine]])
    seen = vertices @ (view @ rotation_about_y(azimuth)).swapaxes(-1, -2)
    inverse_depth = 1.0 / np.maximum(seen[..., 2] + camera.distance, NEAREST_DEPTH)
    return np.stack(
        (
            width / 2 + focal * seen[..., 0] * inverse_depth,
            height / 2 - focal * seen[..., 1] * inverse_depth,
            inverse_depth,
        ),
        -1,
    )


def rotation_about_y(angle: ArrayLike) -> NDArray[np.float64]:
    """Right-handed rotations [..., 3, 3] about +Y by angles [...] in radians, for column vectors: +Z turns towards
    +X."""
    angles = np.asarray(angle, np.float64)
    matrices = np.zeros((*angles.shape, 3, 3))
    matrices[..., 0, 0] = matrices[..., 2, 2] = np.cos(angles)
    matrices[..., 0, 2] = np.sin(angles)
    matrices[..., 2, 0] = -matrices[..., 0, 2]
    matrices[..., 1, 1] = 1.0
    return matrices
