"""Bundles of a directory, measured one by one into a JSON file, on pictures that no training or validation saw."""

import argparse
import json
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.machine import machine
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.evaluation.subject import Subject

VALIDATION_SEED, TEST_SEED = 1, 2


def add_options(parser: argparse.ArgumentParser, objects: int, views: int, output: Path) -> None:
    """What all such benchmarks ask for, with these defaults."""
    parser.add_argument("--models", type=Path, default=Path("models"), help="a directory of bundles")
    parser.add_argument("--only", nargs="*", help="names of bundles; all, if absent")
    parser.add_argument(
        "--objects", type=int, default=objects, help="procedural objects to judge on, and to validate on"
    )
    parser.add_argument("--real-meshes", type=Path, help="a folder with a folder of mesh files for each class")
    parser.add_argument("--views", type=int, default=views, help="pictures of each real mesh")
    parser.add_argument("--output", type=Path, default=output)


def measure_bundles(
    module: str,
    arguments: argparse.Namespace,
    measured: Callable[[Path, argparse.Namespace], dict[str, Any]],
    **settings: object,
) -> None:
    """Writes the settings, and what is measured of each bundle, with the machine and the command, as soon as it is.

    Models that are in the file and not looked at stay.
    """
    origin = {"machine": machine(), "command": shlex.join(["python", "-m", module, *sys.argv[1:]])}
    output: Path = arguments.output
    results: dict[str, Any] = dict(settings)
    results["models"] = json.loads(output.read_text())["models"] if output.exists() else {}
    for manifest in sorted(arguments.models.glob("*/manifest.json")):
        name = manifest.parent.name
        if arguments.only is None or name in arguments.only:
            results["models"][name] = {**origin, **measured(manifest.parent, arguments)}
            results["models"] = dict(sorted(results["models"].items()))
            output.write_text(json.dumps(results, indent=2) + "\n")
            print(name, json.dumps(results["models"][name]), flush=True)


def rendered(folder: Path, subject: Subject, seed: int, objects: int, views: int = 1) -> Path:
    """A folder in `folder` with so many pictures of each of so many procedural objects of the subject's class."""
    settings = RenderSettings(subject.category, seed=seed)
    render_folder(folder / str(seed), settings, subject.scene, objects, views, 1, False)
    return folder / str(seed)
