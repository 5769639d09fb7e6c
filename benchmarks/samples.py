"""Whether samples look like what a model makes of pictures: those from the prior, and those that are served.

    python -m benchmarks.samples --models models

Shapes of a bundle share their vertices: two of them are as far apart as their vertices are (root mean square, in
diagonals of the bounding box). As many samples are compared with the shapes of unseen objects' pictures, drawn from
their posteriors, as there are of these, and, at 32³, with the objects themselves. Writes a JSON file with the machine
and, for each bundle, means of

    from_sample     how far a sample is from the nearest of these shapes: whether it looks like one of them
    to_sample       how far one of these is from the nearest sample: whether all kinds are among the samples
    sample_to_true  the IoU of a sample with that of the unseen objects which it is most like: whether it is an object
    true_to_sample  the IoU of an unseen object with the sample that is most like it: whether all kinds are among them
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
from jaxtyping import Bool, Float, Int64, Shaped
from numpy import ndarray
from scipy.spatial.distance import cdist
from torch import Tensor

from benchmarks.bundles import TEST_SEED, measure_bundles, rendered
from exporter.held_out import files_in, read_pictures
from service.bundle import read_bundle
from service.generation import sampled_code
from service.inference import Engine, decode_all, encode, load_engine
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import from_folder
from trainer.evaluation.voxels import occupy


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
    subject = from_bundle(bundle)
    with tempfile.TemporaryDirectory() as folder:
        pictures = rendered(Path(folder), subject, TEST_SEED, arguments.objects)
        shapes = _shapes_in(engine, pictures)
        true = np.stack([truth.voxels for truth in from_folder(pictures, subject.scene).truth])
    served, prior = engine.manifest, replace(engine.manifest, aggregate_posterior=None)
    codes = (np.stack([sampled_code(one, seed, 1.0) for seed in range(len(shapes))]) for one in (prior, served))
    from_prior, from_served = (_likeness(_vertices(engine, drawn), shapes, subject.faces, true) for drawn in codes)
    density = served.aggregate_posterior
    told = {"numbers": len(density.numbers), "gaussians": len(density.gaussians)} if density else {}
    return {**told, "prior": from_prior, "served": from_served}


def _shapes_in(engine: Engine, folder: Path) -> Float[ndarray, "N V 3"]:
    size, camera, random = engine.manifest.picture, engine.manifest.camera, np.random.default_rng(0)
    files, own = files_in(folder, size.width, size.height), (camera.distance, camera.field_of_view_degrees, size.zoom)
    codes = []
    for picture in read_pictures(files, size.width, size.height, *own):
        posterior = encode(engine, picture)
        noise = random.standard_normal(len(posterior.shape_mean))
        codes.append(posterior.shape_mean + posterior.shape_deviation * noise)
    return _vertices(engine, np.stack(codes).astype(np.float32))


def _vertices(engine: Engine, codes: Float[ndarray, "N Z"]) -> Float[ndarray, "N V 3"]:
    return decode_all(engine, codes).vertices.astype(np.float64)


def _likeness(
    samples: Float[ndarray, "N V 3"],
    shapes: Float[ndarray, "N V 3"],
    faces: Int64[Tensor, "F 3"],
    true: Bool[ndarray, "M R R R"],
) -> dict[str, float]:
    solids = np.stack([occupy(vertices, faces.numpy()).full for vertices in samples])
    overlaps = _overlaps(_flat(solids), _flat(true))
    means = {"sample_to_true": overlaps.max(1).mean(), "true_to_sample": overlaps.max(0).mean()}
    # Euclidean distances are then root mean squares over vertices.
    distances = _distances(*(_flat(each) / np.sqrt(each.shape[1]) for each in (samples, shapes)))
    return distances | {name: round(float(value), 4) for name, value in means.items()}


def _flat(batch: Shaped[ndarray, "N ..."]) -> Float[ndarray, "N D"]:
    flat: Float[ndarray, "N D"] = batch.reshape(len(batch), -1).astype(np.float64)
    return flat


def _overlaps(solids: Float[ndarray, "N D"], others: Float[ndarray, "M D"]) -> Float[ndarray, "N M"]:
    """IoU of each with each."""
    both = solids @ others.T
    overlaps: Float[ndarray, "N M"] = both / (solids.sum(1)[:, None] + others.sum(1) - both)
    return overlaps


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
