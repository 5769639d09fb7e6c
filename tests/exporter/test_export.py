"""From checkpoint to bundle: what is written is proven, whole, and depends on the model alone."""

import dataclasses
import json
import math
import resource
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch

import exporter.assembly
from exporter.conversion import to_onnx
from exporter.errors import ExportError
from exporter.export import export
from exporter.graphs import DecoderGraph, EncoderGraph
from exporter.parity import LARGEST_ERROR, measure_parity
from service.bundle import read_bundle
from service.manifest import ENCODER_OUTPUTS, Camera
from tests.exporter.conftest import OFFSET
from trainer.errors import StorageError
from trainer.training.checkpoint import Checkpoint


def content(directory: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in directory.iterdir()}


@contextmanager
def largest_file(limit: int) -> Iterator[None]:
    """The operating system refuses to let any file grow beyond `limit` bytes, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_the_manifest_tells_what_the_model_is(checkpoint: Checkpoint, exported: Path) -> None:
    manifest = read_bundle(exported).manifest
    assert manifest.category == "car"
    assert manifest.camera == Camera(20.0, 2.0, 30.0)
    assert (manifest.picture.width, manifest.picture.height) == (64, 48)
    assert (manifest.latent, manifest.vertices, len(manifest.faces)) == (5, 98, 192)
    assert manifest.faces == tuple(map(tuple, checkpoint.model.faces.tolist()))
    assert [block.name for block in manifest.blocks] == ["body"]
    assert manifest.azimuth_offset_degrees == 25
    step = 360 / 7
    expected = [math.remainder(-180 + step * r + 25, 360) for r in range(7)]
    assert manifest.azimuth_bin_centres_degrees == pytest.approx(expected, abs=1e-9)
    assert [light.azimuth_degrees for light in manifest.lights] == [30, 150, 270]
    assert manifest.views_per_instance == 1
    assert manifest.metrics == {"iou": 0.6}
    assert manifest.training["step"] == 12
    assert manifest.training["run"] == {
        "seconds": 1.5,
        "validation": {"likelihood": -3.0},
        "images": "cars",
        "fresh": {"meshes": "meshes", "rig": "colour"},
    }
    assert set(manifest.parity) == {*ENCODER_OUTPUTS, "vertices", "normals"}
    assert 0 < max(manifest.parity.values()) <= LARGEST_ERROR


def test_the_graphs_hold_weights_and_nothing_of_the_machine(exported: Path) -> None:
    for name in ("encoder.onnx", "decoder.onnx"):
        data = (exported / name).read_bytes()
        assert b".py" not in data
        assert str(Path(__file__).parents[2]).encode() not in data
        model = onnx.load_from_string(data)
        onnx.checker.check_model(model, full_check=True)
        assert model.opset_import[0].version >= 20
        assert not any(tensor.external_data for tensor in model.graph.initializer)
        for tensor in (*model.graph.input, *model.graph.output):
            assert tensor.type.tensor_type.shape.dim[0].dim_param == "batch"


@pytest.mark.parametrize("batch", [1, 3, 33])
def test_onnxruntime_says_what_torch_says(checkpoint: Checkpoint, exported: Path, batch: int) -> None:
    """Against the model itself, for every batch size, and with other inputs than the export's own."""
    offset = math.radians(25)
    images, shape_codes = torch.rand(batch, 3, 48, 64), torch.randn(batch, 5)
    encoder = onnxruntime.InferenceSession(exported / "encoder.onnx")
    decoder = onnxruntime.InferenceSession(exported / "decoder.onnx")
    with torch.no_grad():
        posterior = checkpoint.model.encode(images)
        expected = [
            *EncoderGraph(checkpoint.model, offset)(images),
            *DecoderGraph(checkpoint.model, offset)(shape_codes),
        ]
    found = [
        *encoder.run(None, {"images": images.numpy()}),
        *decoder.run(None, {"shape_codes": shape_codes.numpy()}),
    ]
    np.testing.assert_allclose(found[0], posterior.shape_mean, atol=1e-5)
    np.testing.assert_allclose(found[1], posterior.shape_deviation, atol=1e-5)
    np.testing.assert_allclose(found[2], posterior.azimuth_logits.softmax(1), atol=1e-5)
    for actual, reference in zip(found, expected, strict=True):
        np.testing.assert_allclose(actual, reference, atol=1e-5)


