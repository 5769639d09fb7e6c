"""A bundle whose graphs are none, or others, or fetch what is not theirs, is refused with a sentence."""

from pathlib import Path

import numpy as np
import onnx
import pytest

from service.bundle import read_bundle
from service.errors import BundleError
from service.inference import load_engine
from tests.service.altered import edit_graph, replace_file


def test_a_graph_that_is_no_graph_is_refused(copy: Path) -> None:
    replace_file(copy, "decoder.onnx", b"not a graph")
    with pytest.raises(BundleError, match=r"decoder.onnx: expected a graph that onnxruntime can load"):
        load_engine(read_bundle(copy))


def test_exchanged_graphs_are_refused(copy: Path) -> None:
    replace_file(copy, "decoder.onnx", (copy / "encoder.onnx").read_bytes())
    with pytest.raises(BundleError, match="expected the tensors shape_codes, vertices, normals, found images"):
        load_engine(read_bundle(copy))


def test_a_graph_with_a_fixed_batch_is_refused(copy: Path) -> None:
    def fix(model: onnx.ModelProto) -> None:
        model.graph.input[0].type.tensor_type.shape.dim[0].dim_value = 2

    edit_graph(copy, "decoder.onnx", fix)
    with pytest.raises(BundleError, match=r"shape_codes: expected float32 \[any batch, 12\], found .*\[2, 12\]"):
        load_engine(read_bundle(copy))


def test_a_graph_of_single_numbers_is_refused(copy: Path) -> None:
    """Found by fuzzing: an output without even a batch axis."""

    def flatten(model: onnx.ModelProto) -> None:
        for output in model.graph.output:
            model.graph.node.append(
                onnx.helper.make_node("ReduceSum", [output.name], [f"{output.name}_sum"], keepdims=0)
            )
            output.name = f"{output.name}_sum"
            output.type.tensor_type.shape.ClearField("dim")
        for node in model.graph.node:
            for names in (node.input, node.output):
                names[:] = [RENAMED.get(name, name) for name in names]
        for output in model.graph.output:
            output.name = RENAMED[output.name]

    edit_graph(copy, "decoder.onnx", flatten)
    with pytest.raises(
        BundleError, match=r"vertices: expected float32 \[any batch, 98, 3\], found tensor\(float\) \[\]"
    ):
        load_engine(read_bundle(copy))


RENAMED = {
    "vertices": "all_vertices",
    "normals": "all_normals",
    "vertices_sum": "vertices",
    "normals_sum": "normals",
}


def test_a_graph_with_names_that_are_no_text_is_refused(copy: Path) -> None:
    """Found by fuzzing: the name of the batch axis."""
    content = (copy / "decoder.onnx").read_bytes()
    (name,) = {
        dimension.dim_param.encode()
        for tensor in onnx.load_model_from_string(content).graph.input
        for dimension in tensor.type.tensor_type.shape.dim
        if dimension.dim_param
    }
    replace_file(copy, "decoder.onnx", content.replace(name, b"\xff" * len(name)))
    with pytest.raises(BundleError, match=r"decoder.onnx: expected a graph that onnxruntime can load, found: .*utf-8"):
        load_engine(read_bundle(copy))


def test_a_stale_graph_is_found_by_the_probe(copy: Path) -> None:
    def turn(model: onnx.ModelProto) -> None:
        weights = max(model.graph.initializer, key=lambda tensor: len(tensor.raw_data))
        values = onnx.numpy_helper.to_array(weights) * np.float32(1.01)
        weights.CopyFrom(onnx.numpy_helper.from_array(values, weights.name))

    edit_graph(copy, "decoder.onnx", turn)
    with pytest.raises(
        BundleError, match=r"vertices: expected the probe's numbers to within 0.001, found a difference"
    ):
        load_engine(read_bundle(copy))


def test_weights_outside_the_graph_are_not_fetched(copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)

    def refer(model: onnx.ModelProto) -> None:
        tensor = max(model.graph.initializer, key=lambda tensor: len(tensor.raw_data))
        (tmp_path / "weights").write_bytes(tensor.raw_data)
        onnx.external_data_helper.set_external_data(tensor, "weights", offset=0, length=len(tensor.raw_data))
        tensor.ClearField("raw_data")

    edit_graph(copy, "decoder.onnx", refer)
    with pytest.raises(
        BundleError, match=r"decoder.onnx: expected a graph that onnxruntime can load, found: .*xternal"
    ):
        load_engine(read_bundle(copy))
