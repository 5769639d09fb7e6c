"""Bundles of lower precision: smaller, as good as their manifest says, and for the service like any other."""

import json
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import TensorProto

from exporter.assembly import COMPARED_SAMPLES
from exporter.errors import ExportError
from exporter.export import export
from exporter.held_out import measure_held_out, read_pictures
from exporter.precision import PrecisionName
from exporter.repacking import convertible_bundle, repack
from service.bundle import read_bundle
from service.errors import BundleError
from service.inference import PROBE_TOLERANCE, load_engine
from service.manifest import DECODER_OUTPUTS, ENCODER_OUTPUTS, LIGHT_OUTPUTS, Manifest
from service.reconstruction import reconstruct
from tests.exporter.conftest import OFFSET, small_checkpoint
from tests.exporter.test_exporter_command import answer
from tests.exporter.test_held_out import disc

FILES = [disc(seed) for seed in range(60)]


@pytest.fixture(scope="module")
def lowered(exported: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The exported bundle in each lower precision; to be read only."""
    directory = tmp_path_factory.mktemp("lowered")
    for precision in ("float16", "int8"):
        repack(convertible_bundle(exported, precision), directory / precision, precision, FILES)
    return {path.name: path for path in directory.iterdir()}


def answers(bundle: Path, pictures: np.ndarray, name: str = "encoder.onnx") -> dict[str, np.ndarray]:
    session = onnxruntime.InferenceSession(bundle / name)
    names = [tensor.name for tensor in session.get_outputs()]
    return dict(zip(names, session.run(names, {session.get_inputs()[0].name: pictures}), strict=True))


@pytest.mark.parametrize("precision", ["float16", "int8"])
def test_the_manifest_tells_what_it_costs(exported: Path, lowered: dict[str, Path], precision: str) -> None:
    manifest = load_engine(read_bundle(lowered[precision])).manifest
    record = manifest.precision
    assert record is not None
    assert (record.encoder, record.pictures) == (precision, 30)
    assert record.decoder == ("float16" if precision == "float16" else "float32")
    assert set(record.deviations) == {*ENCODER_OUTPUTS, *DECODER_OUTPUTS}
    pictures = read_pictures(FILES[30:], 64, 48, 2.0, 30.0, 1.0)
    before, after = answers(exported, pictures), answers(lowered[precision], pictures)
    for name in ("shape_mean", "shape_deviation", "azimuth_probabilities", "azimuth_fine_mean"):
        difference = np.abs(before[name] - after[name])
        assert record.deviations[name].largest == pytest.approx(float(difference.max()), abs=1e-6)
        assert record.deviations[name].mean == pytest.approx(float(difference.mean()), abs=1e-6)
        assert record.deviations[name].largest > 0
    same = before["azimuth_probabilities"].argmax(1) == after["azimuth_probabilities"].argmax(1)
    assert record.agreement == {"azimuth": pytest.approx(same.mean())}
    if precision == "int8":
        assert record.deviations["vertices"].largest == 0


def test_the_float32_record_stays_and_the_rest_is_measured_anew(exported: Path, lowered: dict[str, Path]) -> None:
    whole, small = read_bundle(exported).manifest, load_engine(read_bundle(lowered["int8"]))
    assert small.manifest.parity == whole.parity
    assert small.manifest.parsimony == whole.parsimony
    assert small.manifest.identity != whole.identity
    assert small.manifest.held_out == measure_held_out(small, FILES)


def test_float16_is_half_the_weights_and_computes_as_before(exported: Path, lowered: dict[str, Path]) -> None:
    for name in ("encoder.onnx", "decoder.onnx"):
        model = onnx.load(lowered["float16"] / name)
        onnx.checker.check_model(model, full_check=True)
        whole = {tensor.name: tensor for tensor in onnx.load(exported / name).graph.initializer}
        halves = [tensor for tensor in model.graph.initializer if tensor.data_type == TensorProto.FLOAT16]
        wide = [tensor for tensor in model.graph.initializer if tensor.data_type == TensorProto.FLOAT]
        assert sum(np.prod(tensor.dims) for tensor in halves) > 5 * sum(np.prod(tensor.dims) for tensor in wide)
        for half in halves:
            original = onnx.numpy_helper.to_array(whole[half.name.removesuffix(".half")])
            np.testing.assert_array_equal(onnx.numpy_helper.to_array(half), original.astype(np.float16))
    codes = np.random.default_rng(0).standard_normal((COMPARED_SAMPLES, 5)).astype(np.float32)
    before, after = (answers(path, codes, "decoder.onnx")["vertices"] for path in (exported, lowered["float16"]))
    assert 0 < np.abs(before - after).max() < 5e-3


def test_int8_is_eight_bits_per_channel(lowered: dict[str, Path]) -> None:
    model = onnx.load(lowered["int8"] / "encoder.onnx")
    sizes = {tensor.name: tensor for tensor in model.graph.initializer}
    convolutions = [node for node in model.graph.node if node.op_type == "Conv"]
    assert len(convolutions) == 5
    makers = {node.output[0]: node for node in model.graph.node}
    for convolution in convolutions:
        widened = makers[convolution.input[1]]
        assert widened.op_type == "DequantizeLinear"
        weights, scales = (sizes[name] for name in widened.input[:2])
        assert weights.data_type == TensorProto.INT8
        assert scales.dims[0] == weights.dims[0]
        # Seven bits: eight saturate on processors without VNNI.
        assert np.abs(onnx.numpy_helper.to_array(weights).astype(int)).max() <= 64


def test_the_same_bundle_again(exported: Path, lowered: dict[str, Path], tmp_path: Path) -> None:
    repack(convertible_bundle(exported, "int8"), tmp_path / "again", "int8", FILES)
    for path in lowered["int8"].iterdir():
        assert (tmp_path / "again" / path.name).read_bytes() == path.read_bytes()


def test_an_altered_graph_fails_its_probe(lowered: dict[str, Path]) -> None:
    """The probe holds what the shipped graph says, not the float32 one."""
    bundle = read_bundle(lowered["int8"])
    before = answers(lowered["int8"], bundle.probe["images"])
    np.testing.assert_allclose(bundle.probe["shape_mean"], before["shape_mean"], atol=PROBE_TOLERANCE)
    model = onnx.load_from_string(bundle.encoder)
    bias = next(tensor for tensor in model.graph.initializer if tensor.name.endswith("shape_mean.bias"))
    bias.CopyFrom(onnx.numpy_helper.from_array(onnx.numpy_helper.to_array(bias) + np.float32(0.01), bias.name))
    altered = type(bundle)(bundle.path, bundle.manifest, model.SerializeToString(), bundle.decoder, bundle.probe)
    with pytest.raises(BundleError, match="shape_mean: expected the probe's numbers"):
        load_engine(altered)


@pytest.mark.parametrize("precision", ["float16", "int8"])
def test_the_service_answers_with_it(lowered: dict[str, Path], precision: str) -> None:
    engine = load_engine(read_bundle(lowered[precision]))
    report = reconstruct([engine], [FILES[0]], 10**6).report
    assert report.model == engine.manifest.identity
    assert report.out_of_class_score is not None


def test_a_checkpoint_becomes_one_directly(exported: Path, lowered: dict[str, Path], tmp_path: Path) -> None:
    manifest = export(small_checkpoint("varying"), tmp_path / "car", OFFSET, {}, held_out=FILES, precision="int8")
    assert manifest.precision is not None
    assert set(manifest.precision.agreement) == {"azimuth", "light_azimuth"}
    assert set(manifest.precision.deviations) == {*ENCODER_OUTPUTS, *LIGHT_OUTPUTS, *DECODER_OUTPUTS}
    load_engine(read_bundle(tmp_path / "car"))


@pytest.mark.parametrize(("precision", "count"), [("int8", 39), ("float16", 0)])
def test_too_few_pictures_are_refused(exported: Path, tmp_path: Path, precision: PrecisionName, count: int) -> None:
    with pytest.raises(ExportError, match=f"expected 40 held-out pictures .* found {count}; name a folder"):
        repack(convertible_bundle(exported, precision), tmp_path / "car", precision, FILES[:count])
    assert list(tmp_path.iterdir()) == []


def test_a_bundle_in_float16_becomes_one_in_int8(lowered: dict[str, Path], tmp_path: Path) -> None:
    repack(convertible_bundle(lowered["float16"], "int8"), tmp_path / "car", "int8", FILES)
    load_engine(read_bundle(tmp_path / "car"))
    pictures = read_pictures(FILES[30:], 64, 48, 2.0, 30.0, 1.0)
    halved, direct = answers(tmp_path / "car", pictures), answers(lowered["int8"], pictures)
    before = answers(lowered["float16"], pictures)
    for name in ("shape_mean", "azimuth_probabilities"):
        cost = np.abs(direct[name] - before[name]).max()
        assert np.abs(halved[name] - before[name]).max() < 1.5 * cost + 1e-3
    decoder = onnx.load_from_string((tmp_path / "car" / "decoder.onnx").read_bytes())
    assert {tensor.data_type for tensor in decoder.graph.initializer} <= {TensorProto.FLOAT, TensorProto.INT64}


@pytest.mark.parametrize(("known", "asked"), [("int8", "float16"), ("int8", "int8"), ("float16", "float16")])
def test_lost_bits_do_not_come_back(lowered: dict[str, Path], known: str, asked: PrecisionName) -> None:
    expected = f"expected a bundle of more bits than {asked}, found one in {known}; .*convert the bundle"
    with pytest.raises(ExportError, match=expected):
        convertible_bundle(lowered[known], asked)


def test_a_bundle_from_before_all_this_still_loads(exported: Path, tmp_path: Path) -> None:
    for file in exported.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest.pop("precision") is None
    assert manifest.pop("parsimony")["latent"] == [0, 1, 2, 3, 4]
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    assert load_engine(read_bundle(tmp_path)).manifest.parsimony is None


def test_the_command_converts_a_bundle(
    exported: Path, lowered: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "validation").mkdir()
    for number, content in enumerate(FILES):
        (tmp_path / "validation" / f"{number:02}.png").write_bytes(content)
    made = "--bundle", exported, "--output", tmp_path / "small"
    result = answer(capsys, *made, "--precision", "int8", "--images", tmp_path / "validation")
    assert (result.status, result.errors) == (0, "")
    assert "int8: the most probable azimuth bin is that of float32 for" in result.output
    expected: Manifest = read_bundle(lowered["int8"]).manifest
    assert read_bundle(tmp_path / "small").manifest == expected


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--precision", "int8"], "found neither; name what is to be exported"),
        (["--bundle", "B", "--checkpoint", "C", "--precision", "int8"], "found both; name one of them"),
        (["--bundle", "B"], "expected --precision float16 or int8 with --bundle"),
        (["--bundle", "B", "--precision", "int8", "--azimuth-offset-degrees", "3"], "a bundle has its own"),
        (["--bundle", "B", "--precision", "int8"], "expected a bundle's directory, found none"),
    ],
)
def test_wrong_options_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    result = answer(capsys, "--output", tmp_path / "car", *options)
    assert result.status == 2
    assert sentence in result.errors
    assert not (tmp_path / "car").exists()