def test_the_same_model_gives_the_same_bundle(checkpoint: Checkpoint, exported: Path, tmp_path: Path) -> None:
    again = export(checkpoint, tmp_path / "again", math.radians(25), {"iou": 0.6})
    assert content(tmp_path / "again") == content(exported)
    with torch.no_grad():
        checkpoint.model.heads.shape_mean.bias[0] += 0.001
    assert export(checkpoint, tmp_path / "other", math.radians(25), {"iou": 0.6}).identity != again.identity


def test_a_graph_of_another_model_is_refused(checkpoint: Checkpoint) -> None:
    pictures = [torch.rand(2, 3, 48, 64)]
    module = EncoderGraph(checkpoint.model, 0.0)
    stale = to_onnx(EncoderGraph(checkpoint.model, 0.01), pictures[0], "images", ENCODER_OUTPUTS)
    with pytest.raises(
        ExportError, match=r"azimuth: expected torch and onnxruntime to agree within 0.0001, found .* 0.01"
    ):
        measure_parity(module, stale, pictures, ENCODER_OUTPUTS)
    whole_turn = to_onnx(EncoderGraph(checkpoint.model, 2 * math.pi), pictures[0], "images", ENCODER_OUTPUTS)
    assert max(measure_parity(module, whole_turn, pictures, ENCODER_OUTPUTS).values()) < 1e-5


def test_weights_that_are_not_finite_are_refused(checkpoint: Checkpoint, tmp_path: Path) -> None:
    with torch.no_grad():
        checkpoint.model.decoder.displacements.bias[7] = math.nan
    with pytest.raises(
        ExportError, match=r"vertices: expected torch and onnxruntime to agree .* found a difference of nan"
    ):
        export(checkpoint, tmp_path / "car", 0.0, {})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("converted")
def test_a_category_that_is_no_word_is_refused(checkpoint: Checkpoint, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"category: .* found my car"):
        export(dataclasses.replace(checkpoint, category="my car"), tmp_path / "car", OFFSET, {})
    with pytest.raises(ExportError, match="the run's summary: expected JSON with finite numbers"):
        export(dataclasses.replace(checkpoint, run={"loss": math.inf}), tmp_path / "car", OFFSET, {})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("converted")
def test_a_full_disk_leaves_the_old_bundle_and_nothing_else(
    checkpoint: Checkpoint, exported: Path, tmp_path: Path
) -> None:
    target = tmp_path / "car"
    with largest_file(10_000), pytest.raises(StorageError, match=r"found: File too large; nothing was changed there"):
        export(checkpoint, target, OFFSET, {})
    assert list(tmp_path.iterdir()) == []
    shutil.copytree(exported, target)
    before = content(target)
    with largest_file(10_000), pytest.raises(StorageError):
        export(checkpoint, target, OFFSET, {})
    assert content(target) == before
    assert list(tmp_path.iterdir()) == [target]


def test_a_bundle_that_is_there_is_replaced(checkpoint: Checkpoint, exported: Path, tmp_path: Path) -> None:
    target = tmp_path / "car"
    shutil.copytree(exported, target)
    export(checkpoint, target, 0.5, {})
    assert read_bundle(target).manifest.azimuth_offset_degrees == pytest.approx(math.degrees(0.5))
    assert list(tmp_path.iterdir()) == [target]
    assert target.stat().st_mode & 0o777 == 0o755


def test_what_is_no_bundle_is_never_replaced(checkpoint: Checkpoint, tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "holiday.jpg").write_bytes(b"dear")
    with pytest.raises(ExportError, match=r"expected nothing, an empty directory or a bundle there, found holiday.jpg"):
        export(checkpoint, tmp_path / "photos", 0.0, {})
    with pytest.raises(ExportError, match="found a file"):
        export(checkpoint, tmp_path / "photos" / "holiday.jpg", 0.0, {})
    assert (tmp_path / "photos" / "holiday.jpg").read_bytes() == b"dear"
    assert [path.name for path in tmp_path.rglob("*")] == ["photos", "holiday.jpg"]


@pytest.mark.usefixtures("converted")
def test_a_bundle_that_the_service_would_refuse_is_not_written(
    checkpoint: Checkpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exporter.assembly, "encode_manifest", lambda _: json.dumps({"format_version": 99}).encode())
    with pytest.raises(ExportError, match=r"the service would refuse this bundle.* found 99"):
        export(checkpoint, tmp_path / "car", OFFSET, {})
    assert list(tmp_path.iterdir()) == []
