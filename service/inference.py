"""The two graphs of a bundle, run by onnxruntime: picture → pose and shape code → mesh."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
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
    Manifest,
    encoder_outputs,
    tensor_shapes,
)

PROBE_TOLERANCE: Final = 1e-3
"""How far a graph's answer may lie from the probe's on this machine: float32 sums in another order, and no more."""

_LEAST_DEVIATION: Final = 1e-4
"""No training gives a number of the shape code a smaller one; a file may."""

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Engine:
    """A bundle's graphs, ready to run from any thread. The sessions are onnxruntime's, which carry no types."""

    manifest: Manifest
    encoder: Any
    decoder: Any
    faces: NDArray[np.int64]
    """The manifest's faces [F, 3]."""
    latent_activity: tuple[float, ...]
    """How far vertices move (root mean square, diagonals) as a number of the shape code goes from −1 to 1 [Z]."""


@dataclass(frozen=True)
class LightPosterior:
    """What a picture says about the turn λ of its lights; angles in radians."""

    probabilities: Array
    """Probability of each coarse bin [L]."""
    fine_mean: float
    fine_deviation: float
    azimuth: float
    """Centre of the most probable bin plus the fine mean, in [0, π]."""


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
    light: LightPosterior | None
    """None where the lights are fixed."""


@dataclass(frozen=True)
class Surface:
    """A mesh in the object frame: vertices [V, 3] and unit normals [V, 3]; of several, with an axis of them first."""

    vertices: Array
    normals: Array


def load_engine(bundle: Bundle) -> Engine:
    """The graphs of a bundle as sessions, checked against the manifest and the probe.

    Raises:
        BundleError: a graph that onnxruntime cannot load, with other inputs or outputs than the manifest says, or that
            does not reproduce the bundle's probe.
    """
    shapes = tensor_shapes(bundle.manifest)
    outputs = encoder_outputs(bundle.manifest)
    encoder = _session(bundle.encoder, f"{bundle.path / ENCODER_FILE}", [ENCODER_INPUT], outputs, shapes)
    decoder = _session(bundle.decoder, f"{bundle.path / DECODER_FILE}", [DECODER_INPUT], DECODER_OUTPUTS, shapes)
    engine = Engine(bundle.manifest, encoder, decoder, np.array(bundle.manifest.faces, np.int64), ())
    try:
        _check_probe(engine, bundle)
        return replace(engine, latent_activity=_latent_activity(engine))
    except InferenceError as error:
        raise BundleError(f"{bundle.path}: {error}") from error


def encode(engine: Engine, image: Array) -> Posterior:
    """What the encoder says about one picture [3, H, W], linear RGB in 0..1.

    Raises:
        InferenceError: the graph failed, or gave numbers that are not finite.
    """
    outputs = encoder_outputs(engine.manifest)
    found = dict(zip(outputs, _run(engine.encoder, outputs, {ENCODER_INPUT: image[None]}), strict=True))
    light = None
    if "light_azimuth" in found:
        light = LightPosterior(
            probabilities=found["light_probabilities"][0],
            fine_mean=float(found["light_fine_mean"][0]),
            fine_deviation=float(found["light_fine_deviation"][0]),
            azimuth=float(found["light_azimuth"][0]),
        )
    return Posterior(
        shape_mean=found["shape_mean"][0],
        shape_deviation=found["shape_deviation"][0],
        azimuth_probabilities=found["azimuth_probabilities"][0],
        azimuth_fine_mean=float(found["azimuth_fine_mean"][0]),
        azimuth_fine_deviation=float(found["azimuth_fine_deviation"][0]),
        azimuth=float(found["azimuth"][0]),
        light=light,
    )


def decode(engine: Engine, shape_code: Array) -> Surface:
    """The mesh of one shape code [Z].

    Raises:
        InferenceError: the graph failed, or gave numbers that are not finite.
    """
    surfaces = decode_all(engine, shape_code[None])
    return Surface(surfaces.vertices[0], surfaces.normals[0])


def decode_all(engine: Engine, shape_codes: Array) -> Surface:
    """The meshes of several shape codes [K, Z] at once: vertices and normals [K, V, 3].

    Raises:
        InferenceError: the graph failed, or gave numbers that are not finite.
    """
    vertices, normals = _run(engine.decoder, DECODER_OUTPUTS, {DECODER_INPUT: shape_codes})
    return Surface(vertices, normals)


