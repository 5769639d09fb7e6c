"""How true the renderer's pictures are: beside the same by brute force, 32 × 32 samples a pixel.

`python -m benchmarks.edges` writes docs/results/renderer-edges.json, whose figures docs/renderer.md gives.
"""

import json
import math
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
import tyro

from benchmarks.machine import versions
from rasteriser import pictures
from rasteriser.topology import build_topology
from trainer.config import DirectionalLight, SceneConfig
from trainer.data import picture
from trainer.data.shapes.solid import Mesh
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade

Array = npt.NDArray[np.float64]

CREASES = (0.0, 0.1, 0.3, math.inf)
SCENE = SceneConfig(
    width=64,
    height=48,
    lights=(
        DirectionalLight(40.0, 20.0, (0.6, 0.2, 0.0)),
        DirectionalLight(110.0, 65.0, (0.0, 0.4, 0.3)),
        DirectionalLight(-75.0, 10.0, (0.1, 0.0, 0.5)),
    ),
    ambient=(0.1, 0.1, 0.05),
)


@dataclass(frozen=True)
class Options:
    """Options of the measurement."""

    output: Path = Path("docs/results/renderer-edges.json")
    """The file with all figures."""
    scenes: int = 12
    """Random shapes of each kind, each from a random side."""
    supersampling: int = 32
    """Samples a pixel, along x and along y, of what counts as the truth."""
    seed: int = 0
    """Of shapes and sides."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.edges", description=__doc__)
    report: dict[str, Any] = {
        "what": "absolute error in steps of 1/255: mean over pixels that are covered in part (edge), mean over those "
        "that are covered whole (inside), and the largest; by crease, where null is infinite",
        "command": shlex.join(["python", "-m", "benchmarks.edges", *sys.argv[1:]]),
        "versions": versions(),
        "scenes": options.scenes,
        "supersampling": options.supersampling,
        "kinds": {kind: measured(kind, options) for kind in KINDS},
    }
    options.output.write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
    print(f"written: {options.output}")


def measured(kind: str, options: Options) -> list[dict[str, Any]]:
    """A row for each crease."""
    random = np.random.default_rng(options.seed)
    errors: dict[float, list[tuple[Array, Array]]] = {crease: [] for crease in CREASES}
    for _ in range(options.scenes):
        mesh, azimuth = KINDS[kind](random), float(random.uniform(-math.pi, math.pi))
        vertices, faces = torch.as_tensor(mesh.vertices)[None], torch.as_tensor(mesh.faces)
        normals = vertex_normals(vertices, faces)
        corners = normals[0].numpy()[mesh.faces]
        truth, coverage = picture.draw(mesh, azimuth, 0.0, SCENE, options.supersampling, corners)
        angle = torch.tensor([azimuth], dtype=torch.float64)
        screen = project(vertices, angle, SCENE.camera, SCENE.width, SCENE.height).float().numpy()
        colours, topology = shade(normals, angle, SCENE).float().numpy(), build_topology(mesh.faces)
        for crease in CREASES:
            drawn = pictures.draw(screen, colours, topology, SCENE.width, SCENE.height, crease)[0].transpose(1, 2, 0)
            error = 255.0 * np.abs(drawn - truth.astype(float))
            errors[crease].append((error[(coverage > 0) & (coverage < 1)], error[coverage == 1]))
    return [
        {
            "crease": None if crease == math.inf else crease,
            "edge": round(float(np.concatenate([at_edges for at_edges, _ in of]).mean()), 3),
            "inside": round(float(np.concatenate([inside for _, inside in of]).mean()), 3),
            "largest": round(max(float(part.max()) for pair in of for part in pair if part.size), 2),
        }
        for crease, of in errors.items()
    ]


def egg(random: np.random.Generator, segments: int) -> Mesh:
    """Convex: in a pixel of its silhouette one edge is seen, or the two at a vertex."""
    cube, faces = subdivided_cube(segments)
    sphere = cube / np.linalg.norm(cube, axis=1, keepdims=True)
    radius = 1.0 + sphere @ random.uniform(-0.25, 0.25, 3)
    return Mesh(sphere * radius[:, None] * random.uniform(0.2, 0.36, 3), faces)


def deformed_cube(random: np.random.Generator, segments: int) -> Mesh:
    """Not convex: its parts hide one another."""
    cube, faces = subdivided_cube(segments)
    return Mesh(0.3 * (cube * random.uniform(0.5, 1.0, 3) + random.normal(scale=0.1, size=cube.shape)), faces)


def wing(random: np.random.Generator) -> Mesh:
    """Thinner than a pixel, and bent."""
    cube, faces = subdivided_cube(2)
    points = cube * (0.45, 0.012, 0.2)
    points[:, 1] += random.uniform(-0.5, 0.5) * points[:, 0] ** 2
    return Mesh(points, faces)


def boxes(random: np.random.Generator) -> Mesh:
    """Two that interpenetrate."""
    cube, faces = subdivided_cube(1)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    other = 0.25 * (cube * random.uniform(0.3, 1.0, 3)) @ turn.T + random.normal(scale=0.05, size=3)
    return Mesh(
        np.concatenate((0.25 * cube * random.uniform(0.5, 1.0, 3), other)), np.concatenate((faces, faces + len(cube)))
    )


KINDS = {
    "egg, 26 vertices": lambda random: egg(random, 2),
    "egg, 98 vertices": lambda random: egg(random, 4),
    "deformed cube, 26 vertices": lambda random: deformed_cube(random, 2),
    "deformed cube, 98 vertices": lambda random: deformed_cube(random, 4),
    "thin bent wing": wing,
    "boxes that interpenetrate": boxes,
}

if __name__ == "__main__":
    main()
