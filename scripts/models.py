"""Makes the models that ship: for each class, candidates are trained without labels, and the best becomes a bundle.

    WORK/pictures/<class>/<rig>/    train, validation, test: what the models see, and what they are judged on
    WORK/runs/<model>/<candidate>/  the trainings; candidates that are compared first, in <candidate>-screened; one that
                                    finds the poses that the model is told, in first; and one that finds those that
                                    it does not understand, in second
    OUTPUT/<model>/                 the bundles; beside them pictures of reconstructions and of what is invented
    OUTPUT/figures.json, README.md  what each model reaches, and the commands that made it
    WORK/pictures/rivals/<class>/   what all bundles of OUTPUT are shown, to fit how strictly `auto` judges each

Candidates are trained for a while and compared on validation pictures, and the best is trained anew, to the end; test
pictures and real meshes are only looked at afterwards. Each model is there as soon as its training has ended, and the
same command goes on where it was interrupted. Everything goes through the command lines that a user has.
"""

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from command import run
from invented_sheets import write_invented
from models_page import page
from shipped import MODELS, Model

from trainer.commands.train import TrainCommand
from trainer.data.writing import write_bytes
from trainer.training.checkpoint import FILE_NAME as CHECKPOINT
from trainer.training.checkpoint import load_checkpoint

SCREENING_STEPS = 500
VALIDATION_OBJECTS, TEST_OBJECTS, RIVAL_OBJECTS = 200, 400, 40
VALIDATION_SEED = 1
PARAMETERISATIONS = ("subdivision", "ortho-block", "full-block")
FIGURES = (
    "iou",
    "iou_interval",
    "mean_shape_iou",
    "nearest_neighbour_iou",
    "azimuth_error_degrees",
    "azimuth_accuracy",
    "symmetric_azimuth_error_degrees",
    "symmetric_azimuth_accuracy",
    "flipped",
    "light_error_degrees",
    "azimuth_calibration_error",
    "untempered_calibration_error",
    "azimuth_temperature",
    "chamfer_distance",
    "inside_out",
    "objects",
    "pictures",
)


@dataclass(frozen=True)
class Workshop:
    work: Path
    output: Path
    real_meshes: Path
    pictures: int
    screening_steps: int
    steps: int | None
    """Instead of each model's own."""

    def pictures_of(self, model: Model, part: str) -> Path:
        return self.work / "pictures" / model.category / model.light / part

    def steps_of(self, model: Model) -> int:
        return self.steps or model.steps

    def run_directory(self, model: Model, candidate: str) -> Path:
        return self.work / "runs" / model.name / candidate

    def screening_directory(self, model: Model, candidate: str) -> Path:
        """Apart: learning rates may fall towards the last step, and what has been screened cannot go on as if not."""
        return self.run_directory(model, f"{candidate}-screened")

    def bundle(self, model: Model) -> Path:
        """Those of other lights stand apart: the service takes one model of a category."""
        usual = model.name == model.category
        return (self.output if usual else self.output.with_name(f"{self.output.name}-light")) / model.name


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("models"), help="folder for the bundles")
    parser.add_argument("--work", type=Path, default=Path("out/models"), help="folder for pictures and trainings")
    parser.add_argument("--only", nargs="*", default=[model.name for model in MODELS], help="names of models to make")
    parser.add_argument("--candidates", nargs="*", choices=PARAMETERISATIONS, help="by default each model's own")
    parser.add_argument("--real-meshes", type=Path, default=Path("../shared/meshes"), help="mesh files, if any")
    parser.add_argument("--pictures", type=int, default=4000, help="training pictures, one of each object")
    parser.add_argument("--screening-steps", type=int, default=SCREENING_STEPS, help="training steps of each candidate")
    parser.add_argument("--steps", type=int, help="training steps of the best; by default each model's own")
    parser.add_argument("--workers", type=int, default=2, help="models made at once, one thread each")
    arguments = parser.parse_args()
    if unknown := set(arguments.only) - {model.name for model in MODELS}:
        parser.error(f"expected names among {', '.join(model.name for model in MODELS)}; found {', '.join(unknown)}")
    models = [model for model in MODELS if model.name in arguments.only]
    if arguments.candidates:
        models = [replace(model, candidates=tuple(arguments.candidates)) for model in models]
    workshop = Workshop(
        arguments.work,
        arguments.output,
        arguments.real_meshes,
        arguments.pictures,
        arguments.screening_steps,
        arguments.steps,
    )
    threads = ThreadPoolExecutor(arguments.workers)
    try:
        for made in as_completed([threads.submit(make, workshop, model) for model in models]):
            name, figures = made.result()
            write_figures(workshop.output, name, figures)
            print(f"made     {name}: {figures['parameterisation']}, IoU {figures['test']['iou']:.2f}", flush=True)
    finally:
        # After a failure or Ctrl-C, those that run save and end, and no other begins.
        threads.shutdown(cancel_futures=True)
    fit_rivals(workshop)
    return 0


