"""Bundles that are altered, foreign or hostile are refused with a sentence that says what to do."""

import hashlib
import io
import json
import os
import shutil
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest

from service.bundle import Bundle, read_bundle
from service.catalogue import read_catalogue
from service.errors import BundleError
from service.inference import load_engine
from service.manifest import decode_manifest, encode_manifest, model_identity


@pytest.fixture
def copy(bundle_directory: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(bundle_directory, tmp_path / "copy"))


def edit_manifest(directory: Path, edit: Callable[[dict[str, Any]], object]) -> None:
    manifest = json.loads((directory / "manifest.json").read_text())
    edit(manifest)
    (directory / "manifest.json").write_text(json.dumps(manifest))


def replace_file(directory: Path, name: str, content: bytes) -> None:
    """Replaces a file as its author would: digest and identity follow."""
    (directory / name).write_bytes(content)

    def adopt(manifest: dict[str, Any]) -> None:
        manifest["files"][name] = hashlib.sha256(content).hexdigest()
        manifest["identity"] = model_identity(manifest["files"])

    edit_manifest(directory, adopt)


def edit_graph(directory: Path, name: str, edit: Callable[[onnx.ModelProto], object]) -> None:
    model = onnx.load(directory / name)
    edit(model)
    replace_file(directory, name, model.SerializeToString())


def replace_probe(directory: Path, **arrays: np.ndarray) -> None:
    with np.load(directory / "probe.npz") as archive:
        content = {**archive, **arrays}
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=True, **content)
    replace_file(directory, "probe.npz", buffer.getvalue())


def test_manifest_survives_the_round_trip(bundle: Bundle) -> None:
    assert decode_manifest(encode_manifest(bundle.manifest), "here") == bundle.manifest


def test_a_whole_bundle_is_proven(copy: Path) -> None:
    (copy / "README.md").write_text("other files do not matter")
    assert load_engine(read_bundle(copy)).manifest.category == "car"


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (lambda m: m.update(format_version=2), "expected format_version 1, found 2"),
        (lambda m: m.update(format_version=True), "expected format_version 1, found True"),
        (lambda m: m.pop("format_version"), "expected format_version 1, found None"),
        (lambda m: m.update(surprise=1), "surprise: "),
        (lambda m: m.pop("camera"), "camera: "),
        (lambda m: m["camera"].update(distance=-1), r"camera.distance: .*greater than 0.* found -1"),
        (lambda m: m["picture"].update(width=10**6), "picture.width: "),
        (lambda m: m["conventions"].update(frame="Z up"), "conventions.frame: .*Z up"),
        (lambda m: m.update(category="../../etc"), "category: "),
        (lambda m: m.update(latent="12"), "latent: .*found 12"),
        (lambda m: m["faces"].append([0, 1, 98]), "vertices 0 to 97, found 98"),
        (lambda m: m["faces"].append([0, 1, 2]), "blocks should cover 193 faces, found 192"),
        (lambda m: m["blocks"][0].update(first_face=1), "begin at face 0, found 1"),
        (lambda m: m["files"].update({"../../../etc/passwd": "0" * 64}), "files should name just"),
        (lambda m: m["files"].pop("probe.npz"), "files should name just"),
        (lambda m: m["files"].update({"encoder.onnx": "0" * 64}), "identity does not belong"),
        (lambda m: m["files"].update({"probe.npz": "0" * 64}), "probe.npz: expected sha256 000000000000…, found"),
        (
            lambda m: m.update(latent=13, parsimony=None),
            r"shape_mean: expected float32 \[1 to 16, 13\], found float32 \[2, 12\]",
        ),
        (lambda m: m.update(vertices=99), r"vertices: expected float32 \[1 to 16, 99, 3\]"),
        (lambda m: m.update(held_out={"pictures": 20}), "held_out.framed: "),
        (
            lambda m: m.update(held_out={"pictures": 20, "framed": {"median": 0.2, "high": 0.2}, "fitted": None}),
            "held_out: expected a median below the high error, found 0.2 and 0.2",
        ),
        (lambda m: m["azimuth_bin_centres_degrees"].pop(), r"azimuth_probabilities: expected float32 \[1 to 16, 11\]"),
    ],
)
def test_a_wrong_manifest_is_refused(copy: Path, edit: Callable[[dict[str, Any]], object], sentence: str) -> None:
    edit_manifest(copy, edit)
    with pytest.raises(BundleError, match=sentence) as caught:
        read_bundle(copy)
    assert "export" in str(caught.value)


@pytest.mark.parametrize("text", [b"", b"\xff\xfe", b"[1]", b"{", b'{"format_version": NaN}', b"[" * 100_000])
def test_a_manifest_that_is_no_manifest_is_refused(copy: Path, text: bytes) -> None:
    (copy / "manifest.json").write_bytes(text)
    with pytest.raises(BundleError, match=r"expected (JSON|format_version 1), found"):
        read_bundle(copy)