def pool(posteriors: Sequence[Posterior], views_per_instance: int) -> tuple[Array, Array]:
    """Mean and deviation of the shape code [Z] of an object in several pictures.

    Of a model whose training pooled them, number by number the largest over all of them, as there (section 4 of the
    paper, "Shape"). Of one that was trained on single pictures, those of the geometric mean of their densities: the
    surer a picture is of a number, the more it counts. They are not multiplied, since an encoder errs alike in all.
    """
    means = np.stack([posterior.shape_mean for posterior in posteriors])
    deviations = np.stack([posterior.shape_deviation for posterior in posteriors])
    if views_per_instance > 1 or len(posteriors) == 1:
        return means.max(0), deviations.max(0)
    # In float64: the mean of equal codes is that code, to the last digit.
    precisions = deviations.clip(_LEAST_DEVIATION).astype(np.float64) ** -2
    mean = (precisions * means).sum(0) / precisions.sum(0)
    return mean.astype(np.float32), (precisions.mean(0) ** -0.5).astype(np.float32)


def sample_shape_code(seed: int, latent: int, temperature: float = 1.0) -> Array:
    """A shape code [Z] from N(0, temperature² I), the prior at temperature 1; the same seed in 0..2³²−1 gives the same
    code on every machine."""
    # RandomState's streams are frozen by NumPy (NEP 19); those of Generator may change with a release.
    return (temperature * np.random.RandomState(seed).standard_normal(latent)).astype(np.float32)


def _session(
    graph: bytes, where: str, inputs: Sequence[str], outputs: Sequence[str], shapes: dict[str, tuple[int, ...]]
) -> Any:
    options = onnxruntime.SessionOptions()
    # One thread a request: requests run beside each other, and onnxruntime's threads spin while they wait.
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    # onnxruntime would keep the memory of every model's largest moment; thirteen models then need 45 MB more.
    options.enable_cpu_mem_arena = False
    options.log_severity_level = 4
    # Weights stand inside the graph: a reference to another file finds an impossible folder.
    options.add_session_config_entry("session.model_external_initializers_file_folder_path", "/dev/null")
    try:
        # There is nothing to fall back on: else it would print so, and try the same once more.
        session = onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"], enable_fallback=0)
        taken = {tensor.name: (tensor.type, tensor.shape) for tensor in session.get_inputs()}
        given = {tensor.name: (tensor.type, tensor.shape) for tensor in session.get_outputs()}
    except Exception as error:  # onnxruntime's errors share no narrower class
        raise BundleError(
            f"{where}: expected a graph that onnxruntime can load, found: {_first_line(error)}; export the bundle again"
        ) from None
    # It keeps the graph for a change of providers, of which there is one: thirteen models would take 55 MB more.
    session._model_bytes = b""
    if set(taken) != set(inputs) or set(given) != set(outputs):
        raise BundleError(
            f"{where}: expected the tensors {', '.join((*inputs, *outputs))}, "
            f"found {', '.join((*taken, *given))[:300]}; export the bundle again"
        )
    for name, (kind, shape) in {**taken, **given}.items():
        batch, rest = shape[:1], tuple(shape[1:])
        if kind != "tensor(float)" or not batch or isinstance(batch[0], int) or rest != shapes[name]:
            raise BundleError(
                f"{where}: {name}: expected float32 [any batch, {', '.join(map(str, shapes[name]))}], "
                f"found {kind} {shape}; export the bundle again"
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
    probe, outputs = bundle.probe, encoder_outputs(bundle.manifest)
    encoded = _run(engine.encoder, outputs, {ENCODER_INPUT: probe[ENCODER_INPUT]})
    decoded = _run(engine.decoder, DECODER_OUTPUTS, {DECODER_INPUT: probe[DECODER_INPUT]})
    found = dict(zip((*outputs, *DECODER_OUTPUTS), (*encoded, *decoded), strict=True))
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


def _latent_activity(engine: Engine) -> tuple[float, ...]:
    latent = engine.manifest.latent
    activity = []
    for dimension in range(latent):
        ends = np.zeros((2, latent), np.float32)
        ends[:, dimension] = -1, 1
        vertices = _run(engine.decoder, DECODER_OUTPUTS, {DECODER_INPUT: ends})[0].astype(np.float64)
        activity.append(float(np.sqrt(((vertices[1] - vertices[0]) ** 2).sum(-1).mean())))
    return tuple(activity)


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0][:300] if str(error).strip() else type(error).__name__
