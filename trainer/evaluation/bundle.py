"""A bundle under judgement: the two ONNX graphs that ship, as the service runs them.

The format is the exporter's and the service's; here is read what judging needs of `manifest.json`, and no other
version or preparation of pictures is accepted than the one that the judge itself follows.
"""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
import torch
from jaxtyping import Float
from torch import Tensor

from trainer.config import SceneConfig
from trainer.data.scene import check_scene
from trainer.errors import CheckpointError, ConfigError
from trainer.evaluation.refinement import Inference
from trainer.evaluation.subject import Subject
from trainer.mapping import from_mapping

MANIFEST_FILE = "manifest.json"
ENCODER_FILE, DECODER_FILE = "encoder.onnx", "decoder.onnx"
FORMAT_VERSION = 1

_PREPARATION = {
    "file_colour": "sRGB",
    "graph_colour": "linear, 0 to 1",
    "channels": "RGB, row 0 on top",
    "background": "black",
}

Run = Callable[[Float[Tensor, "B ..."]], list[Tensor]]


def from_bundle(directory: Path) -> Subject:
    """The model of a bundle, run by onnxruntime in one thread.

    Its azimuths and vertices are as they are served: with the azimuth offset that the exporter baked in.

    Raises CheckpointError where a file is missing, altered, or says something else than a bundle of this version.
    """
    manifest = _read_manifest(directory)
    told = [
        "shape_mean",
        "shape_deviation",
        "azimuth_probabilities",
        "azimuth_fine_mean",
        *(["light_azimuth"] if manifest.get("light_bin_centres_degrees") else []),
    ]
    encode = _graph(directory, ENCODER_FILE, manifest, told)
    decoder = _graph(directory, DECODER_FILE, manifest, ["vertices"])

    def infer(images: Float[Tensor, "B 3 H W"]) -> Inference:
        shape_mean, shape_deviation, probabilities, fine_mean, *lights = encode(images)
        return Inference(shape_mean, shape_deviation, probabilities, fine_mean, lights[0] if lights else None)

    def decode(codes: Float[Tensor, "K Z"]) -> Float[Tensor, "K V 3"]:
        return decoder(codes)[0]

    try:
        scene = _scene(manifest)
        faces = torch.tensor(np.array(manifest["faces"], np.int64).reshape(-1, 3))
        centres = torch.tensor(manifest["azimuth_bin_centres_degrees"], dtype=torch.float32).deg2rad()
        training = manifest["training"]
        summary = {"step": training["step"], "seconds": training["run"]["seconds"]}
        views = int(manifest.get("views_per_instance", 1))
        return Subject(infer, decode, faces, centres, scene, str(manifest["category"]), summary, views)
    except (KeyError, TypeError, ValueError, ConfigError) as error:
        raise CheckpointError(
            f"{directory / MANIFEST_FILE}: expected a bundle's manifest, found {type(error).__name__}: {error}. "
            "Export the bundle again."
        ) from error


def _read_manifest(directory: Path) -> dict[str, Any]:
    path = directory / MANIFEST_FILE
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CheckpointError(
            f"Expected a bundle at {directory}, found no {MANIFEST_FILE} that can be read ({error.strerror}). "
            "Name a directory that python -m exporter has written."
        ) from error
    except ValueError as error:
        raise CheckpointError(f"{path}: expected JSON, found {error}. Export the bundle again.") from error
    version = manifest.get("format_version") if isinstance(manifest, dict) else None
    if version != FORMAT_VERSION:
        raise CheckpointError(
            f"{path}: expected format_version {FORMAT_VERSION}, found {str(version)[:40]}. Use the chiaro that wrote "
            "the bundle, or export the model again."
        )
    return dict(manifest)


def _scene(manifest: dict[str, Any]) -> SceneConfig:
    """Camera, lights and size. Raises ConfigError for pictures that have to be prepared in an unknown way."""
    picture = dict(manifest["picture"])
    size = {"zoom": picture.pop("zoom", 1.0), **{side: picture.pop(side) for side in ("width", "height")}}
    if picture != _PREPARATION:
        raise ConfigError(f"pictures are to be prepared as {picture}, expected {_PREPARATION}")
    mapping = size | {key: manifest[key] for key in ("camera", "lights", "ambient")}
    scene = from_mapping(SceneConfig, mapping, "the scene")
    check_scene(scene)
    return scene


def _graph(directory: Path, name: str, manifest: dict[str, Any], outputs: list[str]) -> Run:
    path = directory / name
    try:
        content = path.read_bytes()
    except OSError as error:
        raise CheckpointError(f"{path}: expected a graph, found: {error.strerror}. Export the bundle again.") from error
    files = manifest.get("files")
    expected = files.get(name) if isinstance(files, dict) else None
    if hashlib.sha256(content).hexdigest() != expected:
        raise CheckpointError(
            f"{path}: expected the sha256 that {MANIFEST_FILE} names, found another: the file was altered or belongs "
            "to another model. Export the bundle again."
        )
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.log_severity_level = 4
    try:
        session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
        (entrance,) = [tensor.name for tensor in session.get_inputs()]
        absent = set(outputs) - {tensor.name for tensor in session.get_outputs()}
    except Exception as error:  # onnxruntime's errors share no narrower class
        raise CheckpointError(
            f"{path}: expected a graph that onnxruntime can load, found {error}. Export the bundle again."
        ) from error
    if absent:
        raise CheckpointError(f"{path}: expected the outputs {', '.join(outputs)}, found none called {absent.pop()}.")

    def run(batch: Float[Tensor, "B ..."]) -> list[Tensor]:
        return [torch.from_numpy(output) for output in session.run(outputs, {entrance: batch.numpy()})]

    return run
