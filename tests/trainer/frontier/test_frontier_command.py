"""`python -m trainer frontier`: trains, judges, exports and times what is missing, and nothing twice."""

import json
from pathlib import Path

import pytest

from tests.trainer.command_line import answer
from trainer.frontier.files import read_report

TINY = """
[scale]
preset = "fast"
instances = 12
test_instances = 3
test_views = 2
width = 32
height = 24
steps = 3

[[factors]]
name = "default"
title = "The default"
points = [{ name = "default", label = "default", changes = { CHANGES }, seeds = [0, 1] }]

[[factors]]
name = "refine"
title = "Refinement"
cost = "latency_ms"
default = "none"
points = [{ name = "refine-1", label = "1 refinement", changes = { CHANGES }, refine = 1 }]

[[factors]]
name = "steps"
title = "Steps"
default = "3 steps"
points = [{ name = "steps-5", label = "5 steps", changes = { CHANGES, optimiser.steps = 5 } }]
""".replace(
    "CHANGES",
    "width = 32, height = 24, optimiser.batch_size = 8, model.encoder_channels = [4, 4, 8, 8, 8, 16]",
)


@pytest.mark.slow
def test_a_frontier_is_made_and_nothing_is_made_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, out, docs = tmp_path / "tiny.toml", tmp_path / "out", tmp_path / "docs"
    plan.write_text(TINY)
    command = ["frontier", "--budget", plan, "--output", out, "--report", docs, "--workers", "1"]
    status, told, _ = answer(capsys, *command, "--dry-run")
    assert (status, told.count("train ")) == (0, 3)
    assert not out.exists()

    docs.mkdir()
    (docs / "frontier.md").write_text("# Mine\n\nKept.\n")
    status, told, errors = answer(capsys, *command)
    assert status == 0, errors
    report = read_report(docs)
    assert [(point.name, point.steps, len(point.runs)) for point in report.points] == [
        ("default", 3, 2), ("refine-1", 3, 1), ("steps-5", 5, 1),
    ]  # fmt: skip
    default, refined, longer = report.points
    # The same training, answered with more patience.
    assert refined.training_minutes == default.runs[0].minutes
    assert refined.latency_ms > default.latency_ms
    assert refined.iou != default.runs[0].iou
    assert (out / "tiny/runs/fast/car").is_dir()
    assert {folder.name for folder in (out / "tiny/runs/fast/car").iterdir()} == {"default", "steps-5"}
    # What is the same graph costs the same, whatever its weights.
    assert longer.latency_ms == default.latency_ms > 0
    assert longer.bundle_mb == default.bundle_mb > 0
    assert 20 < default.memory_mb < 1000
    assert default.iou == pytest.approx(sum(run.iou for run in default.runs) / 2, abs=1e-4)
    assert default.renderings_thousands == 3 * 8 * 12 / 1e3
    assert report.skipped == ()
    page = (docs / "frontier.md").read_text()
    assert page.startswith("# Mine\n\nKept.\n\n<!-- figures")
    assert (docs / "results/frontier.csv").read_text().count("\n") == 4

    written = (out / "tiny/costs.json").read_bytes()
    times = {path: path.stat().st_mtime_ns for path in out.rglob("*") if path.is_file()}
    status, _, errors = answer(capsys, *command)
    assert status == 0, errors
    assert {path: path.stat().st_mtime_ns for path in times} == times
    assert (out / "tiny/costs.json").read_bytes() == written
    assert (docs / "frontier.md").read_text() == page
    status, told, _ = answer(capsys, *command, "--dry-run")
    assert told.count("done ") == 3

    # A bundle that changes is timed again, and all others with it.
    changed = json.loads(written)
    changed["identities"] = dict.fromkeys(changed["identities"], "another")
    (out / "tiny/costs.json").write_text(json.dumps(changed))
    assert answer(capsys, *command)[0] == 0
    assert json.loads((out / "tiny/costs.json").read_text())["identities"] == json.loads(written)["identities"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("frontier --budget ful", "Expected a budget, small or full"),
        ("frontier --workers -2", "Expected --workers from 0 to 1024, found -2."),
        ("frontier --budget absent.toml", "absent.toml cannot be read"),
    ],
)
def test_a_mistake_is_answered_in_a_sentence_and_nothing_is_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: str, sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, output, errors = answer(capsys, *arguments.split())
    assert (status, output) == (2, "")
    assert sentence in errors
    assert not list(tmp_path.iterdir())
