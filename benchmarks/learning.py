"""Accuracy over training time: the paper's objective beside ours, on the same pictures.

    python -m benchmarks.learning --classes car chair --output docs/results/learning.json

Both train from the same seed, on one thread each, with as many pixels and pictures a step; ours as
benchmarks/brief.toml has it, the paper's without zoom, faster decoder, falling rates and smoothing. A training halts at
some steps, is judged on objects that it never saw, and goes on. Time is that of the core, without what judging took.
Writes a chart, too.
"""

import argparse
import json
import shlex
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib

matplotlib.use("agg")

from matplotlib import pyplot as plt

from benchmarks.machine import machine
from trainer.config import TrainConfig
from trainer.data.images import load_image_folder
from trainer.data.shapes.catalogue import CATEGORIES
from trainer.evaluation.pictures import from_folder, validation_from
from trainer.evaluation.protocol import judge
from trainer.evaluation.report import as_json
from trainer.evaluation.subject import from_checkpoint
from trainer.presets import load_preset
from trainer.training.intervals import Intervals
from trainer.training.loop import train
from trainer.training.threads import limit_threads

OURS, PAPER = "ours", "the paper's"
MARKS = {OURS: (15, 30, 60, 100, 150, 200, 300), PAPER: (30, 100, 200, 400, 600)}
"""Steps after which a training is judged."""
FIGURES = ("iou", "azimuth_error_degrees", "azimuth_accuracy", "flipped", "chamfer_distance")
COLOURS = {OURS: "#0b6e4f", PAPER: "#c1121f"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--classes", nargs="+", default=["car", "chair"], choices=list(CATEGORIES))
    parser.add_argument("--output", type=Path, default=Path("docs/results/learning.json"))
    parser.add_argument("--chart", type=Path, default=Path("docs/images/learning.png"))
    arguments = parser.parse_args()
    limit_threads(1)
    found: dict[str, Any] = {}
    with TemporaryDirectory() as folder:
        for category in arguments.classes:
            pictures = rendered(category, Path(folder) / category)
            for name in MARKS:
                # What is compiled at first is not the training's.
                curve(name, category, pictures, (2,), f"{name}, compiled")
            curves = {name: curve(name, category, pictures, marks, name) for name, marks in MARKS.items()}
            found[category] = {"curves": curves, "sooner": sooner(curves)}
    results = {
        "machine": machine(),
        "command": shlex.join(["python", "-m", "benchmarks.learning", *sys.argv[1:]]),
        "classes": found,
    }
    arguments.output.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
    write_chart(found, arguments.chart)
    return 0


def rendered(category: str, folder: Path) -> Path:
    """Pictures to train on, to align the frame by, and to judge on: of other objects each."""
    for seed, (part, count) in enumerate((("train", 4000), ("validation", 100), ("test", 200))):
        options = ["--class", category, "--seed", str(seed), "--instances", str(count), "--output", str(folder / part)]
        subprocess.run([sys.executable, "-m", "trainer", "render", *options], check=True, stdout=subprocess.DEVNULL)
    return folder


def recipe(name: str) -> TrainConfig:
    brief = load_preset(str(Path(__file__).with_name("brief.toml")))
    if name == OURS:
        return brief
    optimiser = replace(brief.optimiser, steps=MARKS[PAPER][-1], decoder_factor=1.0, falling_share=0.0)
    return replace(brief, zoom=1.0, loss=load_preset("paper-small").loss, optimiser=optimiser)


def curve(name: str, category: str, pictures: Path, marks: Sequence[int], run: str) -> list[dict[str, float]]:
    """Step, core seconds and figures at each mark of a training, in a folder of its own."""
    config, points = recipe(name), []
    images = load_image_folder(pictures / "train", config.width, config.height, zoom=config.zoom)
    known, unseen = None, None
    for number, step in enumerate(marks):
        last = train(config, images, category, pictures / run, Intervals(), number > 0, _to_nobody, {}, until=step)
        subject = from_checkpoint(last)
        known = known or validation_from(pictures / "validation", subject.scene)
        unseen = unseen or from_folder(pictures / "test", subject.scene)
        judged = as_json(judge(subject, unseen, known).report)
        point = {"step": step, "core_seconds": last.run["core_seconds"]} | {key: judged[key] for key in FIGURES}
        points.append(point)
        print(f"{category}, {name}: {point}", flush=True)
    return points


def sooner(curves: dict[str, list[dict[str, float]]]) -> dict[str, float] | None:
    """How many times as long the paper's training took as ours, until ours had reached the best IoU and the best share
    of right azimuths that the paper's ever had; None where it did not."""
    goals = {key: max(point[key] for point in curves[PAPER]) for key in ("iou", "azimuth_accuracy")}
    for point in curves[OURS]:
        if all(point[key] >= goal for key, goal in goals.items()):
            whole, ours = curves[PAPER][-1]["core_seconds"], point["core_seconds"]
            return {"step": point["step"], "core_seconds": ours, "times": round(whole / ours, 1)}
    return None


def write_chart(found: dict[str, Any], file: Path) -> None:
    """Both figures of each class over time."""
    titles = {"iou": "IoU at 32³", "azimuth_accuracy": "azimuths within 30°"}
    figure, grid = plt.subplots(
        len(titles), len(found), figsize=(5.2 * len(found), 6.4), squeeze=False, layout="constrained", sharex="col"
    )
    for column, (category, classed) in enumerate(found.items()):
        for axes, (key, title) in zip(grid[:, column], titles.items(), strict=True):
            for name, points in classed["curves"].items():
                seconds, values = ([point[one] for point in points] for one in ("core_seconds", key))
                axes.plot(seconds, values, "o-", color=COLOURS[name], label=name)
            axes.set_xscale("log")
            axes.set_ylabel(title)
            axes.grid(alpha=0.2)
        told = classed["sooner"]
        message = f"ours is there {told['times']:.0f} times as soon" if told else "ours does not reach the paper's"
        grid[0, column].set_title(f"{category}: {message}", loc="left", fontsize=11)
        grid[-1, column].set_xlabel("training, seconds of one core")
    grid[0, 0].legend()
    figure.savefig(file, dpi=110, metadata={"Software": None})
    plt.close(figure)


def _to_nobody(step: int, figures: dict[str, float]) -> None:
    """The curve has the figures."""


if __name__ == "__main__":
    sys.exit(main())
