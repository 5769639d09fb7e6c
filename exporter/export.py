"""From a checkpoint to a bundle: what carries something becomes graphs, proven to say the same, with a manifest."""

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import torch
from pydantic import JsonValue, ValidationError

from exporter.assembly import Parts, write_bundle
from exporter.conversion import to_onnx
from exporter.density import told
from exporter.errors import ExportError
from exporter.examples import random_pictures, random_shape_codes
from exporter.graphs import DecoderGraph, EncoderGraph, exported_bin_centres, exported_light_bin_centres
from exporter.held_out import read_pictures
from exporter.parity import measure_parity
from exporter.precision import Graphs, PrecisionName
from exporter.publication import check_replaceable
from exporter.slimming import slimmed
from service.manifest import (
    DECODER_FILE,
    DECODER_INPUT,
    DECODER_OUTPUTS,
    ENCODER_FILE,
    ENCODER_INPUT,
    ENCODER_OUTPUTS,
    FORMAT_VERSION,
    LIGHT_OUTPUTS,
    Block,
    Camera,
    Conventions,
    Light,
    Manifest,
    Picture,
    model_identity,
)
from trainer.evaluation.self_consistency import consistent_posterior
from trainer.model.aggregate_posterior import LEAST_PICTURES
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint

PARITY_BATCHES: Final = (1, 2, 5, 16)
_BATCH: Final = 64


def export(
    checkpoint: Checkpoint,
    output: Path,
    azimuth_offset: float,
    metrics: dict[str, JsonValue],
    seed: int = 0,
    held_out: Sequence[bytes] = (),
    precision: PrecisionName = "float32",
    azimuth_temperature: float = 1.0,
    samples_from: Sequence[bytes] = (),
) -> Manifest:
    """Writes a checkpoint's model as a bundle to the directory `output`, and returns its manifest.

    `azimuth_offset` is δ of `exporter.graphs`, radians, `azimuth_temperature` its temperature; `metrics` are the
    judge's figures; `seed` draws the inputs of parity and probe; `held_out` are files of pictures that were not trained
    on, if there are any; `samples_from` files of those by whose shape codes samples are drawn, which are `held_out` if
    there are none. What carries nothing is left out (`exporter.slimming`). What is written has been read and
    proven by the service's own reader.

    Raises:
        ExportError: torch and onnxruntime disagree; or as `write_bundle` does. Nothing is written.
        DataError: of the pictures to draw samples from, too few can be used. Nothing is written.
        StorageError: the disk is full, or cannot be written; nothing is left half-written.
    """
    check_replaceable(output.absolute())
    model, scene = checkpoint.model.cpu().eval(), checkpoint.scene
    seen = model.width, model.height, scene.camera.distance, scene.camera.field_of_view_degrees, scene.zoom
    pictures = read_pictures(held_out, *seen)
    slim, parsimony = slimmed(model, pictures, torch.Generator().manual_seed(seed))
    generator = torch.Generator().manual_seed(seed)
    graphs, parity = _graphs(slim, azimuth_offset, azimuth_temperature, generator)
    slender = replace(checkpoint, model=slim)
    manifest = _manifest(slender, azimuth_offset, azimuth_temperature, metrics, parity, graphs)
    of_class = read_pictures(samples_from, *seen) if samples_from else pictures
    if samples_from or len(pictures) >= LEAST_PICTURES:
        density = consistent_posterior(slim, scene, torch.from_numpy(of_class).split(_BATCH))
        manifest = replace(manifest, aggregate_posterior=told(density))
    parts = Parts(replace(manifest, parsimony=parsimony), graphs)
    return write_bundle(parts, output, precision, held_out, pictures, generator)


def _graphs(
    model: Model, azimuth_offset: float, azimuth_temperature: float, generator: torch.Generator
) -> tuple[Graphs, dict[str, float]]:
    """The two graphs of a model, and the largest difference between torch and onnxruntime per output."""
    width, height, latent = model.width, model.height, model.config.latent
    pictures = [random_pictures(batch, height, width, generator) for batch in PARITY_BATCHES]
    shape_codes = [random_shape_codes(batch, latent, generator) for batch in PARITY_BATCHES]
    encoder_module = EncoderGraph(model, azimuth_offset, azimuth_temperature)
    decoder_module = DecoderGraph(model, azimuth_offset)
    outputs = ENCODER_OUTPUTS + (LIGHT_OUTPUTS if model.config.light == "varying" else ())
    encoder = to_onnx(encoder_module, pictures[-1], ENCODER_INPUT, outputs)
    decoder = to_onnx(decoder_module, shape_codes[-1], DECODER_INPUT, DECODER_OUTPUTS)
    parity = {
        **measure_parity(encoder_module, encoder, pictures, outputs),
        **measure_parity(decoder_module, decoder, shape_codes, DECODER_OUTPUTS, model.faces.numpy()),
    }
    return Graphs(encoder, decoder), parity


def without_paths(value: Any) -> Any:
    """The same, with the last name alone of each absolute path: the maker's disk is nobody's business."""
    if isinstance(value, dict):
        return {name: without_paths(part) for name, part in value.items()}
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value


def _manifest(
    checkpoint: Checkpoint,
    azimuth_offset: float,
    azimuth_temperature: float,
    metrics: dict[str, JsonValue],
    parity: dict[str, float],
    graphs: Graphs,
) -> Manifest:
    model, scene = checkpoint.model, checkpoint.scene
    faces = tuple((int(a), int(b), int(c)) for a, b, c in model.faces.tolist())
    files = {ENCODER_FILE: graphs.encoder, DECODER_FILE: graphs.decoder}
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    training = {"step": checkpoint.step, "run": without_paths(checkpoint.run), "config": asdict(checkpoint.config)}
    try:
        return Manifest(
            format_version=FORMAT_VERSION,
            category=checkpoint.category,
            identity=model_identity(digests),
            conventions=Conventions(),
            picture=Picture(width=model.width, height=model.height, zoom=scene.zoom),
            camera=Camera(**asdict(scene.camera)),
            lights=tuple(Light(**asdict(light)) for light in scene.lights),
            ambient=scene.ambient,
            azimuth_bin_centres_degrees=tuple(exported_bin_centres(model.config.azimuth_bins, azimuth_offset)),
            azimuth_offset_degrees=round(math.degrees(azimuth_offset), 10),
            azimuth_temperature=azimuth_temperature,
            views_per_instance=checkpoint.config.optimiser.views_per_instance,
            latent=model.config.latent,
            vertices=len(model.decoder.base_vertices),
            training=json.loads(json.dumps(training, allow_nan=False)),
            metrics=metrics,
            parity=parity,
            files=digests,
            blocks=tuple(Block(*part) for part in model.decoder.parts),
            faces=faces,
            light_bin_centres_degrees=tuple(
                exported_light_bin_centres(model.config.light_bins) if model.config.light == "varying" else ()
            ),
        )
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        field = ".".join(str(part) for part in first["loc"])
        raise ExportError(
            f"{field}: {first['msg']}, found {str(first['input'])[:60]}; a bundle cannot say that: mend the "
            "checkpoint's scene.json or its run's options, and train again"
        ) from None
    except (TypeError, ValueError) as error:
        raise ExportError(
            f"the run's summary: expected JSON with finite numbers, found: {error}; train again"
        ) from None
