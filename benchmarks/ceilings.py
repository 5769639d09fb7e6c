"""How far meshes of each kind can come at all: fitted to several pictures of each object, with the poses given.

    python -m benchmarks.ceilings --output docs/results/ceilings.json

No encoder, no prior and no unseen object: the decoder alone learns a few procedural objects by heart, from a dozen
pictures of each. What it reaches is no bound in the strict sense, but a model that sees one picture of an object, and
knows no pose, is not to be expected beyond it. Writes a JSON file with the IoU of each class and kind of mesh.
"""

import argparse
import json
import math
import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.machine import machine
from imaging.srgb import decode_table, encode
from trainer.config import LossConfig, ModelConfig, OptimiserConfig, SceneConfig
from trainer.data.normals import corner_normals
from trainer.data.picture import draw
from trainer.data.shapes.catalogue import CATEGORIES, make_shape
from trainer.evaluation.fill import fill
from trainer.evaluation.metrics import iou
from trainer.evaluation.voxels import occupy
from trainer.geometry.normals import vertex_normals
from trainer.model.vae import Model
from trainer.rendering import renderer
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade
from trainer.training.loop import fixed_geometry
from trainer.training.schedule import falling, weights_at

SEED = 900_000
LEARNING_RATE, HIDDEN = 5e-3, 64
KINDS = {
    "subdivision": ModelConfig(parameterisation="subdivision"),
    "subdivision, 6 segments": ModelConfig(parameterisation="subdivision", segments=6),
    "subdivision, 8 segments": ModelConfig(parameterisation="subdivision", segments=8),
    "cup": ModelConfig(parameterisation="subdivision", base="cup"),
    "ortho-block": ModelConfig(parameterisation="ortho-block"),
    "full-block": ModelConfig(parameterisation="full-block"),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", default=list(CATEGORIES), help="classes")
    parser.add_argument("--kinds", nargs="*", default=["subdivision", "full-block"], choices=KINDS, help="of meshes")
    parser.add_argument("--objects", type=int, default=8, help="of each class")
    parser.add_argument("--views", type=int, default=12, help="pictures of each object")
    parser.add_argument("--width", type=int, default=64, help="of the pictures; the height is three quarters")
    parser.add_argument("--steps", type=int, default=300, help="of Adam")
    parser.add_argument("--output", type=Path, default=Path("docs/results/ceilings.json"))
    arguments = parser.parse_args()
    scene = SceneConfig(width=arguments.width, height=arguments.width * 3 // 4)
    found: dict[str, dict[str, float]] = {}
    for category in arguments.only:
        found[category] = {}
        for kind in arguments.kinds:
            overlaps = fitted(category, kind, scene, arguments.objects, arguments.views, arguments.steps)
            found[category][kind] = round(float(np.mean(overlaps)), 3)
            print(f"{category:12s} {kind:24s} IoU {found[category][kind]:.3f}", flush=True)
    results: dict[str, Any] = {
        "machine": machine(),
        "command": shlex.join(["python", "-m", "benchmarks.ceilings", *sys.argv[1:]]),
        "objects": arguments.objects,
        "views": arguments.views,
        "width": scene.width,
        "height": scene.height,
        "steps": arguments.steps,
        "iou": found,
    }
    arguments.output.write_text(json.dumps(results, indent=2) + "\n")
    return 0


def fitted(category: str, kind: str, scene: SceneConfig, objects: int, views: int, steps: int) -> list[float]:
    """The IoU of each object."""
    shapes = [make_shape(category, SEED + number) for number in range(objects)]
    azimuths = -math.pi + (torch.arange(views) + 0.5) * 2 * math.pi / views
    pictures = [
        encode(draw(shape, float(azimuth), 0.0, scene, normals=corner_normals(shape))[0])
        for shape in shapes
        for azimuth in azimuths
    ]
    images = torch.from_numpy(decode_table()[np.stack(pictures).transpose(0, 3, 1, 2)])
    vertices, faces = learnt(KINDS[kind], scene, images, azimuths.repeat(objects), objects, steps)
    return [
        float(iou(occupy(found.double().numpy(), faces).full, fill(shape.vertices, shape.faces).full))
        for found, shape in zip(vertices, shapes, strict=True)
    ]


def learnt(
    kind: ModelConfig, scene: SceneConfig, images: torch.Tensor, azimuths: torch.Tensor, objects: int, steps: int
) -> tuple[torch.Tensor, np.ndarray]:
    """Vertices of each object, and faces, after so many steps; consecutive pictures show one object."""
    torch.manual_seed(0)
    config = replace(kind, latent=objects, hidden=HIDDEN)
    model, loss = Model(config, scene.width, scene.height), LossConfig(kl_cooling_steps=steps / 5)
    geometry, optimiser = fixed_geometry(model, scene, loss), torch.optim.Adam(model.decoder.parameters())
    rates, codes = OptimiserConfig(steps=steps, falling_share=0.3), 3 * torch.eye(objects)
    for step in range(steps):
        for group in optimiser.param_groups:
            group["lr"] = LEARNING_RATE * falling(rates, step)
        vertices = model.decode(codes)
        shown = vertices.repeat_interleave(len(images) // objects, 0)
        screen = project(shown, azimuths, scene.camera, scene.width, scene.height)
        colours = shade(vertex_normals(shown, model.faces), azimuths, scene)
        explained = renderer.log_likelihood(screen[:, None], colours[:, None], images, geometry.topology, math.inf)
        total = -explained.mean()
        if geometry.laplacian is not None:
            displaced = geometry.laplacian @ (vertices - model.decoder.base_vertices)
            weight = weights_at(loss, step, scene.width, scene.height).laplacian
            total = total + weight * displaced.square().sum((1, 2)).mean()
        optimiser.zero_grad()
        total.backward()
        optimiser.step()
    with torch.no_grad():
        return model.decode(codes), model.faces.numpy()


if __name__ == "__main__":
    sys.exit(main())
