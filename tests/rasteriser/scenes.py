"""Random scenes, from tame to hostile, that every backend must draw alike."""

from typing import NamedTuple

import numpy as np

from rasteriser.topology import Topology, build_topology
from trainer.geometry.topology import subdivided_cube
from trainer.rendering.camera import NEAREST_DEPTH


class Scene(NamedTuple):
    screen: np.ndarray  # [V, 3] x, y, inverse depth
    colours: np.ndarray  # [V, 3]
    topology: Topology
    target: np.ndarray  # [3, H, W]

    @property
    def size(self) -> tuple[int, int]:
        return self.target.shape[2], self.target.shape[1]

    def together(self, gradient: np.ndarray) -> np.ndarray:
        """Summed over vertices in one place: which of two coincident edges a picture depends on is anyone's choice."""
        _, place = np.unique(self.screen, axis=0, return_inverse=True)
        summed = np.zeros((len(self.screen), gradient.shape[1]))
        np.add.at(summed, place.reshape(-1), gradient)
        return summed


def random_scene(seed: int, least: int = 1, most: int = 24) -> Scene:
    """A deformed cube, or two that interpenetrate, often partly outside of the picture, whose sides have from `least`
    to `most` pixels; some reach behind the camera, and some have faces that lie upon others."""
    rng = np.random.default_rng(seed)
    width, height = int(rng.integers(least, most + 1)), int(rng.integers(least, most + 1))
    vertices, faces = _deformed_cube(rng)
    if rng.random() < 0.3:
        more, other_faces = _deformed_cube(rng)
        faces = np.concatenate((faces, other_faces + len(vertices)))
        vertices = np.concatenate((vertices, more + rng.normal(scale=0.3, size=3)))
    if rng.random() < 0.2:  # faces without area
        vertices[rng.integers(len(vertices))] = vertices[rng.integers(len(vertices))]
    zoom = max(width, height) * rng.uniform(0.3, 1.2)
    screen = np.concatenate((vertices[:, :2] * zoom + [width / 2, height / 2], 1 / (2.5 + vertices[:, 2:])), 1)
    colours = rng.uniform(size=(len(vertices), 3))
    if rng.random() < 0.1:
        screen = _close_by(vertices + np.array([0, 0, rng.uniform(-1.5, 1.0)]), zoom, width, height)
    if rng.random() < 0.1:
        screen, colours, faces = _with_a_square_upon_another(screen, colours, faces, rng)
    return Scene(
        screen.astype(np.float32),
        colours.astype(np.float32),
        build_topology(faces),
        rng.uniform(size=(3, height, width)).astype(np.float32),
    )


def _deformed_cube(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    base = subdivided_cube(int(rng.integers(1, 4)))
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    noise = rng.normal(size=base.vertices.shape) * rng.choice([0.0, 0.03, 0.2])
    # Wings as thin as a fortieth of their breadth.
    return (base.vertices * rng.choice([0.02, 0.3, 1.0], size=3) + noise) @ turn.T, base.faces


def _close_by(vertices: np.ndarray, zoom: float, width: int, height: int) -> np.ndarray:
    """As `project` has it: what is nearer than NEAREST_DEPTH, or behind the camera, is drawn as if it were that far."""
    inverse_depth = 1 / np.maximum(vertices[:, 2:], NEAREST_DEPTH)
    return np.concatenate((vertices[:, :2] * zoom * inverse_depth + [width / 2, height / 2], inverse_depth), 1)


def _with_a_square_upon_another(
    screen: np.ndarray, colours: np.ndarray, faces: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """In front of all else two squares of one depth that overlap, each of two faces: the first is seen."""
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    middle, depth = screen[:, :2].mean(0), 2 * screen[:, 2].max()
    corners = np.concatenate([middle + square * rng.uniform(2, 9, 2) - rng.uniform(0, 5, 2) for _ in range(2)])
    flat = np.concatenate((corners, np.full((8, 1), depth)), 1)
    halves = np.array([(0, 1, 2), (0, 2, 3)]) + len(screen)
    return (
        np.concatenate((screen, flat)),
        np.concatenate((colours, rng.uniform(size=(8, 3)))),
        np.concatenate((faces, halves, halves + 4)),
    )
