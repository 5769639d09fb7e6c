"""Graphs of lower precision: weights stored as float16, or an encoder of 8-bit integers. Inputs and outputs are not."""

import logging
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Literal, NamedTuple

import numpy as np
import onnx
from jaxtyping import Float32
from numpy import ndarray
from onnx import TensorProto, helper, numpy_helper
from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static

from service.manifest import ENCODER_INPUT

PrecisionName = Literal["float32", "float16", "int8"]

# Biases and constants are hardly any of the bytes.
_LEAST_WEIGHTS: Final = 64
_QUANTISED: Final = ("Conv", "Gemm", "MaxPool")
_HEADS: Final = ".heads."
_HALF, _WIDENED = ".half", ".widened"


class Graphs(NamedTuple):
    """A bundle's two graphs, serialised."""

    encoder: bytes
    decoder: bytes


def lowered(graphs: Graphs, precision: Literal["float16", "int8"], calibration: Float32[ndarray, "N 3 H W"]) -> Graphs:
    """Float32 graphs in another precision. With int8 the decoder stays as it is, and samples with it."""
    match precision:
        case "float16":
            return Graphs(_stored_in_half(graphs.encoder), _stored_in_half(graphs.decoder))
        case "int8":
            return Graphs(_quantised(graphs.encoder, calibration), graphs.decoder)


def _stored_in_half(graph: bytes) -> bytes:
    """The same graph with weights in float16, each widened where it is used: onnxruntime does that once, as it loads.

    It computes in float32 as before. Most processors have no arithmetic in float16: a graph of that type would be
    converted back and forth at every node.
    """
    model = onnx.load_from_string(graph)
    casts = []
    for tensor in model.graph.initializer:
        if tensor.data_type == TensorProto.FLOAT and np.prod(tensor.dims) >= _LEAST_WEIGHTS:
            name, half = tensor.name, f"{tensor.name}{_HALF}"
            tensor.CopyFrom(numpy_helper.from_array(numpy_helper.to_array(tensor).astype(np.float16), half))
            casts.append(helper.make_node("Cast", [half], [name], f"{name}{_WIDENED}", to=TensorProto.FLOAT))
    return _with_nodes(model, [*casts, *model.graph.node])


def widened(graph: bytes) -> bytes:
    """The same graph with the weights that are stored in float16 as what they are widened to; any other as it is."""
    model = onnx.load_from_string(graph)
    names = {node.input[0]: node.output[0] for node in model.graph.node if node.name.endswith(_WIDENED)}
    for tensor in model.graph.initializer:
        if tensor.name in names:
            tensor.CopyFrom(
                numpy_helper.from_array(numpy_helper.to_array(tensor).astype(np.float32), names[tensor.name])
            )
    return _with_nodes(model, [node for node in model.graph.node if not node.name.endswith(_WIDENED)])


def _with_nodes(model: onnx.ModelProto, nodes: list[onnx.NodeProto]) -> bytes:
    del model.graph.node[:]
    model.graph.node.extend(nodes)
    content: bytes = model.SerializeToString(deterministic=True)
    return content


def _quantised(encoder: bytes, calibration: Float32[ndarray, "N 3 H W"]) -> bytes:
    """The same encoder with 8-bit weights, per channel, and activations, in the ranges that the pictures show.

    The layers that give the posterior's parameters stay float32: they are one weight in a hundred. Weights use seven of
    the bits: with eight, processors that have no VNNI saturate in the middle of a sum, and answer something else than
    those that have it.
    """
    model = onnx.load_from_string(encoder)
    heads = [node.name for node in model.graph.node if any(_HEADS in name for name in node.input)]
    with _without_advice(), tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "encoder.onnx"
        quantize_static(
            model,
            path,
            _Pictures(calibration),
            quant_format=QuantFormat.QDQ,
            op_types_to_quantize=list(_QUANTISED),
            nodes_to_exclude=heads,
            per_channel=True,
            reduce_range=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
        )
        return path.read_bytes()


@contextmanager
def _without_advice() -> Iterator[None]:
    """Keeps back onnxruntime's advice to fold constants and infer shapes first: torch's exporter has done so."""

    def other(record: logging.LogRecord) -> bool:
        return "pre-processing" not in record.getMessage()

    root = logging.getLogger()
    root.addFilter(other)
    try:
        yield
    finally:
        root.removeFilter(other)


class _Pictures(CalibrationDataReader):  # type: ignore[misc]
    """Pictures one by one, as onnxruntime asks for them."""

    def __init__(self, pictures: Float32[ndarray, "N 3 H W"]) -> None:
        self.feeds: Iterator[dict[str, ndarray]] = ({ENCODER_INPUT: picture[None]} for picture in pictures)

    def get_next(self) -> dict[str, ndarray] | None:
        return next(self.feeds, None)