def make(workshop: Workshop, model: Model) -> tuple[str, dict[str, Any]]:
    """A model's name and figures; its bundle is written."""
    render(workshop, model)
    found: dict[str, float] = {}
    if len(model.candidates) > 1:
        for candidate in model.candidates:
            steps = min(workshop.screening_steps, workshop.steps_of(model))
            train(workshop, model, candidate, steps, workshop.screening_directory(model, candidate), 0.0)
            found[candidate] = screened(workshop, model, candidate)
    chosen = max(found, key=lambda candidate: found[candidate], default=model.candidates[0])
    told = find_poses(workshop, model)
    train(workshop, model, chosen, workshop.steps_of(model), workshop.run_directory(model, chosen), told=told)
    trainings = trainings_of(workshop, model, chosen)
    figures = publish(workshop, model, chosen, workshop.run_directory(model, chosen), trainings)
    return model.name, {**figures, "screened_iou": found}


def render(workshop: Workshop, model: Model) -> None:
    parts = (("train", workshop.pictures), ("validation", VALIDATION_OBJECTS), ("test", TEST_OBJECTS))
    for seed, (part, count) in enumerate(parts):
        run("trainer", "render", *render_options(model, seed, count), "--output", workshop.pictures_of(model, part),
            quiet=True)  # fmt: skip


def render_options(model: Model, seed: int, count: int) -> list[str]:
    lights = ["--rig", model.rig, *(["--rotate-lights"] if model.rotate_lights else [])]
    return ["--class", model.category, "--seed", str(seed), "--instances", str(count), *lights]


def find_poses(workshop: Workshop, model: Model) -> list[object]:
    """The options that tell a model the poses that its first training, which is done here, finds, and the second one
    where there is one; none without."""
    if model.first is None:
        return []
    first = workshop.run_directory(model, "first")
    train(workshop, model.first, model.first.candidates[0], workshop.steps_of(model.first), first)
    if model.second is None:
        return ["--poses-of", first]
    second, steps = workshop.run_directory(model, "second"), workshop.steps_of(model.second)
    train(workshop, model.second, model.second.candidates[0], steps, second, told=["--unknown-to", first])
    return ["--poses-of", first, "--unknown-poses-of", second]


def training_options(model: Model, candidate: str) -> list[str]:
    return ["--class", model.category, "--model.parameterisation", candidate, *model.options]


def train(
    workshop: Workshop,
    model: Model,
    candidate: str,
    steps: int,
    directory: Path,
    reframing: float | None = None,
    told: Sequence[object] = (),
) -> None:
    """Trains to that step, from where it was, and reframes for that share of it, or for the model's."""
    if reframing is None:
        reframing = model.reframing_share
    if (directory / CHECKPOINT).exists():
        if progress(directory)["step"] >= steps + round(reframing * steps):
            return
        options: list[object] = ["--resume"]
    else:
        options = ["--preset", model.preset, *training_options(model, candidate), *told]
    images = workshop.pictures_of(model, "train")
    run("trainer", "train", "--images", images, "--run", directory, "--threads", 1, "--optimiser.steps", steps,
        "--starts", 1, "--reframing-share", reframing, *options, quiet=True)  # fmt: skip


def screened(workshop: Workshop, model: Model, candidate: str) -> float:
    """A candidate's IoU on validation pictures after the first steps."""
    directory, validation = workshop.screening_directory(model, candidate), workshop.pictures_of(model, "validation")
    if not (directory / "screening" / "metrics.json").exists():
        judge(directory, "screening", validation, "--images", validation)
    figures = json.loads((directory / "screening" / "metrics.json").read_text())
    return float(figures["iou"])


def publish(
    workshop: Workshop, model: Model, chosen: str, directory: Path, trainings: list[dict[str, Any]]
) -> dict[str, Any]:
    """Judges the model of a run directory and writes its bundle."""
    bundle = workshop.bundle(model)
    validation = workshop.pictures_of(model, "validation")
    test = judge(directory, "test", validation, "--images", workshop.pictures_of(model, "test"))
    run("exporter", "--checkpoint", directory, "--output", bundle, "--metrics", directory / "test" / "metrics.json",
        "--images", validation, "--samples-from", workshop.pictures_of(model, "train"),
        "--precision", model.precision, quiet=True)  # fmt: skip
    write_bytes(bundle.with_name(f"{model.name}.png"), (directory / "test" / "sheet.png").read_bytes())
    write_invented(bundle, *(bundle.with_name(f"{model.name}-{sheet}.png") for sheet in ("samples", "between")))
    pictures = render_options(model, 0, workshop.pictures)
    figures: dict[str, Any] = {
        "pictures": shlex.join(["python", "-m", "trainer", "render", *pictures, "--output", "PICTURES"]),
        "trainings": trainings,
        "parameterisation": chosen,
        "bundle_bytes": bytes_of(bundle),
        "test": {name: test[name] for name in FIGURES},
    }
    if (real_meshes := workshop.real_meshes / model.category).is_dir():
        real = judge(directory, "real", validation, "--meshes", real_meshes)
        figures["real_meshes"] = {name: real[name] for name in FIGURES}
    return figures


