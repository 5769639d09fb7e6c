"""Teaches the encoders of bundles their last phase anew, judges them, and writes them again; shapes stay as they are.

    python scripts/reteach.py --models models --work out/reteach --only car chair

For bundles that were made before that phase knew what it knows today (`trainer/training/reframing.py`), where training
them anew would take hours. Pictures are those that they were trained on, drawn again. Each model is there as soon as it
has ended, and the same command goes on where it was interrupted. `auto` is not fitted: `python -m exporter.rivals` is.
"""

import argparse
import json
import shlex
import sys
from pathlib import Path
from typing import Any, Final

from command import run
from shipped import MODELS, Model

from models import CHECKPOINT, SCREENING_STEPS, Workshop, progress, publish, render, write_figures
from trainer.training.checkpoint import load_checkpoint

STEPS: Final = 2250
"""Of the phase: what it has in a training of 4500 steps."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=Path, default=Path("models"), help="folder of the bundles, figures and page")
    parser.add_argument("--work", type=Path, default=Path("out/reteach"), help="folder for pictures and runs")
    parser.add_argument("--only", nargs="*", default=[model.name for model in MODELS], help="names of models")
    parser.add_argument("--real-meshes", type=Path, default=Path("../shared/meshes"), help="mesh files, if any")
    parser.add_argument("--pictures", type=int, default=4000, help="training pictures, one of each object")
    arguments = parser.parse_args()
    if unknown := set(arguments.only) - {model.name for model in MODELS}:
        parser.error(f"expected names among {', '.join(model.name for model in MODELS)}; found {', '.join(unknown)}")
    workshop = Workshop(
        arguments.work, arguments.models, arguments.real_meshes, arguments.pictures, SCREENING_STEPS, None
    )
    for model in MODELS:
        if model.name in arguments.only:
            figures = reteach(workshop, model)
            write_figures(workshop.output, model.name, figures)
            print(f"taught   {model.name}: IoU {figures['test']['iou']:.2f}", flush=True)
    return 0


def reteach(workshop: Workshop, model: Model) -> dict[str, Any]:
    """A model's figures; its bundle is written anew."""
    render(workshop, model)
    before = json.loads((workshop.output / "figures.json").read_text())[model.name]
    directory, images = workshop.run_directory(model, "again"), workshop.pictures_of(model, "train")
    if not (directory / CHECKPOINT).exists():
        bundle = workshop.bundle(model)
        run("exporter.restoring", "--bundle", bundle, "--images", images, "--run", directory, quiet=True)
    share = STEPS / model.steps
    run("trainer", "train", "--resume", "--run", directory, "--images", images, "--threads", 1,
        "--reframing-share", share, quiet=True)  # fmt: skip
    restoring = ["python", "-m", "exporter.restoring", "--bundle", "BUNDLE", "--images", "PICTURES", "--run", "AGAIN"]
    training = ["python", "-m", "trainer", "train", "--resume", "--run", "AGAIN", "--images", "PICTURES"]
    commands = shlex.join(restoring), shlex.join([*training, "--reframing-share", f"{share:g}"])
    trainings = [training for training in before["trainings"] if "--run AGAIN" not in training["command"]]
    seconds = round(progress(directory)["seconds"] - load_checkpoint(directory).run["restored_from"]["seconds"], 2)
    trainings.append({"command": " && ".join(commands), "seconds": seconds, "on": "core"})
    figures = publish(workshop, model, before["parameterisation"], directory, trainings)
    return {**before, **figures}


if __name__ == "__main__":
    sys.exit(main())
