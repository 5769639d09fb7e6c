"""Makes the models that ship: for each class, candidates are trained without labels, and the best becomes a bundle.

    WORK/pictures/<class>/<rig>/    train, validation, test: what the models see, and what they are judged on
    WORK/runs/<model>/<candidate>/  the trainings
    OUTPUT/<model>/                 the bundles
    OUTPUT/figures.json, README.md  what each model reaches, and the command that trained it

Candidates are compared on validation pictures; test pictures and real meshes are only looked at afterwards. Each model
is there as soon as its candidates are trained, and the same command goes on where it was interrupted. Everything goes
through the command lines that a user has.
"""

import argparse
import json
import shlex
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from command import run

from trainer.data.shapes.catalogue import CATEGORIES
from trainer.data.writing import write_bytes

PRESET = "demo"
VALIDATION_OBJECTS, TEST_OBJECTS = 200, 400
PAGE = (
    "# The models",
    "",
    "Made by `make models`, and each alone by its command below. IoU at 32³; median azimuth error, and share of",
    "azimuths within 30°, both up to the object's own symmetry. Beside them the guesses that are to be beaten: the",
    "class's mean shape, and the nearest neighbour of the picture. On unseen procedural objects, and on real meshes,",
    "which only serve as a test.",
    "",
)
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
    "chamfer_distance",
    "objects",
    "pictures",
)


@dataclass(frozen=True)
class Model:
    """What ships under a name, and what is tried for it."""

    name: str
    category: str
    rig: str = "colour"
    rotate_lights: bool = False
    parameterisations: tuple[str, ...] = ("subdivision", "ortho-block")
    options: tuple[str, ...] = field(default=())
    """More options of the training."""

    @property
    def light(self) -> str:
        return f"{self.rig}{'-turning' if self.rotate_lights else ''}"


MODELS = (
    *(Model(category, category) for category in CATEGORIES),
    Model("car-varying-light", "car", rotate_lights=True, options=("--model.light", "varying")),
    Model("car-white-light", "car", rig="white"),
)


@dataclass(frozen=True)
class Workshop:
    work: Path
    output: Path
    pictures: int
    steps: int

    def folder(self, model: Model, part: str) -> Path:
        return self.work / "pictures" / model.category / model.light / part

    def run_directory(self, model: Model, parameterisation: str) -> Path:
        return self.work / "runs" / model.name / parameterisation

    def bundle(self, model: Model) -> Path:
        """Those of other lights stand apart: the service takes one model of a category."""
        return (self.output if model.name == model.category else self.output.with_name("models-light")) / model.name


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("models"), help="folder for the bundles")
    parser.add_argument("--work", type=Path, default=Path("out/models"), help="folder for pictures and trainings")
    parser.add_argument("--only", nargs="*", default=[model.name for model in MODELS], help="names of models to make")
    parser.add_argument("--real-meshes", type=Path, default=Path("../shared/meshes"), help="mesh files, if any")
    parser.add_argument("--pictures", type=int, default=4000, help="training pictures, one of each object")
    parser.add_argument("--steps", type=int, default=0, help="training steps; 0 means the preset's")
    parser.add_argument("--workers", type=int, default=2, help="trainings at once, one thread each")
    arguments = parser.parse_args()
    if unknown := set(arguments.only) - {model.name for model in MODELS}:
        parser.error(f"expected names among {', '.join(model.name for model in MODELS)}; found {', '.join(unknown)}")
    models = [model for model in MODELS if model.name in arguments.only]
    workshop = Workshop(arguments.work, arguments.output, arguments.pictures, arguments.steps)
    for model in models:
        render(workshop, model)
    threads = ThreadPoolExecutor(arguments.workers)
    try:
        trainings = {
            threads.submit(train, workshop, model, parameterisation): (model, parameterisation)
            for model in models
            for parameterisation in model.parameterisations
        }
        left = {model.name: len(model.parameterisations) for model in models}
        for training in as_completed(trainings):
            training.result()
            model, parameterisation = trainings[training]
            print(f"trained  {model.name}, {parameterisation}", flush=True)
            left[model.name] -= 1
            if not left[model.name]:
                publish(workshop, model, arguments.real_meshes / model.category)
                write_figures(workshop)
    finally:
        # After a failure or Ctrl-C, those that run save and end, and no other begins.
        threads.shutdown(cancel_futures=True)
    return 0


def render(workshop: Workshop, model: Model) -> None:
    parts = (("train", workshop.pictures), ("validation", VALIDATION_OBJECTS), ("test", TEST_OBJECTS))
    for seed, (part, count) in enumerate(parts):
        lights = ["--rig", model.rig, *(["--rotate-lights"] if model.rotate_lights else [])]
        run("trainer", "render", "--class", model.category, "--seed", seed, "--instances", count,
            "--output", workshop.folder(model, part), *lights)  # fmt: skip


