"""A picture of a mesh: camera, lights and colours in numpy, drawn by the supersampling rasteriser."""

import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float32, Float64
from numpy import ndarray

from rasteriser import supersample
from trainer.config import DirectionalLight, SceneConfig
from trainer.data.normals import corner_normals
from trainer.data.shapes.solid import Mesh

Draw = Callable[[Mesh, float, float, Float64[ndarray, "F 3 3"]], Float32[ndarray, "H W 3"]]
"""What draws a picture: (mesh, azimuth, light azimuth, corner normals) to linear colour over black."""


def draw(
    mesh: Mesh,
    azimuth: float,
    light_azimuth: float,
    scene: SceneConfig,
    supersampling: int = 4,
    normals: Float64[ndarray, "F 3 3"] | None = None,
    closed: bool = False,
) -> tuple[Float32[ndarray, "H W 3"], Float32[ndarray, "H W"]]:
    """Draws a white mesh, given in the object frame, at `azimuth` under the scene's lights turned by `light_azimuth`
    (radians); returns linear colour over black, 0..1, and coverage.

    The camera is the scene's: it looks at the origin. `normals` spares their computation where one mesh is drawn often,
    and `closed`, of a mesh of solids that look outward, the drawing of their backs.
    """
    if normals is None:
        normals = corner_normals(mesh)
    # To the object the lights are turned the other way. As one long list: numpy multiplies a stack of small matrices
    # one by one.
    colours = lit(normals.reshape(-1, 3), scene, light_azimuth - azimuth).reshape(-1, 3, 3)
    camera = to_camera(mesh.vertices @ rotation_about_y(azimuth).T, scene)
    return supersample.render(
        camera.take(mesh.faces, axis=0), colours, focal_length(scene), scene.width, scene.height, supersampling, closed
    )


def rotation_about_y(angle: float) -> Float64[ndarray, "3 3"]:
    """Right-handed rotation about +Y by `angle` radians, for column vectors: +Z turns towards +X."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([(cosine, 0.0, sine), (0.0, 1.0, 0.0), (-sine, 0.0, cosine)])


def lit(normals: Float64[ndarray, "*N 3"], scene: SceneConfig, light_azimuth: float = 0.0) -> Float64[ndarray, "*N 3"]:
    """Linear colour of white points of unit `normals`, as the lights stand: ambient + Σ colour·|n·l|, cut off at 1."""
    directions = np.stack([light_direction(light, light_azimuth) for light in scene.lights] or [np.zeros(3)])
    intensities = np.array([light.colour for light in scene.lights] or [(0.0, 0.0, 0.0)])
    colours: Float64[ndarray, "*N 3"] = np.clip(np.abs(normals @ directions.T) @ intensities + scene.ambient, 0.0, 1.0)
    return colours


def light_direction(light: DirectionalLight, light_azimuth: float = 0.0) -> Float64[ndarray, "3"]:
    """Unit vector towards the light in the world frame, all lights turned by `light_azimuth` radians about +Y."""
    azimuth, elevation = math.radians(light.azimuth_degrees) + light_azimuth, math.radians(light.elevation_degrees)
    return np.array(
        [math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth)]
    )


def to_camera(world: Float64[ndarray, "V 3"], scene: SceneConfig) -> Float64[ndarray, "V 3"]:
    """World points in camera coordinates: x right, y up, z depth."""
    elevation = math.radians(scene.camera.elevation_degrees)
    forward = np.array([0.0, -math.sin(elevation), -math.cos(elevation)])
    up = np.array([0.0, math.cos(elevation), -math.sin(elevation)])
    centre = -scene.camera.distance * forward
    points: Float64[ndarray, "V 3"] = (world - centre) @ np.stack((np.array([1.0, 0.0, 0.0]), up, forward), -1)
    return points


def focal_length(scene: SceneConfig) -> float:
    """Focal length, pixels."""
    return scene.height / 2 / math.tan(math.radians(scene.camera.field_of_view_degrees) / 2)
