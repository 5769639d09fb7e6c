"""The trainer's camera, light and antialiased pictures against those that the data is made with: two independent ways.

`rasteriser.likelihood` draws what `trainer.rendering` projects and shades; `rasteriser.supersample` draws what
`trainer.data.picture` projects and shades, by brute force.
"""

import dataclasses
import math

import numpy as np
import pytest
import torch

from rasteriser import pictures
from rasteriser.topology import build_topology
from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.data import picture
from trainer.data.shapes.solid import Mesh
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade

# The brute force is then wrong by a tenth of a step on average at an edge.
SUPERSAMPLING = 32
# No light mirrors another, and each has a colour of its own.
SCENE = SceneConfig(
    camera=CameraConfig(elevation_degrees=25.0, distance=1.9, field_of_view_degrees=32.0),
    lights=(
        DirectionalLight(40.0, 20.0, (0.6, 0.2, 0.0)),
        DirectionalLight(110.0, 65.0, (0.0, 0.4, 0.3)),
        DirectionalLight(-75.0, 10.0, (0.1, 0.0, 0.5)),
    ),
    ambient=(0.1, 0.1, 0.05),
)
AZIMUTHS = (0.0, 0.9, -2.2)


def smooth_mesh(kind: str, segments: int) -> Mesh:
    """A smooth closed surface without any symmetry: a convex egg, or a bean whose hollows hide parts of it."""
    base, faces = subdivided_cube(segments)
    sphere = base / np.linalg.norm(base, axis=1, keepdims=True)
    x, y, z = sphere.T
    match kind:
        case "egg":
            radius = 1 + 0.3 * x + 0.15 * z - 0.1 * y
        case "bean":
            radius = 1 + 0.35 * np.sin(2 * x + 0.5) * np.cos(3 * z - 0.4) + 0.2 * y * x
    return Mesh(sphere * radius[:, None] * (0.28, 0.17, 0.36), faces)


def trainer_s(mesh: Mesh, azimuth: float, scene: SceneConfig) -> np.ndarray:
    vertices, faces = torch.tensor(mesh.vertices)[None], torch.tensor(mesh.faces)
    angle = torch.tensor([azimuth], dtype=torch.float64)
    screen = project(vertices, angle, scene.camera, scene.width, scene.height)
    colours = shade(vertex_normals(vertices, faces), angle, scene)
    topology = build_topology(mesh.faces)
    drawn = pictures.draw(screen.float().numpy(), colours.float().numpy(), topology, scene.width, scene.height)
    return drawn[0].transpose(1, 2, 0)


def data_s(mesh: Mesh, azimuth: float, scene: SceneConfig) -> tuple[np.ndarray, np.ndarray]:
    normals = vertex_normals(torch.tensor(mesh.vertices), torch.tensor(mesh.faces)).numpy()[mesh.faces]
    return picture.draw(mesh, azimuth, 0.0, scene, SUPERSAMPLING, normals)


def mean_errors(drawn: np.ndarray, mesh: Mesh, azimuth: float, scene: SceneConfig = SCENE) -> tuple[float, float]:
    """Mean absolute difference over the pixels at the silhouette, and over those inside it; steps of 1/255."""
    expected, alpha = data_s(mesh, azimuth, scene)
    silhouette, inside = (alpha > 0) & (alpha < 1), alpha == 1
    assert silhouette.sum() > 100
    assert inside.sum() > 1000
    error = 255 * np.abs(drawn - expected)
    return float(error[silhouette].mean()), float(error[inside].mean())


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize("kind", ["egg", "bean"])
@pytest.mark.parametrize("segments", [2, 4])
def test_both_ways_to_a_picture_agree(kind: str, azimuth: float, segments: int) -> None:
    """To a quarter of a step of 1/255 at edges, most of it the brute force's own error, be they alone in their pixel
    (26 vertices) or several together (98)."""
    mesh = smooth_mesh(kind, segments)
    silhouette, inside = mean_errors(trainer_s(mesh, azimuth, SCENE), mesh, azimuth)
    assert silhouette < 0.25
    assert inside < 0.02


@pytest.mark.parametrize(
    "mistake", ["transposed rotation", "mirrored picture", "camera from below", "mirrored light", "light from below"]
)
def test_the_comparison_would_notice(mistake: str) -> None:
    mesh, azimuth, scene = smooth_mesh("egg", 4), AZIMUTHS[1], SCENE
    drawn = trainer_s(mesh, azimuth, scene)
    match mistake:
        case "transposed rotation":
            azimuth = -azimuth
        case "mirrored picture":
            drawn = drawn[:, ::-1]
        case "camera from below":
            below = dataclasses.replace(scene.camera, elevation_degrees=-scene.camera.elevation_degrees)
            scene = dataclasses.replace(scene, camera=below)
        case "mirrored light":
            lights = tuple(dataclasses.replace(one, azimuth_degrees=-one.azimuth_degrees) for one in scene.lights)
            scene = dataclasses.replace(scene, lights=lights)
        case "light from below":
            lights = tuple(dataclasses.replace(one, elevation_degrees=-one.elevation_degrees) for one in scene.lights)
            scene = dataclasses.replace(scene, lights=lights)
    silhouette, inside = mean_errors(drawn, mesh, azimuth, scene)
    assert silhouette > 10
    assert inside > 2


def test_a_turn_by_one_degree_shows() -> None:
    mesh = smooth_mesh("egg", 4)
    silhouette, inside = mean_errors(trainer_s(mesh, AZIMUTHS[1] + math.radians(1), SCENE), mesh, AZIMUTHS[1])
    assert silhouette > 4
    assert inside > 0.3