def training_options(model: Model, parameterisation: str) -> list[str]:
    return ["--class", model.category, "--model.parameterisation", parameterisation, *model.options]


def train(workshop: Workshop, model: Model, parameterisation: str) -> None:
    directory = workshop.run_directory(model, parameterisation)
    steps = ["--optimiser.steps", str(workshop.steps)] if workshop.steps else []
    if (directory / "checkpoint.safetensors").exists():
        options = ["--resume", *steps]
    else:
        options = ["--preset", PRESET, *training_options(model, parameterisation), *steps]
    images = workshop.folder(model, "train")
    run("trainer", "train", "--images", images, "--run", directory, "--threads", 1, *options, quiet=True)


def publish(workshop: Workshop, model: Model, real_meshes: Path) -> None:
    """Chooses a model's candidate on validation pictures, judges it, and writes its bundle."""
    validation = workshop.folder(model, "validation")
    found = {
        parameterisation: judge(
            workshop.run_directory(model, parameterisation), "validation", validation, "--images", validation
        )
        for parameterisation in model.parameterisations
    }
    chosen = max(found, key=lambda parameterisation: found[parameterisation]["iou"])
    directory, bundle = workshop.run_directory(model, chosen), workshop.bundle(model)
    figures = judge(directory, "test", validation, "--images", workshop.folder(model, "test"))
    run("exporter", "--checkpoint", directory, "--output", bundle, "--metrics", directory / "test" / "metrics.json",
        "--images", validation)  # fmt: skip
    run("trainer", "sample", "--checkpoint", directory, "--output", directory / "samples.png", quiet=True)
    command = ["python", "-m", "trainer", "train", "--preset", PRESET, *training_options(model, chosen)]
    summary: dict[str, Any] = {
        "command": shlex.join([*command, "--images", "PICTURES", "--run", "RUN"]),
        "parameterisation": chosen,
        "training_seconds": progress(directory)["seconds"],
        "bundle_bytes": sum(file.stat().st_size for file in bundle.iterdir()),
        "validation_iou": {name: one["iou"] for name, one in found.items()},
        "test": {name: figures[name] for name in FIGURES},
    }
    if real_meshes.is_dir():
        real = judge(directory, "real", validation, "--meshes", real_meshes)
        summary["real_meshes"] = {name: real[name] for name in FIGURES}
    write_bytes(workshop.work / "summaries" / f"{model.name}.json", (json.dumps(summary, indent=2) + "\n").encode())


def write_figures(workshop: Workshop) -> None:
    """One page and one JSON file of all models that have been made so far."""
    made = {
        model.name: path for model in MODELS if (path := workshop.work / "summaries" / f"{model.name}.json").exists()
    }
    figures = {name: json.loads(path.read_text()) for name, path in made.items()}
    write_bytes(workshop.output / "figures.json", (json.dumps(figures, indent=2) + "\n").encode())
    titles = ["IoU", "mean", "nearest", "error", "within 30°"]
    columns = ["model", "shape", *titles, *(f"real: {title}" for title in titles), "kB"]
    lines = [*PAGE, f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    for name, one in figures.items():
        real = row_of(one["real_meshes"]) if "real_meshes" in one else ["–"] * 5
        cells = [name, one["parameterisation"], *row_of(one["test"]), *real, f"{one['bundle_bytes'] / 1000:.0f}"]
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "```sh", *(one["command"] for one in figures.values()), "```", ""]
    write_bytes(workshop.output / "README.md", "\n".join(lines).encode())


def row_of(figures: dict[str, Any]) -> list[str]:
    overlaps = [f"{figures[name]:.2f}" for name in ("iou", "mean_shape_iou", "nearest_neighbour_iou")]
    error, accuracy = figures["symmetric_azimuth_error_degrees"], figures["symmetric_azimuth_accuracy"]
    return [*overlaps, f"{error:.1f}°", f"{accuracy:.2f}"]


def judge(directory: Path, name: str, validation: Path, *subjects: object) -> dict[str, Any]:
    """What `trainer evaluate` finds, in the run directory under a name; it is asked again if training went on since."""
    path = directory / name / "metrics.json"
    if not path.exists() or json.loads(path.read_text())["step"] != progress(directory)["step"]:
        run("trainer", "evaluate", "--checkpoint", directory, "--validation", validation, *subjects,
            "--output", path.parent, quiet=True)  # fmt: skip
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def progress(directory: Path) -> dict[str, Any]:
    """A training's last step, and its figures."""
    last: dict[str, Any] = json.loads((directory / "metrics.jsonl").read_text().splitlines()[-1])
    return last


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("interrupted; the same command goes on from here", file=sys.stderr)
        sys.exit(130)
