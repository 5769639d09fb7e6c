"""The two graphs of a bundle, run by onnxruntime: picture → pose and shape code → mesh."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from service.bundle import Bundle
from service.errors import BundleError, InferenceError
from service.manifest import (
    DECODER_FILE,
    DECODER_INPUT,
    DECODER_OUTPUTS,
    ENCODER_FILE,
    ENCODER_INPUT,
    ENCODER_OUTPUTS,
    Manifest,
    tensor_shapes,
)

PROBE_TOLERANCE: Final = 1e-3
"""How far a graph's answer may lie from the probe's on this machine: float32 sums in another order, and no more."""

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Engine:
    """A bundle's graphs, ready to run from any thread. The sessions are onnxruntime's, which carry no types."""

    manifest: Manifest
    encoder: Any
    decoder: Any


@dataclass(frozen=True)
class Posterior:
    """What a picture says about pose and shape; angles in radians, relative to the camera."""

    shape_mean: Array
    """Mean of the shape code z [Z]."""
    shape_deviation: Array
    """Standard deviation of z [Z]."""
    azimuth_probabilities: Array
    """Probability of each coarse azimuth bin [R]."""
    azimuth_fine_mean: float
    azimuth_fine_deviation: float
    azimuth: float
    """Centre of the most probable bin plus the fine mean, in [-π, π)."""


@dataclass(frozen=True)
class Surface:
    """A mesh in the object frame: vertices [V, 3] and unit normals [V, 3]."""

    vertices: Array
    normals: Array


def load_engine(bundle: Bundle) -> Engine:
    """The graphs of a bundle as sessions, checked against the manifest and the probe.

    Raises:
        BundleError: a graph that onnxruntime cannot load, with other inputs or outputs than the manifest says, or that
            does not reproduce the bundle's probe.
    """
    shapes = tensor_shapes(bundle.manifest)
    encoder = _session(bundle.encoder, f"{bundle.path / ENCODER_FILE}", [ENCODER_INPUT], ENCODER_OUTPUTS, shapes)
    decoder = _session(bundle.decoder, f"{bundle.path / DECODER_FILE}", [DECODER_INPUT], DECODER_OUTPUTS, shapes)
    engine = Engine(bundle.manifest, encoder, decoder)
    _check_probe(engine, bundle)
    return engine


def encode(engine: Engine, image: Array) -> Posterior:
    """What the encoder says about one picture [3, H, W], linear RGB in 0..1.

    Raises:
        InferenceError: the graph failed, or gave numbers that are not finite.
    """
    mean, deviation, probabilities, fine_mean, fine_deviation, azimuth = _run(
        engine.encoder, ENCODER_OUTPUTS, {ENCODER_INPUT: image[None]}
    )
    return Posterior(
        shape_mean=mean[0],
        shape_deviation=deviation[0],
        azimuth_probabilities=probabilities[0],
        azimuth_fine_mean=float(fine_mean[0]),
        azimuth_fine_deviation=float(fine_deviation[0]),
        azimuth=float(azimuth[0]),
    )


def decode(engine: Engine, shape_code: Array) -> Surface:
    """The mesh of one shape code [Z].

    Raises:
        InferenceError: the graph failed, or gave numbers that are not finite.
    """
    vertices, normals = _run(engine.decoder, DECODER_OUTPUTS, {DECODER_INPUT: shape_code[None]})
    return Surface(vertices[0], normals[0])


def sample_shape_code(seed: int, latent: int) -> Array:
    """A shape code [Z] from the prior N(0, I); the same seed in 0..2³²−1 gives the same code on every machine."""
    # RandomState's streams are frozen by NumPy (NEP 19); those of Generator may change with a release.
    return np.random.RandomState(seed).standard_normal(latent).astype(np.float32)


def _session(
    graph: bytes, where: str, inputs: Sequence[str], outputs: Sequence[str], shapes: dict[str, tuple[int, ...]]
) -> Any:
    options = onnxruntime.SessionOptions()
    # One thread a request: requests run beside each other, and onnxruntime's threads spin while they wait.
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    # Weights stand inside the graph: a reference to another file finds an impossible folder.
    options.add_session_config_entry("session.model_external_initializers_file_folder_path", "/dev/null")
    try:
        session = onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's errors share no narrower class
        raise BundleError(
            f"{where}: expected a graph that onnxruntime can load, found: {_first_line(error)}; export the bundle again"
        ) from None
    found = {tensor.name: tensor for tensor in (*session.get_inputs(), *session.get_outputs())}
    if {t.name for t in session.get_inputs()} != set(inputs) or {t.name for t in session.get_outputs()} != set(outputs):
        raise BundleError(
            f"{where}: expected the tensors {', '.join((*inputs, *outputs))}, found {', '.join(found)[:300]}; "
            "export the bundle again"
        )
    for name, tensor in found.items():
        batch, *shape = tensor.shape
        if tensor.type != "tensor(float)" or isinstance(batch, int) or tuple(shape) != shapes[name]:
            raise BundleError(
                f"{where}: {name}: expected float32 [any batch, {', '.join(map(str, shapes[name]))}], "
                f"found {tensor.type} {tensor.shape}; export the bundle again"
            )
    return session


def _run(session: Any, outputs: Sequence[str], feed: dict[str, Array]) -> list[Array]:
    try:
        results: list[Array] = session.run(list(outputs), feed)
    except Exception as error:  # onnxruntime's errors share no narrower class
        raise InferenceError(f"the graph failed: {_first_line(error)}; export the bundle again") from error
    for name, result in zip(outputs, results, strict=True):
        if not np.isfinite(result).all():
            raise InferenceError(f"{name}: expected finite numbers, found others; train and export the model again")
    return results


def _check_probe(engine: Engine, bundle: Bundle) -> None:
    """The graphs must give on this machine what they gave where they were exported."""
    probe = bundle.probe
    try:
        found = dict(
            zip(
                ENCODER_OUTPUTS,
                _run(engine.encoder, ENCODER_OUTPUTS, {ENCODER_INPUT: probe[ENCODER_INPUT]}),
                strict=True,
            )
        )
        found.update(
            zip(
                DECODER_OUTPUTS,
                _run(engine.decoder, DECODER_OUTPUTS, {DECODER_INPUT: probe[DECODER_INPUT]}),
                strict=True,
            )
        )
    except InferenceError as error:
        raise BundleError(f"{bundle.path}: {error}") from error
    for name, result in found.items():
        difference = np.abs(result - probe[name]) if result.shape == probe[name].shape else np.array(math.inf)
        if name == "azimuth":
            difference = np.minimum(difference, np.abs(2 * math.pi - difference))
        worst = float(difference.max())
        if not worst <= PROBE_TOLERANCE:
            raise BundleError(
                f"{bundle.path}: {name}: expected the probe's numbers to within {PROBE_TOLERANCE:g}, found "
                f"a difference of {worst:.3g}: the graphs are not those that were exported, or run wrongly here; "
                "export the bundle again"
            )
    lengths = np.linalg.norm(found["normals"], axis=-1)
    if np.abs(lengths - 1).max() > PROBE_TOLERANCE:
        raise BundleError(
            f"{bundle.path}: expected unit normals, found lengths of {lengths.min():.3g} to "
            f"{lengths.max():.3g}; export the bundle again"
        )


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0][:300] if str(error).strip() else type(error).__name__
