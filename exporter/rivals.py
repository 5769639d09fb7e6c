"""How strictly `auto` judges each of several bundles: a number each, fitted on pictures of all their categories.

    python -m exporter.rivals --models models --images PICTURES

A model that has learnt to make much explains other categories, too. PICTURES has a folder for each category, named
after it, of pictures that no model was trained on; the numbers are written into the bundles' manifests.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tyro
from jaxtyping import Float, Int64
from numpy import ndarray
from scipy.optimize import minimize
from scipy.special import logsumexp

from exporter.errors import ExportError
from exporter.held_out import LEAST_PICTURES, error_of, files_in
from service.bundle import MANIFEST_FILE, Bundle
from service.catalogue import read_catalogue
from service.errors import BundleError, ImageError
from service.explanation import category_evidence
from service.image import read_pictures
from service.inference import Engine, load_engine
from service.manifest import MOST_BIAS, encode_manifest
from service.reconstruction import frame_for
from trainer.data.decoding import MOST_PIXELS
from trainer.data.writing import write_bytes
from trainer.errors import ChiaroError


@dataclass(frozen=True)
class RivalsOptions:
    """Fits how strictly `auto` judges each of several bundles, and writes it into their manifests."""

    models: Path
    """A directory of bundles that are served together."""
    images: Path
    """A folder that has a folder of pictures for each of their categories, named after it: 20 at least, of which none
    was trained on. Pictures in a model's frame are looked at twice, as they are, and cut out as anybody's own are."""


class Fit(NamedTuple):
    """What was fitted, and what it gains on the pictures that it was fitted on."""

    biases: dict[str, float]
    """Of each category, nats."""
    right_before: float
    """Share of looks at pictures of which the right category is the most probable one."""
    right_after: float


def main(arguments: list[str]) -> int:
    """Read the options, fit, write, tell. Returns the exit status: 2 where something has to be mended."""
    options = tyro.cli(RivalsOptions, prog="python -m exporter.rivals", args=arguments)
    try:
        bundles, fit = fit_rivals(options.models, options.images)
        for bundle in bundles:
            manifest = replace(bundle.manifest, category_bias=fit.biases[bundle.manifest.category])
            write_bytes(bundle.path / MANIFEST_FILE, encode_manifest(manifest))
    except ChiaroError as error:
        print(error, file=sys.stderr)
        return 2
    for category, bias in sorted(fit.biases.items(), key=lambda entry: -entry[1]):
        print(f"{category}: {bias:+.2f}")
    print(f"named rightly, of these pictures: {fit.right_after:.1%} instead of {fit.right_before:.1%}")
    return 0


def fit_rivals(models: Path, images: Path) -> tuple[tuple[Bundle, ...], Fit]:
    """The bundles in a directory, and what is fitted to them on pictures of all their categories.

    Raises:
        ExportError: fewer than two bundles, one that is not to be trusted, or too few pictures of a category.
        DataError: a category has no folder of pictures.
    """
    try:
        bundles = read_catalogue(models).bundles
        engines = [load_engine(bundle) for bundle in bundles]
    except BundleError as error:
        raise ExportError(str(error)) from error
    categories = [engine.manifest.category for engine in engines]
    if len(engines) < 2:
        raise ExportError(
            f"{models}: expected bundles of two categories at least, found {len(engines)}; "
            "name a directory of those that are served together"
        )
    evidence, truth = [], []
    for number, category in enumerate(categories):
        found = list(evidence_of(engines, images / category))
        if len(found) < LEAST_PICTURES:
            raise ExportError(
                f"{images / category}: expected {LEAST_PICTURES} pictures of one {category} each at least, found "
                f"{len(found)} that can be used; put more of them there"
            )
        evidence += found
        truth += [number] * len(found)
    table, right = np.array(evidence), np.array(truth)
    biases = fitted_biases(table, right)
    before, after = (float((scores.argmax(1) == right).mean()) for scores in (table, table + biases))
    told = dict(zip(categories, (round(float(bias), 3) for bias in biases), strict=True))
    return bundles, Fit(told, before, after)


def evidence_of(engines: Sequence[Engine], folder: Path) -> Iterator[list[float]]:
    """For each look at a picture in a folder, how well each of the models explains it. Raises DataError where there is
    none that can be used."""
    size, frames = engines[0].manifest.picture, [frame_for(engine) for engine in engines]
    for content in files_in(folder, size.width, size.height):
        for keep_framed in (True, False):
            try:
                looks = read_pictures(content, frames, MOST_PIXELS, keep_framed)
            except ImageError:
                continue
            # What no model has in its frame is looked at once.
            if not keep_framed or any(look.method == "framed" for look in looks):
                errors = [error_of(engine, look) for engine, look in zip(engines, looks, strict=True)]
                yield [category_evidence((error,)) for error in errors]


def fitted_biases(evidence: Float[ndarray, "N C"], truth: Int64[ndarray, "N"]) -> Float[ndarray, "C"]:
    """What has to be added to the evidence [N, C] of C categories so that the true ones are as probable as can be.

    All categories weigh the same, however many pictures each has; biases have a normal prior of unit variance.
    """
    looks, categories = evidence.shape
    weights = looks / categories / np.bincount(truth, minlength=categories)[truth]
    rows = np.arange(looks)

    def cost(biases: Float[ndarray, "C"]) -> tuple[float, Float[ndarray, "C"]]:
        scores = evidence + biases
        logarithms = scores - logsumexp(scores, axis=1, keepdims=True)
        slopes = weights[:, None] * np.exp(logarithms)
        slopes[rows, truth] -= weights
        return float(0.5 * biases @ biases - weights @ logarithms[rows, truth]), biases + slopes.sum(0)

    limits = [(-MOST_BIAS, MOST_BIAS)] * categories
    found: Float[ndarray, C] = minimize(cost, np.zeros(categories), jac=True, bounds=limits, method="L-BFGS-B").x
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
