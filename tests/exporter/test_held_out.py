"""The yardstick of out-of-class scores: errors of held-out pictures, measured as the service measures them."""

import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from exporter import __main__ as command
from exporter.density import told
from exporter.errors import ExportError
from exporter.export import export
from exporter.held_out import LEAST_PICTURES, measure_held_out
from service.bundle import read_bundle
from service.explanation import unexplained
from service.image import read_picture
from service.inference import Engine, decode, encode, load_engine
from service.reconstruction import reconstruct
from tests.exporter.conftest import OFFSET
from tests.exporter.test_exporter_command import answer
from trainer.model.aggregate_posterior import fit_aggregate_posterior
from trainer.training.checkpoint import FILE_NAME, Checkpoint, save_checkpoint


def disc(seed: int, background: int = 0) -> bytes:
    """A PNG of a shaded disc."""
    generator = np.random.default_rng(seed)
    rows, columns = np.mgrid[-1:1:96j, -1.33:1.33:128j]
    inside = (rows**2 + columns**2 < generator.uniform(0.4, 0.55))[..., None]
    slopes = generator.uniform(-0.5, 0.5, (2, 3))
    shade = 0.5 + rows[..., None] * slopes[0] + columns[..., None] * slopes[1] / 1.4
    buffer = io.BytesIO()
    Image.fromarray(np.where(inside, 255 * shade.clip(0.05, 1), background).astype(np.uint8)).save(buffer, "PNG")
    return buffer.getvalue()


@pytest.fixture(scope="module")
def engine(exported: Path) -> Engine:
    return load_engine(read_bundle(exported))


def errors_of(engine: Engine, files: list[bytes], keep_framed: bool) -> list[float]:
    camera, found = engine.manifest.camera, []
    for content in files:
        prepared = read_picture(content, 64, 48, 10**6, camera.distance, camera.field_of_view_degrees, keep_framed)
        posterior = encode(engine, prepared.picture)
        found.append(unexplained(engine, prepared, posterior, decode(engine, posterior.shape_mean)))
    return found


def test_the_errors_are_those_of_the_service(engine: Engine) -> None:
    files = [disc(seed) for seed in range(30)]
    held_out = measure_held_out(engine, files)
    assert held_out.pictures == 30
    for errors, keep_framed in ((held_out.framed, True), (held_out.fitted, False)):
        assert errors is not None
        expected = np.quantile(errors_of(engine, files, keep_framed), (0.5, 0.95))
        assert (errors.median, errors.high) == pytest.approx(expected, abs=1e-6)
    assert held_out.framed != held_out.fitted


def test_the_median_picture_scores_0_and_the_worst_in_twenty_1(engine: Engine) -> None:
    files = [disc(seed) for seed in range(41)]
    judged = replace(engine, manifest=replace(engine.manifest, held_out=measure_held_out(engine, files)))
    scores = [reconstruct([judged], [content], 10**6).report.out_of_class_score for content in files]
    assert None not in scores
    assert sorted(scores)[20] == pytest.approx(0, abs=1e-3)
    assert sorted(scores)[38] == pytest.approx(1, abs=1e-3)


def test_peoples_own_pictures_are_compared_with_such(engine: Engine) -> None:
    held_out = measure_held_out(engine, [disc(seed, 255) for seed in range(25)])
    assert held_out.framed is None
    assert held_out.fitted is not None


def test_too_few_pictures_are_refused(engine: Engine) -> None:
    files = [disc(seed) for seed in range(LEAST_PICTURES - 1)]
    with pytest.raises(ExportError, match=r"expected 20 held-out pictures .* found 19; name a folder of more"):
        measure_held_out(engine, [*files, b"no picture", b""])


def test_pictures_that_are_all_alike_are_refused(engine: Engine) -> None:
    with pytest.raises(ExportError, match="expected held-out pictures that differ"):
        measure_held_out(engine, [disc(0)] * 20)


@pytest.mark.usefixtures("converted")
def test_a_refusal_leaves_nothing(checkpoint: Checkpoint, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="found 1; name a folder"):
        export(checkpoint, tmp_path / "car", OFFSET, {}, held_out=[disc(0)])
    assert list(tmp_path.iterdir()) == []


