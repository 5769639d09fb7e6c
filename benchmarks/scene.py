"""The scene that every renderer draws: one car-like shape, seen from random sides."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import torch

from rasteriser.topology import Topology
from trainer.config import SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering.camera import project
from trainer.rendering.cpu import topology_of
from trainer.rendering.lighting import shade

FloatArray = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Scene:
    """N poses of one mesh before black, in the coordinates that the different renderers start from."""

    faces: npt.NDArray[np.uint32]
    """[F, 3] vertex indices, counter-clockwise from outside."""
    topology: Topology
    """Edges and adjacency of the faces."""
    screen: FloatArray
    """[N, V, 3] x and y in pixels (the centre of the first pixel is at 0.5, 0.5), and inverse depth."""
    camera_points: FloatArray
    """[N, V, 3] the same vertices in front of the camera: right, down and forward, in diagonals of the object."""
    colours: FloatArray
    """[N, V, 3] linear RGB of the vertices, 0..1."""
    targets: FloatArray
    """[N, 3, H, W] random pictures to compare with, 0..1."""
    focal: float
    """Focal length, pixels."""
    field_of_view_degrees: float
    """Vertical."""

    @property
    def count(self) -> int:
        return len(self.screen)

    @property
    def width(self) -> int:
        return int(self.targets.shape[3])

    @property
    def height(self) -> int:
        return int(self.targets.shape[2])

    def part(self, start: int, stop: int) -> "Scene":
        """Some of the poses."""
        chosen = slice(start, stop)
        return replace(
            self,
            screen=self.screen[chosen],
            camera_points=self.camera_points[chosen],
            colours=self.colours[chosen],
            targets=self.targets[chosen],
        )


def make_scene(segments: int, width: int, height: int, count: int, random: np.random.Generator) -> Scene:
    """A shape of 12·segments² faces, its bounding-box diagonal 1, in `count` random poses under the default lights.

    The poses and the target pictures are drawn from `random`.
    """
    config = SceneConfig(width=width, height=height)
    mesh = subdivided_cube(segments)
    vertices = torch.as_tensor(_car_like(mesh.vertices), dtype=torch.float32)
    faces = torch.as_tensor(mesh.faces)
    azimuth = torch.as_tensor(random.uniform(-math.pi, math.pi, count), dtype=torch.float32)
    many = vertices.expand(count, -1, -1)
    screen = project(many, azimuth, config.camera, width, height)
    focal = height / 2 / math.tan(math.radians(config.camera.field_of_view_degrees) / 2)
    right, down = (screen[..., 0] - width / 2) / focal, (screen[..., 1] - height / 2) / focal
    points = torch.stack((right, down, torch.ones_like(right)), -1) / screen[..., 2:]
    return Scene(
        faces=mesh.faces.astype(np.uint32),
        topology=topology_of(faces),
        screen=screen.contiguous().numpy(),
        camera_points=points.contiguous().numpy(),
        colours=shade(vertex_normals(many, faces), azimuth, config).contiguous().numpy(),
        targets=random.random((count, 3, height, width), dtype=np.float32),
        focal=focal,
        field_of_view_degrees=config.camera.field_of_view_degrees,
    )


def _car_like(cube: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """A cube bulged towards a sphere, stretched along z, with a cabin on top; unit bounding-box diagonal."""
    shape = 0.35 * cube / np.abs(cube).max() + 0.65 * cube / np.linalg.norm(cube, axis=1, keepdims=True)
    cabin = 0.5 * np.exp(-4.0 * (shape[:, 2] + 0.2) ** 2) * np.clip(shape[:, 1], 0.0, None)
    shape = (shape + cabin[:, None] * [0.0, 1.0, 0.0]) * [0.45, 0.32, 1.0]
    low, high = shape.min(0), shape.max(0)
    scaled: npt.NDArray[np.float64] = (shape - (low + high) / 2) / np.linalg.norm(high - low)
    return scaled
