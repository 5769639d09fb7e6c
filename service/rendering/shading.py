"""Lambert's law at the vertices: the colours that are interpolated over faces."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from service.manifest import Colour, Light
from service.rendering.projection import rotation_about_y


def shade(
    normals: NDArray[np.float32],
    azimuth: ArrayLike,
    light_azimuth: ArrayLike,
    lights: tuple[Light, ...],
    ambient: Colour,
) -> NDArray[np.float64]:
    """Linear RGB [..., V, 3] of white, matt vertices with unit normals [..., V, 3]: ambient + Σ colour·|n·l|, both
    sides alike, cut off at 1 as pictures are.

    Objects are turned by `azimuth` [...] radians about +Y, their lights by `light_azimuth` [...]; normals are in the
    object frame.
    """
    if not lights:
        return np.tile(np.minimum(ambient, 1.0), (*normals.shape[:-1], 1))
    around, above = np.radians([(light.azimuth_degrees, light.elevation_degrees) for light in lights]).T
    # Unit vectors towards the lights, before they and the object are turned.
    directions = np.stack((np.cos(above) * np.sin(around), np.sin(above), np.cos(above) * np.cos(around)), -1)
    turned = directions @ rotation_about_y(np.subtract(azimuth, light_azimuth))
    colours = np.array([light.colour for light in lights])
    shaded: NDArray[np.float64] = np.minimum(np.abs(normals @ turned.swapaxes(-1, -2)) @ colours + ambient, 1.0)
    return shaded
