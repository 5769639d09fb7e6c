"""What tells poses apart: a training's E-step on pictures of known pose, at the bins' centres and at the fine angle.

    python -m benchmarks.evidence --runs RUN … --pictures FOLDER … --output docs/results/evidence.json

A folder of pictures, which `trainer render` wrote, belongs to each run. Of the encoder's own word, and of the most
probable bin by the likelihood alone, the share of azimuths within 30° and of those that are flipped: with shapes of the
picture's own code or of code 0, and with the bins' centres or the encoder's fine angle. The canonical frame is fitted
on the encoder's word, on the same pictures.
"""

import argparse
import json
import shlex
import sys
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from benchmarks.machine import machine
from rasteriser.pictures import HARD
from trainer.evaluation.metrics import FLIPPED_BEYOND, accuracy, azimuth_error, fit_azimuth_offset
from trainer.evaluation.pictures import linear_batches, validation_from
from trainer.model.posterior import bin_centres
from trainer.rendering import renderer
from trainer.rendering.cpu import topology_of
from trainer.training.checkpoint import load_checkpoint
from trainer.training.moving import moved_onto
from trainer.training.views import bin_views


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=Path, nargs="+", required=True, help="run directories, of fixed light")
    parser.add_argument("--pictures", type=Path, nargs="+", required=True, help="a folder for each run")
    parser.add_argument("--output", type=Path, default=Path("docs/results/evidence.json"))
    arguments = parser.parse_args()
    found = {}
    for run, folder in zip(arguments.runs, arguments.pictures, strict=True):
        found[run.name] = told_apart(run, folder)
        for name, figures in found[run.name].items():
            right, flipped = figures["azimuth_accuracy"], figures["flipped"]
            print(f"{run.name:20} {name:24} within 30° {right:.3f}, flipped {flipped:.3f}")
    text = {
        "command": shlex.join(["python", "-m", "benchmarks.evidence", *sys.argv[1:]]),
        "machine": machine(),
        "runs": found,
    }
    arguments.output.write_text(json.dumps(text, indent=1, ensure_ascii=False) + "\n")
    return 0


@torch.no_grad()
def told_apart(run: Path, folder: Path) -> dict[str, dict[str, float]]:
    """Both shares, of the encoder's word and of each kind of evidence."""
    checkpoint = load_checkpoint(run)
    model, scene = checkpoint.model.eval(), checkpoint.scene
    known = validation_from(folder, scene)
    images = torch.cat(list(linear_batches(known.codes)))
    posterior, topology = model.encode(images), topology_of(model.faces)
    fine = posterior.azimuth_fine_mean
    centres = bin_centres(model.config.azimuth_bins, fine)
    own = posterior.azimuth_logits.argmax(1)
    offset = fit_azimuth_offset((centres[own] + fine).numpy(), known.azimuths)

    def figures(bins: Tensor) -> dict[str, float]:
        errors = azimuth_error((centres[bins] + fine).numpy() + offset, known.azimuths)
        return {"azimuth_accuracy": accuracy(errors), "flipped": float(np.mean(errors > FLIPPED_BEYOND))}

    def likelihood(code: Float[Tensor, "B Z"], angle: Float[Tensor, "B"]) -> Float[Tensor, "B R"]:
        views = bin_views(model, scene, model.decode(code), angle, None)
        if checkpoint.config.loss.moved_steps:
            views = moved_onto(views, images, model.faces)
        return renderer.log_likelihood(*views, images, topology, HARD)

    found = {"encoder": figures(own)}
    for code, shape in (("own code", posterior.shape_mean), ("code 0", torch.zeros_like(posterior.shape_mean))):
        for place, angle in (("centres", torch.zeros_like(fine)), ("fine angle", fine)):
            found[f"{code}, {place}"] = figures(likelihood(shape, angle).argmax(1))
    return found


if __name__ == "__main__":
    sys.exit(main())