@pytest.mark.parametrize("name", ["manifest.json", "encoder.onnx", "decoder.onnx", "probe.npz"])
def test_a_missing_file_is_refused(copy: Path, name: str) -> None:
    (copy / name).unlink()
    with pytest.raises(BundleError, match=f"{name}: expected a regular file .* found: No such file"):
        read_bundle(copy)


@pytest.mark.parametrize("name", ["encoder.onnx", "decoder.onnx", "probe.npz"])
def test_one_altered_bit_is_refused(copy: Path, name: str) -> None:
    content = bytearray((copy / name).read_bytes())
    content[len(content) // 2] ^= 1
    (copy / name).write_bytes(content)
    with pytest.raises(BundleError, match=f"{name}: expected sha256 .* was altered"):
        read_bundle(copy)


def test_links_pipes_and_directories_are_refused(copy: Path, tmp_path: Path) -> None:
    path = copy / "encoder.onnx"
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(
        BundleError, match=r"encoder.onnx: expected a regular file .* found: Too many levels of symbolic"
    ):
        read_bundle(copy)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(BundleError, match=r"encoder.onnx: expected a regular file .* found: Not a regular file"):
        read_bundle(copy)
    path.unlink()
    path.mkdir()
    with pytest.raises(BundleError, match=r"encoder.onnx: expected a regular file .* found: Not a regular file"):
        read_bundle(copy)


def test_a_huge_file_is_refused_before_it_is_read(copy: Path) -> None:
    with (copy / "manifest.json").open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(BundleError, match=r"manifest.json: expected at most 16777216 bytes, found more"):
        read_bundle(copy)


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


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        ({"vertices": np.zeros((2, 98, 3))}, r"vertices: expected float32 .* found float64"),
        ({"vertices": np.zeros((3, 98, 3), np.float32)}, "one batch size, found"),
        ({"vertices": np.zeros((99, 98, 3), np.float32)}, "vertices: expected at most .* bytes, found"),
        ({"azimuth": np.full(2, np.nan, np.float32)}, "azimuth: expected finite numbers"),
        ({"surprise": np.zeros(2, np.float32)}, "expected the arrays .* surprise.npy"),
        ({"azimuth": np.array([{}, {}], object)}, "azimuth: expected float32 .* found object"),
        ({"shape_codes": np.asfortranarray(np.zeros((2, 12), np.float32))}, r"shape_codes: expected float32 \[1 to 16"),
    ],
)
def test_a_wrong_probe_is_refused(copy: Path, arrays: dict[str, np.ndarray], sentence: str) -> None:
    replace_probe(copy, **arrays)
    with pytest.raises(BundleError, match=sentence):
        read_bundle(copy)


def replace_probe_file(directory: Path, name: str, data: bytes) -> None:
    """Replaces one file of the probe's archive."""
    with zipfile.ZipFile(directory / "probe.npz") as archive:
        content = {member: archive.read(member) for member in archive.namelist()}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for member, old in content.items():
            archive.writestr(member, data if member == name else old)
    replace_file(directory, "probe.npz", buffer.getvalue())


def test_a_probe_that_claims_to_be_huge_is_refused(copy: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": (2, 10**12)})
    replace_probe_file(copy, "shape_codes.npy", header.getvalue())
    with pytest.raises(BundleError, match=r"shape_codes: expected float32 .* found float32 \[2, 1000000000000\]"):
        read_bundle(copy)


@pytest.mark.parametrize(
    "header",
    [
        # Found by fuzzing: numpy takes it for a header that Python 2 wrote, and answers with an error of its tokenizer.
        b"{'descr': '<f4', 'fortran_order': False, 'shape': (2, 12",
        b"'",
        b"",
        b"(" * 500,
        b"{'descr': 'V', 'fortran_order': 0, 'shape': ()}",
    ],
)
def test_a_probe_with_a_broken_header_is_refused(copy: Path, header: bytes) -> None:
    replace_probe_file(copy, "shape_codes.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
    with pytest.raises(BundleError, match=r"probe.npz: shape_codes: expected (a NumPy array|float32 .*), found"):
        read_bundle(copy)


def test_a_catalogue_reads_one_bundle_or_many(
    bundle_directory: Path, second_bundle_directory: Path, tmp_path: Path
) -> None:
    assert [b.manifest.category for b in read_catalogue(bundle_directory).bundles] == ["car"]
    shutil.copytree(bundle_directory, tmp_path / "a")
    shutil.copytree(second_bundle_directory, tmp_path / "b")
    (tmp_path / ".c.partial").mkdir()
    assert [b.manifest.category for b in read_catalogue(tmp_path).bundles] == ["car", "chair"]
    shutil.copytree(bundle_directory, tmp_path / "d")
    with pytest.raises(BundleError, match="expected one bundle a category, found a and d for car; remove one"):
        read_catalogue(tmp_path)


def test_a_catalogue_without_bundles_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BundleError, match="found neither; name another directory with --models"):
        read_catalogue(tmp_path)
    with pytest.raises(BundleError, match="found no directory"):
        read_catalogue(tmp_path / "absent")
