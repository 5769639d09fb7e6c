"""From a torch module to an ONNX graph in memory."""

import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Final

import onnx
import torch
from torch import Tensor, nn

OPSET: Final = 20


def to_onnx(module: nn.Module, example: Tensor, input_name: str, output_names: Sequence[str]) -> bytes:
    """The ONNX graph of a module with one input: batch axis of any size, weights inside.

    `example` is an input with a batch of at least two.
    """
    module.eval()
    with _without_known_noise():
        program = torch.onnx.export(
            module,
            (example,),
            dynamo=True,
            input_names=[input_name],
            output_names=list(output_names),
            opset_version=OPSET,
            dynamic_shapes=({0: torch.export.Dim("batch")},),
            external_data=False,
            verbose=False,
        )
    if program is None:
        raise RuntimeError("torch.onnx.export with dynamo=True returns the program; it returned nothing")
    content: bytes = _without_traces(program.model_proto).SerializeToString(deterministic=True)
    return content


def _without_traces(model: onnx.ModelProto) -> onnx.ModelProto:
    """The same graph without the paths, names and stack traces of the machine and the code that it came from.

    A graph then depends on the model alone, and so does its digest.
    """
    graph = model.graph
    for part in (model, graph, *graph.node, *graph.initializer, *graph.input, *graph.output, *graph.value_info):
        part.ClearField("metadata_props")
        part.ClearField("doc_string")
    return model


@contextmanager
def _without_known_noise() -> Iterator[None]:
    """Keeps two messages back that torch addresses to itself: torchvision's absence, and a deprecation inside copy."""
    registration = logging.getLogger("torch.onnx._internal.exporter._registration")
    level = registration.level
    registration.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", r".*isinstance\(treespec, LeafSpec\).* is deprecated", FutureWarning)
            yield
    finally:
        registration.setLevel(level)