def trainings_of(workshop: Workshop, model: Model, chosen: str) -> list[dict[str, Any]]:
    """Command, seconds and place of the training, after those of the ones that found its poses, if any did."""
    trainings = []
    if model.first:
        command = command_of(workshop, model.first, model.first.candidates[0], "--run", "FIRST")
        trainings.append((command, workshop.run_directory(model, "first")))
    if model.second:
        command = command_of(
            workshop, model.second, model.second.candidates[0], "--unknown-to", "FIRST", "--run", "SECOND"
        )
        trainings.append((command, workshop.run_directory(model, "second")))
    told = ["--poses-of", "FIRST"] if model.first else []
    told += ["--unknown-poses-of", "SECOND"] if model.second else []
    command = command_of(workshop, model, chosen, *told, "--run", "RUN")
    trainings.append((command, workshop.run_directory(model, chosen)))
    return [{"command": one, "seconds": progress(run)["seconds"], "on": place_of(run)} for one, run in trainings]


def place_of(directory: Path) -> str:
    """Where a training ran, which its checkpoint tells; before checkpoints did, it is taken for a core."""
    return "GPU" if load_checkpoint(directory).run.get("device") == "cuda" else "core"


def command_of(workshop: Workshop, model: Model, candidate: str, *more: str) -> str:
    """What trains a model, as somebody would type it."""
    steps = str(workshop.steps_of(model))
    options = ["--preset", model.preset, "--optimiser.steps", steps, *training_options(model, candidate)]
    if model.reframing_share != TrainCommand.reframing_share:
        more = ("--reframing-share", f"{model.reframing_share:g}", *more)
    return shlex.join(["python", "-m", "trainer", "train", "--starts", "1", *options, "--images", "PICTURES", *more])


def judge(directory: Path, name: str, validation: Path, *subjects: object) -> dict[str, Any]:
    """What `trainer evaluate` finds, in the run directory under a name; it is asked again if that trained since."""
    path = directory / name / "metrics.json"
    if not path.exists() or path.stat().st_mtime <= (directory / CHECKPOINT).stat().st_mtime:
        run("trainer", "evaluate", "--checkpoint", directory, "--validation", validation, *subjects,
            "--output", path.parent, quiet=True)  # fmt: skip
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def progress(directory: Path) -> dict[str, Any]:
    """A training's last step, and its figures."""
    last: dict[str, Any] = json.loads((directory / "metrics.jsonl").read_text().splitlines()[-1])
    return last


def fit_rivals(workshop: Workshop) -> None:
    """Writes into all bundles of the service, where there are several, how strictly `auto` judges each."""
    bundles = [manifest.parent.name for manifest in sorted(workshop.output.glob("*/manifest.json"))]
    if len(bundles) < 2:
        return
    pictures = workshop.work / "pictures" / "rivals"
    for category in bundles:
        run("trainer", "render", "--class", category, "--seed", VALIDATION_SEED, "--instances", RIVAL_OBJECTS,
            "--output", pictures / category, quiet=True)  # fmt: skip
    run("exporter.rivals", "--models", workshop.output, "--images", pictures, quiet=True)
    known = json.loads((workshop.output / "figures.json").read_text())
    for name in known.keys() & set(bundles):
        write_figures(workshop.output, name, {**known[name], "bundle_bytes": bytes_of(workshop.output / name)})


def bytes_of(bundle: Path) -> int:
    return sum(file.stat().st_size for file in bundle.iterdir())


def write_figures(output: Path, name: str, figures: dict[str, Any]) -> None:
    """One page and one JSON file of all models that are there."""
    path = output / "figures.json"
    known = {**(json.loads(path.read_text()) if path.exists() else {}), name: figures}
    known = {model.name: known[model.name] for model in MODELS if model.name in known}
    write_bytes(path, (json.dumps(known, indent=2) + "\n").encode())
    elsewhere = {model: f"../{output.name}-light/" for model in known if not (output / model).is_dir()}
    write_bytes(output / "README.md", page(known, elsewhere).encode())


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("interrupted; the same command goes on from here", file=sys.stderr)
        sys.exit(130)
