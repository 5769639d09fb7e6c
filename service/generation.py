"""From a seed or a shape code to an answer. The same request has the same bytes. Knows no HTTP, runs in any thread."""

from collections.abc import Sequence
from time import perf_counter
from typing import Final

import numpy as np
from pydantic_core import to_jsonable_python

from service.answer import Answer, Form, Gallery, milliseconds
from service.density import seeded_share
from service.errors import ShapeCodeError
from service.findings import Origin, report_shape
from service.glb import write_glb, write_row_glb
from service.inference import Array, Engine, decode, sample_shape_code
from service.manifest import Manifest
from service.overlay import objects_png
from service.report import InterpolationReport

SEEDS: Final = 2**32
LARGEST_NUMBER: Final = 10.0
"""Of a shape code: far more than any picture has."""


def sample(engine: Engine, seed: int, temperature: float = 1.0, azimuth: float = 0.0, form: Form = "glb") -> Answer:
    """An object that no picture shows, seen at `azimuth` radians.

    Raises:
        InferenceError: the model gave something that is no mesh.
    """
    code = sampled_code(engine.manifest, seed, temperature)
    return _made(engine, code, Origin(seed=seed, temperature=temperature), azimuth, form)


def sample_together(engine: Engine, seeds: Sequence[int], temperature: float, azimuth: float, form: Form) -> Gallery:
    """Several objects, one of each seed, in one file.

    Raises:
        InferenceError: the model gave something that is no mesh.
    """
    started = perf_counter()
    manifest = engine.manifest
    codes = [sampled_code(manifest, seed, temperature) for seed in seeds]
    surfaces = [decode(engine, code) for code in codes]
    decoded = perf_counter()
    reports = tuple(
        report_shape(manifest, code, azimuth, Origin(seed=seed, temperature=temperature))
        for seed, code in zip(seeds, codes, strict=True)
    )
    if form == "png":
        content = objects_png(engine, surfaces, azimuth)
    else:
        extras = {"samples": to_jsonable_python(reports)}
        content = write_row_glb(surfaces, [f"sample {seed}" for seed in seeds], manifest, azimuth, extras)
    seconds = {"decoder": decoded - started, form: perf_counter() - decoded}
    return Gallery(content, reports, milliseconds(seconds))


def sampled_code(manifest: Manifest, seed: int, temperature: float) -> Array:
    """The shape code of a seed [Z], from where pictures of the class have theirs, or from the prior where the bundle
    does not know. What the exporter left out of codes was drawn all the same: a seed stays the same object."""
    thrift, density = manifest.parsimony, manifest.aggregate_posterior
    noise = sample_shape_code(seed, thrift.trained_latent if thrift else manifest.latent)
    kept: Array = noise[list(thrift.latent)] if thrift else noise
    if density is None:
        return np.float32(temperature) * kept
    return density.code(kept.astype(np.float64), seeded_share(seed), temperature).astype(np.float32)


def consecutive(seed: int, count: int) -> list[int]:
    """`count` seeds from `seed` on; after the last one comes 0."""
    return [(seed + number) % SEEDS for number in range(count)]


def read_shape_code(text: str) -> list[float]:
    """The numbers that stand between commas. Raises ShapeCodeError where something else does."""
    try:
        return [float(number) for number in text.split(",")]
    except ValueError as error:
        raise ShapeCodeError(f"expected numbers between commas in a shape code, found: {str(error)[:99]}") from None


def decode_shape(engine: Engine, numbers: Sequence[float], azimuth: float = 0.0, form: Form = "glb") -> Answer:
    """The object of a shape code.

    Raises:
        ShapeCodeError: not as many numbers as the model's codes have, or one that is far off.
        InferenceError: the model gave something that is no mesh.
    """
    latent = engine.manifest.latent
    if len(numbers) != latent:
        raise ShapeCodeError(
            f"expected a shape code of {latent} numbers for {engine.manifest.category}, found {len(numbers)}; "
            "see /v1/categories"
        )
    # Not any(… > …): a not-a-number would pass.
    if not all(abs(number) <= LARGEST_NUMBER for number in numbers):
        raise ShapeCodeError(
            f"expected numbers from {-LARGEST_NUMBER:g} to {LARGEST_NUMBER:g} in a shape code, found others; most "
            "codes stay within −3 to 3"
        )
    return _made(engine, np.array(numbers, np.float32), Origin(), azimuth, form)


def interpolate(
    engine: Engine,
    from_seed: int,
    to_seed: int,
    t: float,
    temperature: float = 1.0,
    azimuth: float = 0.0,
    form: Form = "glb",
) -> Answer:
    """The object on the straight way between the shape codes of two samples of a temperature, at `t` from 0 to 1.

    Raises:
        InferenceError: the model gave something that is no mesh.
    """
    start, end = (sampled_code(engine.manifest, seed, temperature) for seed in (from_seed, to_seed))
    code = ((1 - t) * start + t * end).astype(np.float32)
    return _made(engine, code, Origin(None, temperature, InterpolationReport(from_seed, to_seed, t)), azimuth, form)


def _made(engine: Engine, code: Array, origin: Origin, azimuth: float, form: Form) -> Answer:
    started = perf_counter()
    surface = decode(engine, code)
    decoded = perf_counter()
    report = report_shape(engine.manifest, code, azimuth, origin)
    if form == "png":
        content = objects_png(engine, [surface], azimuth)
    else:
        content = write_glb(surface, engine.manifest, azimuth, to_jsonable_python(report))
    seconds = {"decoder": decoded - started, form: perf_counter() - decoded}
    return Answer(content, report, milliseconds(seconds))
