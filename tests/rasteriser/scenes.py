"""Random scenes, from tame to hostile, that every backend must draw alike."""

from typing import NamedTuple

import numpy as np

from rasteriser.topology import Topology, build_topology
from trainer.geometry.topology import subdivided_cube


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
    to `most` pixels."""
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
