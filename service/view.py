"""The camera and the lights of a picture as glTF nodes, in the frame of an object that stays where it is.

A picture shows the object turned by the azimuth θ about +Y, before a camera and lights that stand still. The same
picture is taken when the object stays in its own frame and camera and lights turn by −θ: so they do here.
"""

import math
from collections.abc import Sequence
from typing import Any

from service.manifest import Camera, Light


def camera_node(camera: Camera, azimuth: float) -> dict[str, Any]:
    """The node of the camera that sees the object turned by `azimuth` radians; refers to camera 0."""
    elevation = math.radians(camera.elevation_degrees)
    x, y, z = _direction(-azimuth, elevation)
    return {
        "name": "camera",
        "camera": 0,
        "rotation": _facing(-azimuth, elevation),
        "translation": [camera.distance * x, camera.distance * y, camera.distance * z],
    }


def perspective(camera: Camera, aspect: float) -> dict[str, Any]:
    """The glTF camera; `aspect` is width / height."""
    return {
        "name": "camera",
        "type": "perspective",
        "perspective": {
            "yfov": math.radians(camera.field_of_view_degrees),
            "aspectRatio": aspect,
            "znear": camera.distance / 100,
            "zfar": camera.distance * 100,
        },
    }


def light_nodes(lights: Sequence[Light], azimuth: float, light_azimuth: float) -> list[dict[str, Any]]:
    """The nodes of the lights of `directional_lights`, in its order, for an object turned by `azimuth` radians and
    lights turned by `light_azimuth`."""
    nodes: list[dict[str, Any]] = []
    for number, light in enumerate(lights):
        around = math.radians(light.azimuth_degrees) + light_azimuth - azimuth
        above = math.radians(light.elevation_degrees)
        for side, rotation in (("", _facing(around, above)), (" opposite", _facing(around + math.pi, -above))):
            index = len(nodes)
            nodes.append(
                {
                    "name": f"light {number}{side}",
                    "rotation": rotation,
                    "extensions": {"KHR_lights_punctual": {"light": index}},
                }
            )
    return nodes


def directional_lights(lights: Sequence[Light]) -> list[dict[str, Any]]:
    """KHR_lights_punctual lights: each light and its opposite.

    The model's shading is double-sided, |n·l|, and glTF's is not: max(0, n·l) + max(0, n·(−l)) = |n·l|. A white glTF
    surface reflects 1/π of the illuminance, so that an intensity of π stands for a colour of 1.
    """
    described: list[dict[str, Any]] = []
    for number, light in enumerate(lights):
        strength = max(light.colour)
        colour = [value / strength for value in light.colour] if strength > 0 else [1.0, 1.0, 1.0]
        for side in ("", " opposite"):
            described.append(
                {
                    "name": f"light {number}{side}",
                    "type": "directional",
                    "color": colour,
                    "intensity": math.pi * strength,
                }
            )
    return described


def _direction(azimuth: float, elevation: float) -> tuple[float, float, float]:
    """The unit vector from the origin towards azimuth (0 = +Z, π/2 = +X) and elevation, radians."""
    return (
        math.cos(elevation) * math.sin(azimuth),
        math.sin(elevation),
        math.cos(elevation) * math.cos(azimuth),
    )


def _facing(azimuth: float, elevation: float) -> list[float]:
    """The quaternion x, y, z, w that turns +Z to `_direction(azimuth, elevation)`: what looks or shines along −Z then
    faces the origin. It is R_y(azimuth) R_x(−elevation), so +Y stays up."""
    cos_a, sin_a = math.cos(azimuth / 2), math.sin(azimuth / 2)
    cos_e, sin_e = math.cos(elevation / 2), math.sin(elevation / 2)
    return [-cos_a * sin_e, sin_a * cos_e, sin_a * sin_e, cos_a * cos_e]
