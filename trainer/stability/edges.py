"""The rasteriser where it is hardest: surfaces that are seen at grazing angles, and boxes that interpenetrate.

Its pictures and their gradients are held against supersampled ones, and against central differences of these, angle by
angle. A scene is a plate whose broad side is turned away from the camera, until it is seen edge-on; or two boxes of one
shape about one centre, one turned against the other, so that at small angles their faces nearly coincide.
"""

from typing import Any, Literal, NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int64
from numpy import ndarray
from numpy.random import Generator

from rasteriser import pictures, supersample
from rasteriser.topology import build_topology
from trainer.config import SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering.lighting import shade

Kind = Literal["grazing", "interpenetration"]
ANGLES_DEGREES: dict[Kind, tuple[float, ...]] = {
    "grazing": (0, 30, 60, 75, 85, 88, 90),
    "interpenetration": (0.1, 1, 3, 10, 20, 45),
}
"""Between the line of sight and the plate's normal; and between the boxes."""
TITLES: dict[Kind, str] = {
    "grazing": "a plate, by its angle to the camera",
    "interpenetration": "two boxes, by the angle between them",
}
CREASES = {"exact": pictures.CREASE, "contours": float("inf")}
"""What is antialiased: all borders; or contours alone, as trainings do."""

_WIDTH, _HEIGHT, _FOCAL = 48, 36, 60.0
_DISTANCE = 2.5
_SUPERSAMPLING, _STEP = 64, 0.02
# Inverse depths move by this much less than pixels.
_DEPTH_UNIT = 0.01
_THICKNESS = 0.04


class Scene(NamedTuple):
    """A mesh on the screen."""

    screen: Float[ndarray, "V 3"]
    """Pixels, and inverse depth."""
    colours: Float[ndarray, "V 3"]
    faces: Int64[ndarray, "F 3"]


def edge_figures(count: int, seed: int = 0) -> dict[str, Any]:
    """Errors of pictures and gradients at each angle, over `count` random scenes each."""
    return {
        kind: {"title": TITLES[kind], "points": [_point(kind, angle, count, seed) for angle in angles]}
        for kind, angles in ANGLES_DEGREES.items()
    }


def _point(kind: Kind, angle_degrees: float, count: int, seed: int) -> dict[str, Any]:
    scenes = [make_scene(kind, angle_degrees, np.random.default_rng([seed, number])) for number in range(count)]
    point: dict[str, Any] = {"angle_degrees": angle_degrees, "scenes": count}
    for name, crease in CREASES.items():
        point[f"picture_error_{name}"] = round(float(np.mean([picture_error(scene, crease) for scene in scenes])), 4)
    errors = [gradient_errors(scene, number, seed) for number, scene in enumerate(scenes)]
    for name in CREASES:
        point[f"gradient_error_{name}"] = round(float(np.median([error[name] for error in errors])), 4)
    return point


def make_scene(kind: Kind, angle_degrees: float, rng: Generator) -> Scene:
    """A scene at an angle, otherwise random: where it stands in the picture, and how it is turned about the line of
    sight or, of the boxes, altogether."""
    angle, roll = np.radians(angle_degrees), rng.uniform(0, 2 * np.pi)
    base, faces = subdivided_cube(1)
    match kind:
        case "grazing":
            # +z looks at the camera: the plate's normal turns from there towards +y.
            vertices = _about(2, roll) @ _about(0, -angle) @ (base * (0.9, 0.6, _THICKNESS)).T
        case "interpenetration":
            box = base * rng.uniform(0.4, 0.8, 3)
            axis, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            turned = box @ (axis @ _about(2, angle) @ axis.T).T
            whole, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            vertices = whole @ np.concatenate((box, turned)).T
            faces = np.concatenate((faces, faces + len(base)))
    placed = vertices.T + np.append(rng.uniform(-0.05, 0.05, 2), 0.0)
    normals = vertex_normals(torch.tensor(placed)[None], torch.tensor(faces))
    colours = shade(normals, torch.zeros(1, dtype=torch.float64), SceneConfig())[0].numpy()
    depth = _DISTANCE - placed[:, 2]
    x, y = _WIDTH / 2 + _FOCAL * placed[:, 0] / depth, _HEIGHT / 2 - _FOCAL * placed[:, 1] / depth
    screen = np.stack((x, y, 1 / depth), 1).astype(np.float32)
    return Scene(screen.astype(np.float64), colours.astype(np.float32), faces)


def _about(axis: int, angle: float) -> Float[ndarray, "3 3"]:
    """Right-handed rotation about a coordinate axis."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[second, first], turn[first, second] = np.sin(angle), -np.sin(angle)
    return turn


def truth(scene: Scene) -> supersample.Picture:
    """The picture by brute force."""
    depth = 1 / scene.screen[:, 2]
    x = (scene.screen[:, 0] - _WIDTH / 2) * depth / _FOCAL
    y = (_HEIGHT / 2 - scene.screen[:, 1]) * depth / _FOCAL
    corners = np.stack((x, y, depth), 1)[scene.faces]
    return supersample.render(
        corners, scene.colours[scene.faces].astype(float), _FOCAL, _WIDTH, _HEIGHT, _SUPERSAMPLING
    )


def picture_error(scene: Scene, crease: float) -> float:
    """Mean absolute error over the pixels that the mesh touches, in steps of 1/255."""
    expected = truth(scene)
    drawn = pictures.draw(*_batch(scene, scene.colours), _WIDTH, _HEIGHT, crease)[0].transpose(1, 2, 0)
    return float(255 * np.abs(drawn - expected.colour)[expected.alpha > 0].mean())


def gradient_errors(scene: Scene, number: int, seed: int) -> dict[str, float]:
    """|gradient − difference| / |difference| over all vertices, of the squared error against a smooth picture."""
    rng = np.random.default_rng([seed, number, 1])
    y, x = np.mgrid[:_HEIGHT, :_WIDTH]
    target = np.stack([0.5 + 0.5 * np.sin(x / 7 + rng.uniform() * 6) * np.cos(y / 5 + c) for c in range(3)], -1)

    def value(moved: Float[ndarray, "V 3"]) -> float:
        return float(0.5 * np.square(truth(scene._replace(screen=moved)).colour - target).sum())

    units = np.array([1, 1, _DEPTH_UNIT])
    differences = np.zeros(scene.screen.shape)
    for vertex, axis in np.ndindex(scene.screen.shape):
        step = np.zeros(scene.screen.shape)
        step[vertex, axis] = _STEP * units[axis]
        differences[vertex, axis] = (value(scene.screen + step) - value(scene.screen - step)) / (2 * _STEP)
    batch = _batch(scene, scene.colours)
    errors = {}
    for name, crease in CREASES.items():
        drawn = pictures.draw(*batch, _WIDTH, _HEIGHT, crease)
        upstream = (drawn - target.transpose(2, 0, 1)).astype(np.float32)
        gradient = pictures.draw_gradient(*batch, upstream, crease).screen[0] * units
        errors[name] = float(np.linalg.norm(gradient - differences) / np.linalg.norm(differences))
    return errors


def _batch(scene: Scene, colours: Float[ndarray, "V C"]) -> tuple[Any, Any, Any]:
    return scene.screen[None].astype(np.float32), colours[None], build_topology(scene.faces)
