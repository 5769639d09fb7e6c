"""Proof that torch and onnxruntime say the same; and how far graphs of lower precision are from it."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from exporter.errors import ExportError
from service.manifest import DECODER_OUTPUTS
from service.thrift import Deviation

LARGEST_ERROR: Final = 1e-4
"""Largest difference that is still rounding: vertices are in diagonals of the object, angles in radians; a normal's
counts by how much the faces around it agree."""

BEST_BINS: Final = {"azimuth": "azimuth_probabilities", "light_azimuth": "light_probabilities"}
"""The outputs that the most probable bin decides, and those that say which it is."""

_VERTICES, _NORMALS = DECODER_OUTPUTS

# Where the two best bins are this close, rounding decides which is best, and either azimuth is right.
_TIE: Final = 1e-5

Array = NDArray[np.float32]


def run_torch(graph: nn.Module, example: Tensor, names: Sequence[str]) -> dict[str, Array]:
    """The outputs of a graph module, by name."""
    with torch.inference_mode():
        outputs = graph.eval()(example)
    return {name: output.numpy() for name, output in zip(names, outputs, strict=True)}


def run_onnx(graph: bytes, example: Tensor, names: Sequence[str]) -> dict[str, Array]:
    """The outputs of an ONNX graph with one input, by name."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"])
    feed = {session.get_inputs()[0].name: example.numpy()}
    return dict(zip(names, session.run(list(names), feed), strict=True))


def measure_parity(
    module: nn.Module,
    graph: bytes,
    examples: Sequence[Tensor],
    names: Sequence[str],
    faces: NDArray[np.int64] | None = None,
) -> dict[str, float]:
    """The largest absolute difference of each output over all examples, which may differ in batch size.

    Where faces [F, 3] around a vertex nearly cancel, rounding of the vertices turns its normal by any angle. So where
    they are given, differences of normals are multiplied by how long the sum of the area vectors is, as a share of the
    sum of their lengths.

    Raises:
        ExportError: a difference is larger than LARGEST_ERROR, or not a number.
    """
    errors = dict.fromkeys(names, 0.0)
    for example in examples:
        expected, found = run_torch(module, example, names), run_onnx(graph, example, names)
        for name in names:
            difference = _difference(name, expected, found, faces)
            # Not max(): it would let a not-a-number pass.
            if not difference <= LARGEST_ERROR:
                raise ExportError(
                    f"{name}: expected torch and onnxruntime to agree within {LARGEST_ERROR:g}, found a difference of "
                    f"{difference:.3g} at batch size {len(example)}; nothing was written: train the model further if "
                    "it holds numbers that are not finite, and else install the versions that pyproject.toml names"
                )
            errors[name] = max(errors[name], difference)
    return errors


def _difference(
    name: str, expected: Mapping[str, Array], found: Mapping[str, Array], faces: NDArray[np.int64] | None
) -> float:
    if expected[name].shape != found[name].shape:
        return math.inf
    difference = _distances(name, expected, found)
    if name in BEST_BINS:
        difference = difference[top_margin(expected[BEST_BINS[name]]) > _TIE]
    if name == _NORMALS and faces is not None:
        difference *= _agreement(expected[_VERTICES], faces)[..., None]
    return float(difference.max(initial=0.0))


def _agreement(vertices: Array, faces: NDArray[np.int64]) -> Array:
    """How much the faces around each vertex agree [B, V], from 0 where they cancel to 1 where they are level."""
    by_vertex = vertices.astype(np.float64).swapaxes(0, 1)
    first, second, third = (by_vertex[corner] for corner in faces.T)
    areas = np.cross(second - first, third - first)
    summed, lengths = np.zeros_like(by_vertex), np.zeros(by_vertex.shape[:2])
    for corner in faces.T:
        np.add.at(summed, corner, areas)
        np.add.at(lengths, corner, np.linalg.norm(areas, axis=2))
    agreement: Array = (np.linalg.norm(summed, axis=2) / np.maximum(lengths, np.finfo(float).tiny)).astype(np.float32).T
    return agreement


def _distances(name: str, expected: Mapping[str, Array], found: Mapping[str, Array]) -> Array:
    difference: Array = np.abs(expected[name] - found[name])
    return np.minimum(difference, np.abs(2 * math.pi - difference)) if name == "azimuth" else difference


def measure_deviations(
    reference: bytes, graph: bytes, example: Tensor, names: Sequence[str]
) -> tuple[dict[str, Deviation], dict[str, float]]:
    """How far a graph's outputs are from those of its reference; and, by angle, the share of examples whose most
    probable bin is the same. Angles are compared where it is."""
    expected, found = run_onnx(reference, example, names), run_onnx(graph, example, names)
    same = {
        angle: expected[bins].argmax(1) == found[bins].argmax(1) for angle, bins in BEST_BINS.items() if angle in names
    }
    deviations = {}
    for name in names:
        distances = _distances(name, expected, found)
        compared = distances[same[name]] if name in same else distances
        largest, mean = (float(compared.max()), float(compared.mean())) if compared.size else (0.0, 0.0)
        deviations[name] = Deviation(largest, mean)
    return deviations, {angle: float(agreeing.mean()) for angle, agreeing in same.items()}


def top_margin(probabilities: Array) -> Array:
    """How far the most probable bin is ahead of the next [B], for probabilities [B, R]; 1 where there is one bin."""
    if probabilities.shape[1] == 1:
        return np.ones(len(probabilities), np.float32)
    ordered = np.sort(probabilities, 1)
    margin: Array = ordered[:, -1] - ordered[:, -2]
    return margin
