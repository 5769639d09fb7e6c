"""What every shipped bundle carries: what could be left out of it, and what lower precision costs and saves.

`python -m benchmarks.parsimony` writes docs/results/parsimony.json and the tables of docs/parsimony.md. Each model is
looked at on held-out pictures and on samples, converted by the exporter, timed on one core beside its other precisions,
and judged on pictures that neither training nor conversion has seen.
"""

import datetime
import json
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
import tyro
from jaxtyping import Float32
from numpy import ndarray

from benchmarks.machine import machine, versions
from benchmarks.parsimony_page import PAGE, write_tables
from exporter.held_out import read_pictures
from exporter.precision import PrecisionName
from exporter.repacking import convertible_bundle, repack
from exporter.slimming import SAMPLES, blocks_in_use, codes_alive, moving_numbers
from service.bundle import read_bundle
from service.exposure import used_blocks
from service.inference import Engine, load_engine
from service.manifest import DECODER_INPUT, DECODER_OUTPUTS, ENCODER_INPUT, encoder_outputs
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.metrics import azimuth_error, iou
from trainer.evaluation.pictures import Pictures, from_folder
from trainer.evaluation.subject import predict
from trainer.evaluation.voxels import occupy

PRECISIONS: Final[tuple[PrecisionName, ...]] = ("float32", "float16", "int8")
VALIDATION_SEED, TEST_SEED = 1, 2
LITTLE_NATS: Final = 0.1
"""A number of the shape code about which pictures say less than this on average hardly serves reconstructions."""


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    models: Path = Path("models")
    """Folder of bundles."""
    only: tuple[str, ...] = ()
    """Names of the models to look at; all by default."""
    objects: int = 60
    """Pictures to calibrate and look at, and as many others to judge on."""
    runs: int = 100
    """How often the graphs of each precision are timed, in turn."""
    output: Path = Path("docs/results/parsimony.json")
    """What is written; models that are in it and not looked at stay."""
    page: Path = PAGE
    """The page whose tables are written anew."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.parsimony", description=__doc__)
    torch.set_num_threads(1)
    known = json.loads(options.output.read_text())["models"] if options.output.exists() else {}
    names = options.only or sorted(path.parent.name for path in options.models.glob("*/manifest.json"))
    for name in names:
        origin = {
            "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "machine": machine(),
            "versions": versions(),
            "command": shlex.join(["python", "-m", "benchmarks.parsimony", *sys.argv[1:]]),
        }
        known[name] = {**origin, **look_at(options, options.models / name)}
        report = {
            "objects": options.objects,
            "runs": options.runs,
            "models": dict(sorted(known.items())),
        }
        options.output.write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n")
        write_tables(report, options.page)
        print(f"{name}: {json.dumps(known[name]['precisions'])}", flush=True)


def look_at(options: Options, bundle: Path) -> dict[str, Any]:
    """All figures of one model."""
    engine = load_engine(read_bundle(bundle))
    camera, size = engine.manifest.camera, engine.manifest.picture
    with tempfile.TemporaryDirectory() as work:
        validation, test = (
            render(bundle.name, options.objects, seed, Path(work)) for seed in (VALIDATION_SEED, TEST_SEED)
        )
        files = [path.read_bytes() for path in sorted(validation.rglob("*.png"))]
        pictures = read_pictures(
            files, size.width, size.height, camera.distance, camera.field_of_view_degrees, size.zoom
        )
        stored = engine.manifest.precision.encoder if engine.manifest.precision else "float32"
        bundles = {stored: bundle}
        for precision in PRECISIONS[PRECISIONS.index(stored) + 1 :]:
            bundles[precision] = Path(work) / precision
            repack(convertible_bundle(bundle, precision), bundles[precision], precision, files)
        judged = from_folder(test, from_bundle(bundle).scene)
        engines = {precision: load_engine(read_bundle(path)) for precision, path in bundles.items()}
        milliseconds = times(engines, pictures, options.runs)
        return {
            "parameterisation": engine.manifest.training["config"]["model"]["parameterisation"],  # type: ignore[index, call-overload]
            "carries": carried(engine, pictures),
            "precisions": {
                precision: {
                    "bytes": sum(file.stat().st_size for file in path.iterdir()),
                    **milliseconds[precision],
                    **judge(path, judged),
                    **cost(engines[precision]),
                }
                for precision, path in bundles.items()
            },
        }


def render(category: str, objects: int, seed: int, work: Path) -> Path:
    """A folder of pictures of new objects, one of each."""
    folder = work / f"pictures-{seed}"
    command = ["-m", "trainer", "render", "--class", category, "--instances", objects, "--seed", seed]
    subprocess.run([sys.executable, *map(str, command), "--output", str(folder)], check=True, stdout=subprocess.DEVNULL)
    return folder


def carried(engine: Engine, pictures: Float32[ndarray, "N 3 H W"]) -> dict[str, Any]:
    """What of a bundle is in use: numbers of the shape code and blocks, in all pictures and samples and in each."""
    manifest = engine.manifest
    mean, deviation = engine.encoder.run(["shape_mean", "shape_deviation"], {ENCODER_INPUT: pictures})
    divergence = (0.5 * (mean**2 + deviation**2 - 1) - np.log(deviation)).mean(0)
    generator = torch.Generator().manual_seed(0)
    noise = torch.randn(SAMPLES, manifest.latent, generator=generator)
    codes = torch.cat([noise, torch.from_numpy(mean)])
    alive = codes_alive(torch.from_numpy(mean), torch.from_numpy(deviation), noise)

    def decode(some: torch.Tensor) -> torch.Tensor:
        return torch.from_numpy(engine.decoder.run(["vertices"], {DECODER_INPUT: some.numpy()})[0])

    moving, _ = moving_numbers(decode, codes, generator)
    used = [len(used_blocks(one, engine.faces, manifest.blocks)) for one in decode(torch.from_numpy(mean)).numpy()]
    return {
        "numbers": manifest.latent,
        "numbers_that_move": len(moving),
        "numbers_pictures_say_little_of": int((divergence < LITTLE_NATS).sum()),
        "divergence_nats": [round(float(value), 4) for value in divergence],
        "least_activity": round(min(engine.latent_activity), 4),
        "blocks": len(manifest.blocks),
        "blocks_that_show": len(blocks_in_use(decode(alive).numpy(), engine.faces, manifest.blocks)),
        "blocks_used_in_a_picture": round(statistics.mean(used), 2),
    }


def times(
    engines: Mapping[PrecisionName, Engine], pictures: Float32[ndarray, "N 3 H W"], runs: int
) -> dict[str, dict[str, float]]:
    """Median milliseconds of each graph on one picture, in one thread; precisions take turns."""
    taken: dict[str, dict[str, list[float]]] = {name: {"encoder_ms": [], "decoder_ms": []} for name in engines}
    for run in range(runs):
        for name, engine in engines.items():
            began = time.perf_counter()
            code = engine.encoder.run(
                list(encoder_outputs(engine.manifest)), {ENCODER_INPUT: pictures[run % len(pictures)][None]}
            )[0]
            between = time.perf_counter()
            engine.decoder.run(list(DECODER_OUTPUTS), {DECODER_INPUT: code})
            taken[name]["encoder_ms"].append(1000 * (between - began))
            taken[name]["decoder_ms"].append(1000 * (time.perf_counter() - between))
    return {
        name: {graph: round(statistics.median(values), 3) for graph, values in graphs.items()}
        for name, graphs in taken.items()
    }


def judge(bundle: Path, pictures: Pictures) -> dict[str, float]:
    """Mean IoU, median azimuth error and share within 30° of what is served, without regard to symmetry."""
    subject = from_bundle(bundle)
    prediction = predict(subject, pictures.codes)
    faces = subject.faces.numpy()
    overlaps = [
        float(iou(occupy(vertices, faces).full, pictures.truth[number].voxels))
        for vertices, number in zip(prediction.vertices.double().numpy(), pictures.objects, strict=True)
    ]
    errors = np.degrees(azimuth_error(prediction.azimuths.double().numpy(), pictures.azimuths))
    return {
        "iou": round(statistics.mean(overlaps), 4),
        "azimuth_error_degrees": round(float(np.median(errors)), 2),
        "azimuth_accuracy": round(float((errors <= 30).mean()), 3),
    }


def cost(engine: Engine) -> dict[str, float]:
    """What the exporter measured against float32."""
    precision = engine.manifest.precision
    if precision is None:
        return {}
    return {
        "same_bin": round(precision.agreement["azimuth"], 3),
        "largest_vertex_deviation": float(f"{precision.deviations['vertices'].largest:.2g}"),
        "mean_code_deviation": float(f"{precision.deviations['shape_mean'].mean:.2g}"),
    }


if __name__ == "__main__":
    main()
