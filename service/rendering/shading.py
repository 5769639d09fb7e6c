"""Lambert's law at the vertices: the colours that are interpolated over faces."""

import math

import numpy as np
from numpy.typing import NDArray

from service.manifest import Colour, Light
from service.rendering.projection import rotation_about_y


def shade(
    normals: NDArray[np.float32], azimuth: float, light_azimuth: float, lights: tuple[Light, ...], ambient: Colour
) -> NDArray[np.float64]:
    """Linear RGB [V, 3] of white, matt vertices with unit normals [V, 3]: ambient + Σ colour·|n·l|, both sides alike,
    cut off at 1 as pictures are.

    The object is turned by `azimuth` radians about +Y, its lights by `light_azimuth`; normals are in the object frame.
    """
    if not lights:
        return np.tile(np.minimum(ambient, 1.0), (len(normals), 1))
    directions = np.array([_direction(light, light_azimuth) for light in lights]) @ rotation_about_y(azimuth)
    colours = np.array([light.colour for light in lights])
    shaded: NDArray[np.float64] = np.minimum(np.abs(normals @ directions.T) @ colours + ambient, 1.0)
    return shaded


def _direction(light: Light, light_azimuth: float) -> tuple[float, float, float]:
    """The unit vector towards a light before the camera."""
    around, above = math.radians(light.azimuth_degrees) + light_azimuth, math.radians(light.elevation_degrees)
    return math.cos(above) * math.sin(around), math.sin(above), math.cos(above) * math.cos(around)
