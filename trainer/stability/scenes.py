"""Other cameras and other lights than a model was made for, in degrees of severity."""

import math
from collections.abc import Callable
from dataclasses import replace

from trainer.config import DirectionalLight, SceneConfig

Change = Callable[[SceneConfig, float], tuple[SceneConfig, float]]
"""(the model's scene, severity) to another scene, and by how much its lights are turned together, radians."""

_HIGHEST_DEGREES = 89.0


def raised(scene: SceneConfig, severity: float) -> tuple[SceneConfig, float]:
    """The camera stands so many degrees higher, or lower below 0; straight above it stops."""
    elevation = scene.camera.elevation_degrees + severity
    elevation = max(-_HIGHEST_DEGREES, min(_HIGHEST_DEGREES, elevation))
    return replace(scene, camera=replace(scene.camera, elevation_degrees=elevation)), 0.0


def lens(scene: SceneConfig, severity: float) -> tuple[SceneConfig, float]:
    """So many times the field of view (its tangent), from as much nearer by: the object stays as large, its perspective
    does not."""
    half = math.atan(severity * math.tan(math.radians(scene.camera.field_of_view_degrees) / 2))
    camera = replace(
        scene.camera, field_of_view_degrees=math.degrees(2 * half), distance=scene.camera.distance / severity
    )
    return replace(scene, camera=camera), 0.0


def lights_turned(scene: SceneConfig, severity: float) -> tuple[SceneConfig, float]:
    """All lights turned together about the upright axis by so many degrees."""
    return scene, math.radians(severity)


def lights_raised(scene: SceneConfig, severity: float) -> tuple[SceneConfig, float]:
    """All lights so many degrees higher; straight above they stop."""
    lights = tuple(
        replace(light, elevation_degrees=min(90.0, light.elevation_degrees + severity)) for light in scene.lights
    )
    return replace(scene, lights=lights), 0.0


def lights_whiter(scene: SceneConfig, severity: float) -> tuple[SceneConfig, float]:
    """That part of each light's colour has become grey, as bright as before; at 1 all lights are white."""

    def whiter(light: DirectionalLight) -> DirectionalLight:
        grey = sum(light.colour) / 3
        red, green, blue = (value + severity * (grey - value) for value in light.colour)
        return replace(light, colour=(red, green, blue))

    return replace(scene, lights=tuple(whiter(light) for light in scene.lights)), 0.0
