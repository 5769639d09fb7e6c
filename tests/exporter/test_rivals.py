"""How strictly `auto` judges each of several bundles: the fit in closed forms, and the command."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from exporter.export import export
from exporter.rivals import fitted_biases, main
from service.bundle import MANIFEST_FILE, read_bundle
from service.inference import load_engine
from service.manifest import MOST_BIAS
from service.reconstruction import reconstruct
from tests.exporter.conftest import small_checkpoint
from tests.exporter.test_held_out import disc


def test_a_model_that_explains_everything_better_is_put_back_by_that_much() -> None:
    evidence = np.tile([1.5, 0.0], (20_000, 1))
    first, second = fitted_biases(evidence, np.arange(20_000) % 2)
    assert first - second == pytest.approx(-1.5, abs=1e-3)
    # The prior of unit variance: two looks are hardly any reason.
    few = fitted_biases(evidence[:2], np.arange(2))
    assert -1.0 < few[0] - few[1] < -0.2
    assert few.sum() == pytest.approx(0, abs=1e-5)


def test_each_category_is_expected_as_often_as_it_is_there() -> None:
    """Where the slope is 0: expected and true counts differ by the bias alone."""
    random = np.random.default_rng(0)
    truth = random.integers(0, 4, 400)
    evidence = random.normal(size=(400, 4)) + 2 * np.eye(4)[truth] + np.array([0.0, 1.0, -1.0, 0.5])
    biases = fitted_biases(evidence, truth)
    scores = evidence + biases
    probabilities = np.exp(scores) / np.exp(scores).sum(1, keepdims=True)
    weights = 400 / 4 / np.bincount(truth)[truth]
    assert weights @ probabilities == pytest.approx(100 - biases, abs=1e-2)


def test_many_pictures_of_one_category_do_not_prefer_it() -> None:
    evidence = np.zeros((110, 2))
    truth = np.repeat([0, 1], (100, 10))
    assert fitted_biases(evidence, truth) == pytest.approx([0, 0], abs=1e-4)


def test_no_bias_is_more_than_a_manifest_takes() -> None:
    evidence = np.tile([1000.0, 0.0], (10**4, 1))
    assert np.abs(fitted_biases(evidence, np.arange(10**4) % 2)).max() <= MOST_BIAS


@pytest.fixture
def models(exported: Path, tmp_path: Path) -> Path:
    """Bundles of cars and of sofas, which other weights make."""
    folder = tmp_path / "models"
    (folder / "car").mkdir(parents=True)
    for file in exported.iterdir():
        (folder / "car" / file.name).write_bytes(file.read_bytes())
    checkpoint = small_checkpoint()
    with torch.no_grad():
        checkpoint.model.decoder.displacements.weight.mul_(0.1)
    export(replace(checkpoint, category="sofa"), folder / "sofa", 0.0, {})
    return folder


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    """Discs on black for cars, on white for sofas."""
    for category, background in (("car", 0), ("sofa", 255)):
        folder = tmp_path / "pictures" / category
        folder.mkdir(parents=True)
        for seed in range(20):
            (folder / f"{seed}.png").write_bytes(disc(seed, background))
    return tmp_path / "pictures"


def test_the_command_writes_what_auto_then_uses(
    models: Path, pictures: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {name: read_bundle(models / name).manifest for name in ("car", "sofa")}
    assert main(["--models", str(models), "--images", str(pictures)]) == 0
    told = capsys.readouterr().out
    assert "named rightly, of these pictures: " in told
    bundles = [read_bundle(models / name) for name in ("car", "sofa")]
    biases = {bundle.manifest.category: bundle.manifest.category_bias for bundle in bundles}
    assert biases["car"] == pytest.approx(-biases["sofa"], abs=2e-3)
    assert biases["car"] != 0
    for bundle in bundles:
        assert replace(bundle.manifest, category_bias=0.0) == before[bundle.manifest.category]
        assert f"{bundle.manifest.category}: {bundle.manifest.category_bias:+.2f}" in told
    # Twice gives the same.
    assert main(["--models", str(models), "--images", str(pictures)]) == 0
    assert capsys.readouterr().out == told

    engines = [load_engine(bundle) for bundle in bundles]
    even = [replace(one, manifest=replace(one.manifest, category_bias=0.0)) for one in engines]
    probabilities, unbiased = (
        reconstruct(judged, [disc(50)], 10**6).report.category_probabilities for judged in (engines, even)
    )
    assert probabilities is not None
    assert unbiased is not None
    odds = probabilities["car"] / probabilities["sofa"] / (unbiased["car"] / unbiased["sofa"])
    assert odds == pytest.approx(np.exp(biases["car"] - biases["sofa"]), rel=1e-3)


def test_what_cannot_be_fitted_is_said_and_changes_nothing(
    models: Path, pictures: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = {path: path.read_bytes() for path in models.glob(f"*/{MANIFEST_FILE}")}

    def refused(models: Path) -> str:
        assert main(["--models", str(models), "--images", str(pictures)]) == 2
        return capsys.readouterr().err

    assert "expected bundles of two categories at least, found 1" in refused(models / "car")
    for file in list((pictures / "sofa").iterdir())[5:]:
        file.unlink()
    assert "expected 20 pictures of one sofa each at least, found 5 that can be used" in refused(models)
    for file in (pictures / "sofa").iterdir():
        file.unlink()
    assert "sofa" in refused(models)
    assert "expected a bundle or a directory of bundles, found no directory" in refused(models / "absent")
    assert before == {path: path.read_bytes() for path in models.glob(f"*/{MANIFEST_FILE}")}


def test_it_is_a_command() -> None:
    command = [sys.executable, "-m", "exporter.rivals", "--models", "absent", "--images", "absent"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 2
    assert "absent: expected a bundle or a directory of bundles, found no directory" in result.stderr
