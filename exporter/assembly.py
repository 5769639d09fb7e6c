"""From float32 graphs and what is known of them to a bundle on the disk: precision, probe, seal, proof."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

import torch
from jaxtyping import Float32
from numpy import ndarray

from exporter.errors import ExportError
from exporter.examples import random_pictures, random_shape_codes
from exporter.held_out import LEAST_PICTURES, measure_held_out
from exporter.parity import measure_deviations
from exporter.precision import Graphs, PrecisionName, lowered
from exporter.probe import make_probe
from exporter.publication import published
from service.bundle import MANIFEST_FILE, read_bundle
from service.errors import BundleError
from service.inference import load_engine
from service.manifest import (
    DECODER_FILE,
    DECODER_OUTPUTS,
    ENCODER_FILE,
    PROBE_FILE,
    Manifest,
    encode_manifest,
    encoder_outputs,
    model_identity,
)
from service.thrift import Precision

EXAMPLES: Final = 16
"""Made-up pictures, and shape codes, out of which the probe is taken."""
COMPARED_SAMPLES: Final = 256
"""Shape codes from the prior on which decoders of two precisions are compared."""


@dataclass(frozen=True)
class Parts:
    """A bundle before it is written: float32 graphs, and a manifest that is right but for digests and precision."""

    manifest: Manifest
    graphs: Graphs


def write_bundle(
    parts: Parts,
    output: Path,
    precision: PrecisionName,
    held_out: Sequence[bytes],
    pictures: Float32[ndarray, "N 3 H W"],
    generator: torch.Generator,
) -> Manifest:
    """Writes a bundle to the directory `output` and returns its manifest; the service's own reader has proven it.

    `held_out` are picture files, `pictures` those of them that can be used as the encoder gets them; `generator` draws
    the probe's inputs.

    Raises:
        ExportError: `output` is something else than a bundle, too few of the pictures can be used, or the service
            would refuse the bundle; nothing is written.
        StorageError: the disk is full, or cannot be written; nothing is left half-written.
    """
    with published(output) as staging:
        parts = _in_precision(parts, precision, pictures)
        manifest, graphs = parts.manifest, parts.graphs
        size = manifest.picture
        examples = random_pictures(EXAMPLES, size.height, size.width, generator)
        probe = make_probe(manifest, graphs, examples, random_shape_codes(EXAMPLES, manifest.latent, generator))
        files = {ENCODER_FILE: graphs.encoder, DECODER_FILE: graphs.decoder, PROBE_FILE: probe}
        digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
        manifest = replace(manifest, identity=model_identity(digests), files=digests)
        for name, content in {**files, MANIFEST_FILE: encode_manifest(manifest)}.items():
            (staging / name).write_bytes(content)
        try:
            engine = load_engine(read_bundle(staging))
            if held_out:
                manifest = replace(manifest, held_out=measure_held_out(engine, held_out))
                (staging / MANIFEST_FILE).write_bytes(encode_manifest(manifest))
                read_bundle(staging)
        except BundleError as error:
            raise ExportError(f"the service would refuse this bundle, so it was not written: {error}") from error
    return manifest


def _in_precision(parts: Parts, precision: PrecisionName, pictures: Float32[ndarray, "N 3 H W"]) -> Parts:
    """The same parts in another precision, and what that costs: the first half of the pictures calibrates, the other is
    compared."""
    if precision == "float32":
        return parts
    if len(pictures) < 2 * LEAST_PICTURES:
        raise ExportError(
            f"expected {2 * LEAST_PICTURES} held-out pictures to calibrate and compare {precision} with, found "
            f"{len(pictures)}; name a folder of more with --images, or choose --precision float32"
        )
    half = len(pictures) // 2
    manifest, before = parts.manifest, parts.graphs
    graphs = lowered(before, precision, pictures[:half])
    compared, outputs = torch.from_numpy(pictures[half:]), encoder_outputs(manifest)
    deviations, agreement = measure_deviations(before.encoder, graphs.encoder, compared, outputs)
    codes = random_shape_codes(COMPARED_SAMPLES, manifest.latent, torch.Generator().manual_seed(0))
    shapes, _ = measure_deviations(before.decoder, graphs.decoder, codes, DECODER_OUTPUTS)
    decoder: Literal["float32", "float16"] = "float16" if precision == "float16" else "float32"
    record = Precision(precision, decoder, len(compared), {**deviations, **shapes}, agreement)
    return Parts(replace(manifest, precision=record), graphs)
