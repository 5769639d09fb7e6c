"""The renderer's gradients against central differences of supersampled pictures: the truth knows nothing of pieces.

Every coordinate of every vertex is moved. A scene's error is |gradient - difference| / |difference| over all of them.
"""

from typing import Literal, NamedTuple

import numpy as np
import pytest
import torch

from rasteriser import pictures, supersample
from rasteriser.topology import build_topology
from trainer.config import SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering.lighting import shade

WIDTH, HEIGHT, FOCAL = 64, 48, 80.0
# With 16 the differences themselves are off by some percent: a step must be short, and then moves few samples.
SUPERSAMPLING, STEP = 64, 0.02
# Inverse depths move by this much less than pixels.
DEPTH_UNIT = 0.01
SCENES = 3

Kind = Literal["cube", "boxes", "wing"]


def make_scene(kind: Kind, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(screen [V, 3], colours [V, 3], faces): a deformed cube, two boxes that interpenetrate, or a thin bent wing."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    match kind:
        case "cube":
            base, faces = subdivided_cube(2)
            vertices = (base * rng.uniform(0.5, 1, 3) + rng.normal(scale=0.05, size=base.shape)) @ turn.T
        case "boxes":
            base, faces = subdivided_cube(1)
            other, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            second = base * rng.uniform(0.3, 1, 3) @ other.T + rng.normal(scale=0.15, size=3)
            vertices = np.concatenate((base * rng.uniform(0.5, 1, 3) @ turn.T, second))
            faces = np.concatenate((faces, faces + len(base)))
        case "wing":
            base, faces = subdivided_cube(2)
            vertices = base * (1, 0.03, 0.5)
            vertices[:, 1] += 0.1 * vertices[:, 0] ** 2
            vertices = vertices @ turn.T
    normals = vertex_normals(torch.tensor(vertices * (1, 1, -1))[None], torch.tensor(faces))
    colours = shade(normals, torch.zeros(1, dtype=torch.float64), SceneConfig())[0].numpy()
    screen = np.concatenate((vertices[:, :2] * 32 + (WIDTH / 2, HEIGHT / 2), 1 / (2.5 + vertices[:, 2:])), 1)
    return screen.astype(np.float32).astype(float), colours.astype(np.float32), faces


class Window(NamedTuple):
    """A part of the picture, pixels."""

    left: int
    top: int
    right: int
    bottom: int


WHOLE = Window(0, 0, WIDTH, HEIGHT)


def truth(screen: np.ndarray, colours: np.ndarray, faces: np.ndarray, window: Window = WHOLE) -> supersample.Picture:
    width, height = window.right - window.left, window.bottom - window.top
    depth = 1 / screen[:, 2]
    x = (screen[:, 0] - window.left - width / 2) * depth / FOCAL
    y = (height / 2 - (screen[:, 1] - window.top)) * depth / FOCAL
    corners = np.stack((x, y, depth), 1)[faces]
    return supersample.render(corners, colours[faces].astype(float), FOCAL, width, height, SUPERSAMPLING)


def around(vertex: int, screen: np.ndarray, faces: np.ndarray) -> Window:
    """All that changes where a vertex moves: its faces, and a pixel more."""
    touched = screen[faces[(faces == vertex).any(1)].reshape(-1), :2]
    (left, top), (right, bottom) = np.floor(touched.min(0)).astype(int) - 1, np.ceil(touched.max(0)).astype(int) + 1
    return Window(max(left, 0), max(top, 0), min(right, WIDTH), min(bottom, HEIGHT))


def inner(alpha: np.ndarray) -> np.ndarray:
    """[H, W]: 1 for pixels that no silhouette touches, nor any beside them."""
    padded = np.pad(alpha, 1)
    neighbours = [padded[y : y + HEIGHT, x : x + WIDTH] for y in range(3) for x in range(3)]
    return (np.min(neighbours, axis=0) >= 1).astype(float)


def relative_errors(kind: Kind, seed: int) -> list[float]:
    """Of three squared losses: of the silhouette, of the shading inside it, and of the whole picture."""
    rng = np.random.default_rng(seed)
    screen, colours, faces = make_scene(kind, rng)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    target = np.stack([0.5 + 0.5 * np.sin(x / 7 + c + rng.uniform() * 6) * np.cos(y / 5 + c) for c in range(4)], -1)
    weights = np.zeros((3, HEIGHT, WIDTH, 4))
    weights[0, :, :, 3] = 1
    weights[1, :, :, :3] = inner(truth(screen, colours, faces).alpha)[..., None]
    weights[2, :, :, :3] = 1

    def values(moved: np.ndarray, window: Window) -> np.ndarray:
        picture = truth(moved, colours, faces, window)
        rows, columns = slice(window.top, window.bottom), slice(window.left, window.right)
        residual = np.concatenate((picture.colour, picture.alpha[..., None]), -1) - target[rows, columns]
        return np.asarray(0.5 * (weights[:, rows, columns] * residual**2).sum((1, 2, 3)))

    units = np.array([1, 1, DEPTH_UNIT])
    differences = np.zeros((3, *screen.shape))
    for vertex, axis in np.ndindex(screen.shape):
        step = np.zeros_like(screen)
        step[vertex, axis] = STEP * units[axis]
        window = around(vertex, screen, faces)
        differences[:, vertex, axis] = (values(screen + step, window) - values(screen - step, window)) / (2 * STEP)

    # Coverage is the colour of a mesh that is white all over.
    painted = np.concatenate((colours, np.ones_like(colours[:, :1])), 1)
    batch = np.stack([screen] * 3).astype(np.float32), np.stack([painted] * 3), build_topology(faces)
    drawn = pictures.draw(*batch, WIDTH, HEIGHT).transpose(0, 2, 3, 1)
    upstream = (weights * (drawn - target)).transpose(0, 3, 1, 2)
    gradients = pictures.draw_gradient(*batch, upstream).screen * units
    sizes = np.linalg.norm(differences, axis=(1, 2))
    return [
        float(np.linalg.norm(found - expected) / size)
        for found, expected, size in zip(gradients, differences, sizes, strict=True)
        if size > 0
    ]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["cube", "boxes", "wing"])
def test_gradients_are_those_of_supersampled_pictures(kind: Kind) -> None:
    errors = np.concatenate([relative_errors(kind, seed) for seed in range(SCENES)])
    assert np.median(errors) <= 0.02, errors
    assert np.percentile(errors, 95) <= 0.05, errors


def test_contours_alone_would_not_do() -> None:
    """Without creases, a thin wing's edge is taken for its broad side: the comparison notices."""
    errors = []
    for seed in range(3):
        screen, colours, faces = make_scene("wing", np.random.default_rng(seed))
        expected = truth(screen, colours, faces)
        edge = (expected.alpha > 0) & (expected.alpha < 1)
        batch = screen[None].astype(np.float32), colours[None], build_topology(faces)
        errors.append(
            [
                np.abs(pictures.draw(*batch, WIDTH, HEIGHT, crease)[0].transpose(1, 2, 0) - expected.colour)[edge]
                for crease in (pictures.CREASE, np.inf)
            ]
        )
    assert max(255 * exact.mean() for exact, _ in errors) < 0.5
    assert min(255 * contours.mean() for _, contours in errors) > 2
