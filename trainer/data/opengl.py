"""An outside opinion: pictures by OpenGL, through pyrender.

Camera, poses and light are written down here for themselves, as 4 × 4 matrices and dot products, and share nothing with
`data.picture` but the corner normals: where both draw alike, neither is likely to be wrong.
"""

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from jaxtyping import Float32, Float64
from numpy import ndarray

from trainer.config import SceneConfig
from trainer.data.picture import Draw
from trainer.data.shapes.solid import Mesh
from trainer.errors import ConfigError

_INSTALL = "Install it with: pip install pyrender==0.1.45 (and on Debian: apt-get install libegl1 libgl1)."
# Nothing of an object of unit diagonal is farther than this from the origin.
_RADIUS = 0.505


@contextmanager
def opengl(scene: SceneConfig, supersampling: int) -> Iterator[Draw]:
    """Opens OpenGL off screen (EGL) for the block, and yields what draws pictures as `data.picture.draw` does.

    One at a time in a process, and only in the thread that opened it. Lit colours are baked into the corners in floats;
    OpenGL rounds them to 8 linear bits a sample. Raises ConfigError where pyrender or EGL is missing, or pictures are
    larger than OpenGL offers.
    """
    # PyOpenGL reads it when it is imported, and not again.
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    try:
        import pyrender  # noqa: PLC0415

        renderer = pyrender.OffscreenRenderer(scene.width * supersampling, scene.height * supersampling)
    except Exception as error:  # what is missing shows as one of many errors of PyOpenGL's
        raise ConfigError(
            f"Expected pyrender and EGL, found {type(error).__name__}: {error}. {_INSTALL} Or leave --renderer away."
        ) from error

    def draw(mesh: Mesh, azimuth: float, light_azimuth: float, normals: Float64[ndarray, "F 3 3"]) -> Any:
        samples = renderer.render(
            _scene(pyrender, mesh, azimuth, light_azimuth, scene, normals),
            pyrender.RenderFlags.FLAT | pyrender.RenderFlags.SKIP_CULL_FACES,
        )[0]
        return _box_means(samples, supersampling)

    try:
        yield draw
    finally:
        renderer.delete()


def _scene(
    pyrender: Any,
    mesh: Mesh,
    azimuth: float,
    light_azimuth: float,
    scene: SceneConfig,
    normals: Float64[ndarray, "F 3 3"],
) -> Any:
    drawn = pyrender.Scene(ambient_light=(1.0, 1.0, 1.0), bg_color=(0.0, 0.0, 0.0, 1.0))
    turn = np.eye(4)
    turn[:3, :3] = [
        (math.cos(azimuth), 0, math.sin(azimuth)),
        (0, 1, 0),
        (-math.sin(azimuth), 0, math.cos(azimuth)),
    ]
    turned = normals.reshape(-1, 3) @ turn[:3, :3].T
    colours = np.tile(np.asarray(scene.ambient), (len(turned), 1))
    for light in scene.lights:
        up, around = math.radians(light.elevation_degrees), math.radians(light.azimuth_degrees) + light_azimuth
        direction = (math.cos(up) * math.sin(around), math.sin(up), math.cos(up) * math.cos(around))
        colours += np.abs(turned @ direction)[:, None] * light.colour
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    primitive = pyrender.Primitive(positions=corners, normals=turned, color_0=np.clip(colours, 0, 1), mode=4)
    drawn.add(pyrender.Mesh([primitive]), pose=turn)

    elevation = math.radians(scene.camera.elevation_degrees)
    pose = np.eye(4)
    pose[:3, :3] = [
        (1, 0, 0),
        (0, math.cos(elevation), math.sin(elevation)),
        (0, -math.sin(elevation), math.cos(elevation)),
    ]
    pose[:3, 3] = scene.camera.distance * pose[:3, 2]
    field_of_view, distance = math.radians(scene.camera.field_of_view_degrees), scene.camera.distance
    camera = pyrender.PerspectiveCamera(field_of_view, znear=distance - _RADIUS, zfar=distance + _RADIUS)
    drawn.add(camera, pose=pose)
    return drawn


def _box_means(samples: ndarray, side: int) -> Float32[ndarray, "H W 3"]:
    height, width = samples.shape[0] // side, samples.shape[1] // side
    means: Float32[ndarray, "H W 3"] = samples.reshape(height, side, width, side, 3).mean((1, 3), dtype=np.float32)
    return means / np.float32(255)
