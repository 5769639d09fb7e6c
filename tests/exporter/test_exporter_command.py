"""`python -m exporter` from a checkpoint on disk."""

import json
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from exporter.__main__ import main
from service.bundle import read_bundle
from trainer.training.checkpoint import FILE_NAME, Checkpoint, save_checkpoint

METRICS = {"iou": 0.6, "azimuth_offset_degrees": -35.5, "azimuth_temperature": 2.5}


class Answer(NamedTuple):
    status: int
    output: str
    errors: str


def answer(capsys: pytest.CaptureFixture[str], *options: str | Path) -> Answer:
    """What the command says, called in this process."""
    try:
        status = main([str(option) for option in options])
    except SystemExit as ending:
        status = int(ending.code or 0)
    captured = capsys.readouterr()
    return Answer(status, captured.out, captured.err)


def test_the_command_is_a_process() -> None:
    command = [sys.executable, "-m", "exporter", "--checkpoint", "absent", "--output", "car"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 2
    assert result.stderr.startswith("Expected a checkpoint at")


def test_a_run_directory_becomes_a_bundle(
    checkpoint: Checkpoint, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_checkpoint(tmp_path / "run" / FILE_NAME, checkpoint)
    (tmp_path / "metrics.json").write_text(json.dumps(METRICS))
    made = "--checkpoint", tmp_path / "run", "--output", tmp_path / "car"
    result = answer(capsys, *made, "--metrics", tmp_path / "metrics.json")
    assert (result.status, result.errors) == (0, "")
    assert "car, 98 vertices, azimuth offset -35.5°, temperature 2.5; torch and onnxruntime differ by" in result.output
    assert "no held-out pictures" in result.output
    manifest = read_bundle(tmp_path / "car").manifest
    assert manifest.azimuth_offset_degrees == -35.5
    assert manifest.azimuth_temperature == 2.5
    assert manifest.metrics == METRICS
    file = "--checkpoint", tmp_path / "run" / FILE_NAME, "--output", tmp_path / "car"
    result = answer(capsys, *file, "--azimuth-offset-degrees", "90", "--azimuth-temperature", "3")
    assert result.status == 0, result.errors
    manifest = read_bundle(tmp_path / "car").manifest
    assert (manifest.azimuth_offset_degrees, manifest.azimuth_temperature) == (90, 3)


@pytest.mark.parametrize(
    ("metrics", "options", "sentence"),
    [
        (None, ["--metrics", "absent.json"], "absent.json: expected a metrics.json, found: No such file"),
        (
            "{}",
            ["--metrics", "metrics.json"],
            "metrics.json: expected azimuth_offset_degrees from -360 to 360, found None",
        ),
        (
            '{"azimuth_offset_degrees": 1}',
            ["--metrics", "metrics.json"],
            "metrics.json: expected azimuth_temperature from 0.1 to 100, found None",
        ),
        ("[]", ["--metrics", "metrics.json"], "expected a JSON object, found a list"),
        ('{"iou": NaN}', ["--metrics", "metrics.json"], "expected JSON with finite numbers, found: NaN"),
        ("{}", ["--metrics", "metrics.json", "--azimuth-offset-degrees", "1"], "found both; name one of them"),
        (None, ["--azimuth-offset-degrees", "1000"], "expected azimuth_offset_degrees from -360 to 360, found 1000"),
        (None, ["--azimuth-temperature", "0"], "--azimuth-temperature: expected azimuth_temperature from 0.1 to 100"),
        (None, [], "Expected a checkpoint at"),
    ],
)
def test_wrong_options_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], metrics: str | None, options: list[str], sentence: str
) -> None:
    if metrics is not None:
        (tmp_path / "metrics.json").write_text(metrics)
    options = [str(tmp_path / option) if option.endswith(".json") else option for option in options]
    result = answer(capsys, "--checkpoint", tmp_path / "absent", "--output", tmp_path / "car", *options)
    assert result.status == 2
    assert sentence in result.errors
    assert not (tmp_path / "car").exists()


def test_help_explains_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    result = answer(capsys, "--help")
    assert result.status == 0
    for word in ("--checkpoint", "--output", "--azimuth-offset-degrees", "--metrics", "degrees"):
        assert word in result.output
