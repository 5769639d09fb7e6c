"""Which category `auto` names: all bundles of a directory, asked together about objects of each class.

    python -m benchmarks.automatic --models models --real-meshes DIR

Each object is drawn once in the frame that models are trained in, and once before white, with margins, so that it has
to be cut out; procedural objects that no training or validation saw, and real meshes, if any. Writes a JSON file with
the machine and, for each source and kind of picture, what was answered, how sure that was, and the milliseconds of an
answer on one core.
"""

import argparse
import io
import json
import math
import shlex
import statistics
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.machine import machine
from imaging.srgb import encode
from service.bundle import read_bundle
from service.errors import ImageError
from service.inference import Engine, load_engine
from service.reconstruction import reconstruct
from trainer.config import SceneConfig
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.picture import draw
from trainer.data.plan import shape_seed
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh

TEST_SEED = 2
SCENE = SceneConfig(width=256, height=192)
MARGINS = 32
MOST_PIXELS = 10**6


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=Path, default=Path("models"), help="a directory of bundles")
    parser.add_argument("--objects", type=int, default=20, help="procedural objects of each class")
    parser.add_argument("--real-meshes", type=Path, help="a folder with a folder of mesh files for each class")
    parser.add_argument("--views", type=int, default=2, help="pictures of each real mesh")
    parser.add_argument("--output", type=Path, default=Path("docs/results/auto.json"))
    arguments = parser.parse_args()
    engines = [load_engine(read_bundle(path.parent)) for path in sorted(arguments.models.glob("*/manifest.json"))]
    results: dict[str, Any] = {
        "machine": machine(),
        "command": shlex.join(["python", "-m", "benchmarks.automatic", *sys.argv[1:]]),
    }
    for source in ("procedural", "real meshes") if arguments.real_meshes else ("procedural",):
        results[source] = {}
        for kind in ("framed", "cut out"):
            results[source][kind] = found = asked(engines, arguments, source == "procedural", kind)
            print(source, kind, json.dumps(found), flush=True)
            arguments.output.write_text(json.dumps(results, indent=1) + "\n")
    return 0


def asked(engines: Sequence[Engine], arguments: argparse.Namespace, procedural: bool, kind: str) -> dict[str, Any]:
    """What was answered about each class, and the shares of right and refused answers."""
    answers: defaultdict[str, Counter[str]] = defaultdict(Counter)
    sure, milliseconds = [], []
    for engine in engines:
        category = engine.manifest.category
        for mesh, azimuth in _objects(category, arguments, procedural):
            began = perf_counter()
            try:
                report = reconstruct(engines, [photograph(mesh, azimuth, kind)], MOST_PIXELS).report
            except ImageError:
                answers[category]["422"] += 1
                continue
            milliseconds.append(1000 * (perf_counter() - began))
            answers[category][report.category] += 1
            sure.append((report.category_probabilities or {report.category: 1.0})[report.category])
    pictures = sum(sum(counted.values()) for counted in answers.values())
    refused = sum(counted["422"] for counted in answers.values())
    return {
        "pictures": pictures,
        "right": round(sum(counted[category] for category, counted in answers.items()) / pictures, 3),
        "refused": round(refused / pictures, 3),
        "mean_probability": round(statistics.mean(sure), 3),
        "milliseconds": round(statistics.median(milliseconds), 1),
        "answers": {category: dict(counted.most_common()) for category, counted in sorted(answers.items())},
    }


def _objects(category: str, arguments: argparse.Namespace, procedural: bool) -> Iterator[tuple[Mesh, float]]:
    """Objects of a class, each with an azimuth."""
    if procedural:
        for index in range(arguments.objects):
            yield make_shape(category, shape_seed(TEST_SEED, index)), _azimuth(index)
        return
    folder: Path = arguments.real_meshes / category
    if folder.is_dir():
        for number, file in enumerate(mesh_files(folder)):
            mesh = load_mesh(file)
            for view in range(arguments.views):
                yield mesh, _azimuth(number * arguments.views + view)


def _azimuth(number: int) -> float:
    """Spread evenly over the circle, the same for every class."""
    return 2 * math.pi * (0.618034 * number % 1)


def photograph(mesh: Mesh, azimuth: float, kind: str) -> bytes:
    """A PNG file of an object in its frame, or before white."""
    colour, alpha = draw(mesh, azimuth, 0.0, SCENE, 2)
    if kind == "cut out":
        padding = (MARGINS, MARGINS), (MARGINS, MARGINS)
        colour = np.pad(colour + (1 - alpha)[..., None], (*padding, (0, 0)), constant_values=1.0)
    buffer = io.BytesIO()
    Image.fromarray(encode(colour)).save(buffer, "PNG")
    return buffer.getvalue()


if __name__ == "__main__":
    sys.exit(main())
