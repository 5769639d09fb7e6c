"""What a longer look gains: bundles of fixed light, judged as the encoder answers and after iterations of refinement.

    python -m benchmarks.refinement --models models --real-meshes DIR

Procedural objects that no training or validation saw, one picture each, and real meshes, if any, in several views.
Writes a JSON file with the machine and, for each bundle, both judgements and the milliseconds of an answer's refinement
as the service computes it, on one core.
"""

import argparse
import statistics
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.bundles import TEST_SEED, VALIDATION_SEED, add_options, measure_bundles, rendered
from imaging.preparation import Prepared
from service.bundle import read_bundle
from service.inference import encode, load_engine
from service.refinement import Effort, improve
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import Pictures, Validation, from_folder, from_meshes, linear_batches, validation_from
from trainer.evaluation.protocol import judge
from trainer.evaluation.report import as_json
from trainer.evaluation.subject import Subject

TIMED = 40
FIGURES = (
    "iou",
    "mean_shape_iou",
    "nearest_neighbour_iou",
    "symmetric_azimuth_error_degrees",
    "symmetric_azimuth_accuracy",
    "flipped",
    "untempered_calibration_error",
    "picture_error",
    "objects",
    "pictures",
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--iterations", type=int, default=4, help="of refinement")
    add_options(parser, 200, 12, Path("benchmarks/refinement.json"))
    arguments = parser.parse_args()
    # As the service has it.
    threadpool_limits(1, "blas")
    measure_bundles("benchmarks.refinement", arguments, measured, iterations=arguments.iterations)
    return 0


def measured(bundle: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """All figures of one bundle."""
    subject = from_bundle(bundle)
    with tempfile.TemporaryDirectory() as folder:
        validation = validation_from(rendered(Path(folder), subject, VALIDATION_SEED, arguments.objects), subject.scene)
        test = from_folder(rendered(Path(folder), subject, TEST_SEED, arguments.objects), subject.scene)
    found: dict[str, Any] = {"test": _both(subject, test, validation, arguments.iterations)}
    meshes = arguments.real_meshes and arguments.real_meshes / subject.category
    if meshes and meshes.is_dir():
        real = from_meshes(meshes, subject.scene, arguments.views)
        found["real_meshes"] = _both(subject, real, validation, arguments.iterations)
    images = np.concatenate([batch.numpy() for batch in linear_batches(test.codes[:TIMED])])
    found["service_ms"] = _milliseconds(bundle, images, arguments.iterations)
    return found


def _both(subject: Subject, pictures: Pictures, validation: Validation, iterations: int) -> dict[str, Any]:
    """The judge's figures, as encoded and refined."""
    judged = {}
    for name, count in (("encoded", 0), ("refined", iterations)):
        report = as_json(judge(replace(subject, refinement=count), pictures, validation).report)
        judged[name] = {figure: report[figure] for figure in FIGURES}
    return judged


def _milliseconds(bundle: Path, images: np.ndarray, iterations: int) -> dict[str, float]:
    """The median over pictures, of the encoder's part and of refinement."""
    engine = load_engine(read_bundle(bundle))
    encoding, refining = [], []
    for image in images:
        began = perf_counter()
        posterior = encode(engine, image)
        encoded = perf_counter()
        improve(engine, [Prepared(image, "framed")], [posterior], posterior.shape_mean, Effort(iterations))
        encoding.append(encoded - began)
        refining.append(perf_counter() - encoded)
    return {
        "encoder": round(1000 * statistics.median(encoding), 3),
        "refinement": round(1000 * statistics.median(refining), 3),
    }


if __name__ == "__main__":
    sys.exit(main())
