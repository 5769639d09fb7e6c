"""From a checkpoint to a bundle: graphs, proof, manifest, probe, and only then the directory."""

import hashlib
import io
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import JsonValue, ValidationError

from exporter.conversion import to_onnx
from exporter.errors import ExportError
from exporter.examples import random_pictures, random_shape_codes
from exporter.graphs import DecoderGraph, EncoderGraph, exported_bin_centres, exported_light_bin_centres
from exporter.held_out import measure_held_out
from exporter.parity import BEST_BINS, measure_parity, run_onnx, top_margin
from exporter.publication import published
from service.bundle import MANIFEST_FILE, read_bundle
from service.errors import BundleError
from service.inference import load_engine
from service.manifest import (
    DECODER_FILE,
    DECODER_INPUT,
    DECODER_OUTPUTS,
    ENCODER_FILE,
    ENCODER_INPUT,
    ENCODER_OUTPUTS,
    FORMAT_VERSION,
    LIGHT_OUTPUTS,
    PROBE_FILE,
    Block,
    Camera,
    Conventions,
    Light,
    Manifest,
    Picture,
    encode_manifest,
    model_identity,
)
from trainer.training.checkpoint import Checkpoint

PARITY_BATCHES: Final = (1, 2, 5, 16)
PROBE_BATCH: Final = 2

Array = NDArray[np.float32]


def export(
    checkpoint: Checkpoint,
    output: Path,
    azimuth_offset: float,
    metrics: dict[str, JsonValue],
    seed: int = 0,
    held_out: Sequence[bytes] = (),
) -> Manifest:
    """Writes a checkpoint's model as a bundle to the directory `output`, and returns its manifest.

    `azimuth_offset` is δ of `exporter.graphs`, radians; `metrics` are the judge's figures; `seed` draws the inputs of
    parity and probe; `held_out` are files of pictures that were not trained on, if there are any. What is written has
    been read and proven by the service's own reader.

    Raises:
        ExportError: `output` is something else than a bundle, torch and onnxruntime disagree, too few of the held-out
            pictures can be used, or the service would refuse the bundle; nothing is written.
        StorageError: the disk is full, or cannot be written; nothing is left half-written.
    """
    with published(output) as staging:
        manifest, files = _build(checkpoint, azimuth_offset, metrics, torch.Generator().manual_seed(seed))
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


def _build(
    checkpoint: Checkpoint, azimuth_offset: float, metrics: dict[str, JsonValue], generator: torch.Generator
) -> tuple[Manifest, dict[str, bytes]]:
    model = checkpoint.model.cpu().eval()
    width, height, latent = model.width, model.height, model.config.latent
    pictures = [random_pictures(batch, height, width, generator) for batch in PARITY_BATCHES]
    shape_codes = [random_shape_codes(batch, latent, generator) for batch in PARITY_BATCHES]
    encoder_module, decoder_module = EncoderGraph(model, azimuth_offset), DecoderGraph(model, azimuth_offset)
    outputs = ENCODER_OUTPUTS + (LIGHT_OUTPUTS if model.config.light == "varying" else ())
    encoder = to_onnx(encoder_module, pictures[-1], ENCODER_INPUT, outputs)
    decoder = to_onnx(decoder_module, shape_codes[-1], DECODER_INPUT, DECODER_OUTPUTS)
    parity = {
        **measure_parity(encoder_module, encoder, pictures, outputs),
        **measure_parity(decoder_module, decoder, shape_codes, DECODER_OUTPUTS),
    }
    files = {
        ENCODER_FILE: encoder,
        DECODER_FILE: decoder,
        PROBE_FILE: _probe(encoder, outputs, decoder, pictures[-1], shape_codes[-1]),
    }
    return _manifest(checkpoint, azimuth_offset, metrics, parity, files), files


def _probe(
    encoder: bytes, names: tuple[str, ...], decoder: bytes, pictures: torch.Tensor, shape_codes: torch.Tensor
) -> bytes:
    """The clearest pictures and the first shape codes, with what the graphs make of them, as .npz."""
    outputs = run_onnx(encoder, pictures, names)
    # A picture between two bins would be answered by either on another machine.
    margins = [top_margin(outputs[bins]) for angle, bins in BEST_BINS.items() if angle in names]
    clearest = np.argsort(-np.min(margins, axis=0))[:PROBE_BATCH]
    arrays: dict[str, Array] = {
        ENCODER_INPUT: pictures.numpy()[clearest],
        **{name: output[clearest] for name, output in outputs.items()},
        DECODER_INPUT: shape_codes.numpy()[:PROBE_BATCH],
        **run_onnx(decoder, shape_codes[:PROBE_BATCH], DECODER_OUTPUTS),
    }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{name: np.ascontiguousarray(a) for name, a in arrays.items()})
    return buffer.getvalue()


def without_paths(value: Any) -> Any:
    """The same, with the last name alone of each absolute path: the maker's disk is nobody's business."""
    if isinstance(value, dict):
        return {name: without_paths(part) for name, part in value.items()}
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value


def _manifest(
    checkpoint: Checkpoint,
    azimuth_offset: float,
    metrics: dict[str, JsonValue],
    parity: dict[str, float],
    files: dict[str, bytes],
) -> Manifest:
    model, scene = checkpoint.model, checkpoint.scene
    faces = tuple((int(a), int(b), int(c)) for a, b, c in model.faces.tolist())
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    training = {"step": checkpoint.step, "run": without_paths(checkpoint.run), "config": asdict(checkpoint.config)}
    try:
        return Manifest(
            format_version=FORMAT_VERSION,
            category=checkpoint.category,
            identity=model_identity(digests),
            conventions=Conventions(),
            picture=Picture(width=model.width, height=model.height),
            camera=Camera(**asdict(scene.camera)),
            lights=tuple(Light(**asdict(light)) for light in scene.lights),
            ambient=scene.ambient,
            azimuth_bin_centres_degrees=tuple(exported_bin_centres(model.config.azimuth_bins, azimuth_offset)),
            azimuth_offset_degrees=round(math.degrees(azimuth_offset), 10),
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