def test_the_folder_is_named_on_the_command_line(
    checkpoint: Checkpoint, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_checkpoint(tmp_path / "run" / FILE_NAME, checkpoint)
    (tmp_path / "validation").mkdir()
    files = [disc(seed, 255) for seed in range(22)]
    for number, content in enumerate(files):
        (tmp_path / "validation" / f"{number:02}.png").write_bytes(content)
    options = ["--checkpoint", tmp_path / "run", "--output", tmp_path / "car", "--azimuth-offset-degrees", "25"]
    result = answer(capsys, *options, "--images", tmp_path / "validation")
    assert result.status == 0, result.errors
    assert "no held-out pictures" not in result.output
    bundle = read_bundle(tmp_path / "car")
    assert bundle.manifest.held_out == measure_held_out(load_engine(bundle), files)
    assert bundle.manifest.azimuth_offset_degrees == pytest.approx(math.degrees(math.radians(25)))
    # Of so few pictures nobody knows where shape codes lie.
    assert bundle.manifest.aggregate_posterior is None
    absent = answer(capsys, *options, "--images", tmp_path / "absent")
    assert absent.status == 2
    assert "expected a folder of pictures" in absent.errors


def test_a_bundle_from_before_there_was_a_yardstick_still_loads(exported: Path, tmp_path: Path) -> None:
    for file in exported.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest.pop("held_out") is None
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    engine = load_engine(read_bundle(tmp_path))
    assert reconstruct([engine], [disc(0)], 10**6).report.out_of_class_score is None


@pytest.mark.usefixtures("converted")
def test_forty_pictures_tell_where_shape_codes_lie(checkpoint: Checkpoint, tmp_path: Path) -> None:
    manifest = export(checkpoint, tmp_path / "car", OFFSET, {}, held_out=[disc(seed) for seed in range(44)])
    assert manifest.aggregate_posterior is not None
    assert manifest.aggregate_posterior.pictures == 44
    assert load_engine(read_bundle(tmp_path / "car")).manifest == manifest


@pytest.mark.usefixtures("converted")
def test_pictures_of_their_own_tell_it_better(checkpoint: Checkpoint, tmp_path: Path) -> None:
    few, more = [disc(seed) for seed in range(22)], [disc(seed) for seed in range(50)]
    manifest = export(checkpoint, tmp_path / "car", OFFSET, {}, held_out=few, samples_from=more)
    assert manifest.held_out is not None
    assert manifest.held_out.pictures == 22
    assert manifest.aggregate_posterior is not None
    assert manifest.aggregate_posterior.pictures == 50


def test_the_manifest_has_what_is_fitted() -> None:
    means = np.random.default_rng(0).standard_normal((60, 3)) * [1.0, 0.01, 2.0]
    deviations = np.full((60, 3), 0.3)
    expected = fit_aggregate_posterior(means, deviations)
    found = told(expected)
    assert found.contradiction(3) is None
    assert (found.numbers, found.pictures) == ((0, 2), 60)
    noise, shares = np.random.default_rng(1).standard_normal((20, 3)), np.linspace(0, 0.99, 20)
    drawn = [found.code(row, float(share), 1.0) for row, share in zip(noise, shares, strict=True)]
    np.testing.assert_allclose(drawn, expected.codes(noise, shares), atol=1e-3)


@pytest.mark.usefixtures("converted")
def test_of_many_pictures_some_are_taken_and_few_are_refused(
    checkpoint: Checkpoint, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    save_checkpoint(tmp_path / "run" / FILE_NAME, checkpoint)
    for folder, count in (("many", 90), ("few", 5)):
        (tmp_path / folder).mkdir()
        for number in range(count):
            (tmp_path / folder / f"{number:02}.png").write_bytes(disc(number, 255))
    monkeypatch.setattr(command, "MOST_PICTURES", 50)
    options = ["--checkpoint", tmp_path / "run", "--azimuth-offset-degrees", "25"]
    result = answer(capsys, *options, "--output", tmp_path / "car", "--samples-from", tmp_path / "many")
    assert result.status == 0, result.errors
    density = read_bundle(tmp_path / "car").manifest.aggregate_posterior
    assert density is not None
    assert density.pictures == 45
    assert "from the prior" not in result.output
    refused = answer(capsys, *options, "--output", tmp_path / "other", "--samples-from", tmp_path / "few")
    assert refused.status == 2
    assert "Expected 40 pictures at least to learn where shape codes lie, found 5" in refused.errors
    assert not (tmp_path / "other").exists()
    without = answer(capsys, *options, "--output", tmp_path / "car")
    assert "samples will be drawn from the prior" in without.output
    own = answer(capsys, "--bundle", tmp_path / "car", "--output", tmp_path / "other", "--samples-from", tmp_path)
    assert "or --samples-from with --bundle" in own.errors
