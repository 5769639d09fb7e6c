"""What holds shapes back: a decoder learnt with the poses given and a free shape code for each object, no encoder.

    python -m benchmarks.free_codes --output docs/results/free-codes.json

`benchmarks.ceilings` fits a few objects that are seen from all sides. Here there are as many as a training has, from
one side each or from several; their codes are parameters, and neither pose nor encoder can be at fault. Settings differ
in one thing each. The IoU is of objects that were trained on: of 48, in the frame in which the poses are given.
"""

import argparse
import json
import math
import shlex
import sys
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
import torch
from torch import nn

from benchmarks.ceilings import SEED
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

JUDGED, BATCH = 48, 64
SCENE = SceneConfig(width=64, height=48)


@dataclass(frozen=True)
class Setting:
    """One training; the paper's model, but for the rates."""

    objects: int = 4000
    views: int = 1
    steps: int = 2500
    model: ModelConfig = field(default_factory=ModelConfig)
    decoder_rate: float = 4e-3
    code_rate: float = 0.03
    code_noise: float = 0.0
    """Standard deviation of what is added to a code whenever it is decoded."""


FREE = Setting()
SETTINGS = {
    "as it is": FREE,
    "1,000 objects, 12 views": replace(FREE, objects=1000, views=12),
    "noise 0.3": replace(FREE, code_noise=0.3),
    "hidden 128": replace(FREE, model=ModelConfig(hidden=128)),
    "mirror": replace(FREE, model=ModelConfig(symmetry="mirror")),
    "mirror, hidden 128": replace(FREE, model=ModelConfig(symmetry="mirror", hidden=128)),
    "mirror, hidden 512": replace(FREE, model=ModelConfig(symmetry="mirror", hidden=512)),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--class", dest="category", default="chair", choices=list(CATEGORIES))
    parser.add_argument("--only", nargs="*", default=list(SETTINGS), choices=SETTINGS, help="settings")
    parser.add_argument("--output", type=Path, default=Path("docs/results/free-codes.json"))
    arguments = parser.parse_args()
    found = {}
    for name in arguments.only:
        started = time.perf_counter()
        missing, overlap = learnt(arguments.category, SETTINGS[name])
        seconds = round(time.perf_counter() - started)
        found[name] = {"iou": round(overlap, 3), "missing_nats": round(missing, 1), "seconds": seconds}
        print(f"{name:28s} IoU {overlap:.3f}, pictures lack {missing:.0f} nats, {seconds} s", flush=True)
    results = {
        "machine": machine(),
        "command": shlex.join(["python", "-m", "benchmarks.free_codes", *sys.argv[1:]]),
        "class": arguments.category,
        "settings": {name: asdict(SETTINGS[name]) for name in arguments.only},
        "found": found,
    }
    arguments.output.write_text(json.dumps(results, indent=2) + "\n")
    return 0


def learnt(category: str, setting: Setting) -> tuple[float, float]:
    """What pictures lack in the end, in nats, and the IoU of the first objects."""
    torch.manual_seed(0)
    shapes = [make_shape(category, SEED + number) for number in range(setting.objects)]
    azimuths = 2 * math.pi * torch.rand(setting.objects, setting.views) - math.pi
    pictures = [
        encode(draw(shape, float(azimuth), 0.0, SCENE, normals=corner_normals(shape))[0])
        for shape, turned in zip(shapes, azimuths, strict=True)
        for azimuth in turned
    ]
    images = torch.from_numpy(decode_table()[np.stack(pictures).transpose(0, 3, 1, 2)])
    model = Model(setting.model, SCENE.width, SCENE.height)
    codes = nn.Parameter(torch.randn(setting.objects, setting.model.latent))
    loss = LossConfig(kl_cooling_steps=setting.steps / 5)
    geometry, rates = fixed_geometry(model, SCENE, loss), OptimiserConfig(steps=setting.steps, falling_share=0.3)
    optimiser = torch.optim.Adam([{"params": list(model.decoder.parameters())}, {"params": [codes]}])
    missing = []
    for step in range(setting.steps):
        for group, rate in zip(optimiser.param_groups, (setting.decoder_rate, setting.code_rate), strict=True):
            group["lr"] = rate * falling(rates, step)
        shown = torch.randint(len(images), (BATCH,))
        code = codes[shown // setting.views]
        vertices = model.decode(code + setting.code_noise * torch.randn_like(code))
        azimuth = azimuths.flatten()[shown]
        screen = project(vertices, azimuth, SCENE.camera, SCENE.width, SCENE.height)
        colours = shade(vertex_normals(vertices, model.faces), azimuth, SCENE)
        explained = renderer.log_likelihood(
            screen[:, None], colours[:, None], images[shown], geometry.topology, math.inf
        )
        displaced = geometry.laplacian @ (vertices - model.decoder.base_vertices)
        weight = weights_at(loss, step, SCENE.width, SCENE.height).laplacian
        optimiser.zero_grad()
        (-explained.mean() + weight * displaced.square().sum((1, 2)).mean()).backward()
        optimiser.step()
        missing.append(-float(explained.detach().mean()))
    with torch.no_grad():
        judged = model.decode(codes[:JUDGED]).double().numpy()
    faces = model.faces.numpy()
    overlaps = [
        float(iou(occupy(vertices, faces).full, fill(shape.vertices, shape.faces).full))
        for vertices, shape in zip(judged, shapes, strict=False)
    ]
    return float(np.mean(missing[-20:])), float(np.mean(overlaps))


if __name__ == "__main__":
    sys.exit(main())
