"""Whether samples look like what a model makes of pictures: those from the prior, and those that are served.

    python -m benchmarks.samples --models models

Shapes of a bundle share their vertices: two of them are as far apart as their vertices are (root mean square, in
diagonals of the bounding box). As many samples are compared with the shapes of unseen objects' pictures, drawn from
their posteriors, as there are of these. Writes a JSON file with the machine and, for each bundle, means of

    from_sample     how far a sample is from the nearest of these shapes: whether it looks like one of them
    to_sample       how far one of these is from the nearest sample: whether all kinds are among the samples
    own_kind        how often a shape's nearest neighbour is of its kind, sample or not: 0.5 where nobody can tell them
                    apart (1-nearest-neighbour accuracy: Lopez-Paz and Oquab, 2017)
"""

import argparse
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial.distance import cdist

from benchmarks.bundles import TEST_SEED, measure_bundles, rendered
from exporter.held_out import files_in, read_pictures
from service.bundle import read_bundle
from service.generation import sampled_code
from service.inference import Engine, decode_all, encode, load_engine
from trainer.evaluation.bundle import from_bundle


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=Path, default=Path("models"), help="a directory of bundles")
    parser.add_argument("--only", nargs="*", help="names of bundles; all, if absent")
    parser.add_argument("--objects", type=int, default=400, help="unseen objects, and samples")
    parser.add_argument("--output", type=Path, default=Path("docs/results/samples.json"))
    measure_bundles("benchmarks.samples", parser.parse_args(), measured)
    return 0


def measured(bundle: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """All figures of one bundle."""
    engine = load_engine(read_bundle(bundle))
    with tempfile.TemporaryDirectory() as folder:
        shapes = _shapes_in(engine, rendered(Path(folder), from_bundle(bundle), TEST_SEED, arguments.objects))
    served, prior = engine.manifest, replace(engine.manifest, aggregate_posterior=None)
    codes = (np.stack([sampled_code(one, seed, 1.0) for seed in range(len(shapes))]) for one in (prior, served))
    from_prior, from_served = (_distances(_decoded(engine, drawn), shapes) for drawn in codes)
    density = served.aggregate_posterior
    told = {"numbers": len(density.numbers), "gaussians": len(density.gaussians)} if density else {}
    return {**told, "prior": from_prior, "served": from_served}


def _shapes_in(engine: Engine, folder: Path) -> Float[ndarray, "N D"]:
    size, camera, random = engine.manifest.picture, engine.manifest.camera, np.random.default_rng(0)
    files, own = files_in(folder, size.width, size.height), (camera.distance, camera.field_of_view_degrees, size.zoom)
    codes = []
    for picture in read_pictures(files, size.width, size.height, *own):
        posterior = encode(engine, picture)
        noise = random.standard_normal(len(posterior.shape_mean))
        codes.append(posterior.shape_mean + posterior.shape_deviation * noise)
    return _decoded(engine, np.stack(codes).astype(np.float32))


def _decoded(engine: Engine, codes: Float[ndarray, "N Z"]) -> Float[ndarray, "N D"]:
    """Vertices, scaled so that Euclidean distances are root mean squares over them."""
    vertices = decode_all(engine, codes).vertices.astype(np.float64)
    return vertices.reshape(len(codes), -1) / np.sqrt(vertices.shape[1])


def _distances(samples: Float[ndarray, "N D"], shapes: Float[ndarray, "N D"]) -> dict[str, float]:
    across = cdist(samples, shapes)
    among_samples, among_shapes = (
        cdist(each, each) + np.diag(np.full(len(each), np.inf)) for each in (samples, shapes)
    )
    own_kind = np.r_[among_samples.min(1) < across.min(1), among_shapes.min(1) < across.min(0)]
    means = {"from_sample": across.min(1).mean(), "to_sample": across.min(0).mean(), "own_kind": own_kind.mean()}
    return {name: round(float(value), 4) for name, value in means.items()}


if __name__ == "__main__":
    sys.exit(main())
