"""`python -m trainer table`: renders, trains and judges what is missing, and nothing twice."""

import json
import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import pytest

from tests.trainer.command_line import answer, start
from trainer.presets import load_preset
from trainer.tables.cells import Cell
from trainer.tables.setting import Setting, Variant
from trainer.tables.study import Study
from trainer.training.checkpoint import load_checkpoint

TINY = """
width = 32
height = 24
[model]
encoder_channels = [4, 4, 8, 8, 8, 16]
[optimiser]
batch_size = 8
steps = 6
"""
CELL = Cell("car", Setting(), 0)
FEW = ["--classes", "car", "--seeds", "0", "--instances", "12", "--test-instances", "3", "--test-views", "2"]


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.toml"
    path.write_text(TINY)
    return path


@pytest.mark.slow
def test_a_table_is_made_and_nothing_is_made_twice(
    tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["table", "table-2", "--preset", tiny, "--output", out, "--workers", "2", *FEW]
    status, page, errors = answer(capsys, *command)
    assert status == 0, errors
    assert "6 trainings, 2 at once, 6 steps each" in errors
    written = json.loads((out / "table-2.json").read_text())
    assert len(written["cells"]) == 6
    assert written["failures"] == []
    (figure,) = (
        figure
        for figure in written["figures"]
        if (figure["row"], figure["figure"]) == ("full-block", "iou_pose_given") and figure["class"] == "car"
    )
    assert figure["paper"] == 0.63
    assert 0 < figure["ours"]["value"] < 1
    assert f"{figure['ours']['value']:.2f} | 0.63 | 6 |" in page
    assert (out / "table-2.md").read_text().startswith("# Table 2: mesh parameterisations\n")
    told = load_checkpoint(out / "runs/tiny/car/full-block_pose-given/seed-0")
    assert (told.step, told.config.loss.pose_supervision) == (6, "azimuth")

    times = {path: path.stat().st_mtime_ns for path in (*out.rglob("runs/**/*"), *out.rglob("pictures/**/*"))}
    status, again, errors = answer(capsys, *command)
    assert (status, again) == (0, page)
    assert "trainings" not in errors
    # Another table that shares trainings takes them as they are.
    status, _, errors = answer(capsys, "table", "figure-9", "--dry-run", *command[2:])
    assert status == 0
    assert {path: path.stat().st_mtime_ns for path in times} == times

    status, plan, _ = answer(capsys, "table", "figure-9", "--dry-run", *command[2:])
    assert "done car, pose-given, seed 0" in plan
    assert "4 of 5 trainings to do, 6 steps each" in plan
    # Who asks for more steps gets them; fewer are there already.
    status, plan, _ = answer(capsys, "table", "table-2", "--dry-run", *command[2:], "--steps", "8")
    assert plan.count("resume car") == 6
    status, plan, _ = answer(capsys, "table", "table-2", "--dry-run", *command[2:], "--steps", "5")
    assert plan.count("done car") == 6
    status, _, errors = answer(capsys, *command, "--instances", "11")
    assert status == 2
    assert "holds a training of another recipe or on other pictures than these" in errors


@pytest.mark.slow
def test_of_several_starts_one_goes_on(tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    command = ["table", "seeds", "--starts", "2", "--preset", tiny, "--output", out, "--workers", "1", *FEW]
    command[command.index("--seeds") + 1] = "3"
    status, page, errors = answer(capsys, *command)
    assert status == 0, errors
    assert "6 steps each, the best of 2 starts" in page
    written = json.loads((out / "seeds.json").read_text())
    (cell,) = written["cells"]
    assert (written["study"]["starts"], cell["seed"], cell["steps"]) == (2, 3, 6)
    run = out / "runs/tiny-best-of-2/car/baseline/seed-3"
    choice = json.loads((run / "starts.json").read_text())
    assert [start["seed"] for start in choice["starts"]] == [6, 7]
    told = load_checkpoint(run)
    assert (told.step, told.config.seed) == (6, choice["chosen"])
    # What was spent on the other start counts.
    (other,) = (start for start in choice["starts"] if start["seed"] != choice["chosen"])
    trained = json.loads((run / "trained.json").read_text())
    for spent in ("seconds", "core_seconds"):
        assert trained[spent] == pytest.approx(told.run[spent] + other[spent])

    # Longer, it goes on with the same one.
    status, _, errors = answer(capsys, *command, "--steps", "8")
    assert status == 0, errors
    assert (load_checkpoint(run).step, load_checkpoint(run).config.seed) == (8, choice["chosen"])


@pytest.mark.slow
def test_ctrl_c_saves_every_training_and_the_same_command_goes_on(
    tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    options = ["--preset", tiny, "--output", out, "--workers", "2", *FEW]
    with start("table", "figure-9", *options, "--steps", "100000") as process:
        deadline = time.monotonic() + 120
        while sum(path.stat().st_size > 0 for path in out.rglob("metrics.jsonl")) < 2:
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert output == ""
    assert errors.endswith("interrupted; finished files are kept, and nothing is half-written\n")
    assert "Traceback" not in errors
    saved = {path.parent: load_checkpoint(path).step for path in out.rglob("checkpoint.safetensors")}
    assert len(saved) == 2
    assert min(saved.values()) >= 20

    goal = str(max(saved.values()) + 5)
    _, plan, _ = answer(capsys, "table", "figure-9", *options, "--steps", goal, "--dry-run")
    assert plan.count("resume") == 2
    assert plan.count("train car") == 3
    # The others' goal is not theirs: the tests would take longer. One of the two that were begun is enough.
    first = out / "runs/tiny/car/latent-6_pose-given/seed-0"
    lines = (first / "metrics.jsonl").read_text().splitlines()
    with start("table", "figure-9", *options, "--steps", goal) as process:
        while not (first / "trained.json").exists():
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < deadline + 120
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert json.loads((first / "trained.json").read_text())["steps"] == int(goal)
    # What was trained before was not trained again.
    kept = [line for line in lines if json.loads(line)["step"] <= saved[first]]
    assert (first / "metrics.jsonl").read_text().splitlines()[: len(kept)] == kept


def test_time_becomes_steps_by_the_pace_of_the_first() -> None:
    study = Study(Path(), "sharp", load_preset("sharp"), 10, 2, 1, seconds=100.0)
    assert study.next_goal(CELL, 0, 0.0) == 50
    # 50 steps in 10 s leave time for 450 more.
    assert study.next_goal(CELL, 50, 10.0) == 500
    # Too slow at first: there is time left, and it is used.
    assert study.next_goal(CELL, 500, 80.0) == 625
    for seconds in (98.5, 100.0, 130.0):
        assert study.next_goal(CELL, 600, seconds) == 600
    by_steps = replace(study, seconds=None)
    assert by_steps.next_goal(CELL, 0, 0.0) == by_steps.next_goal(CELL, 1499, 900.0) == 1500
    # A variant has steps of its own.
    short = Cell("car", Variant("short", load_preset("fast")), 0)
    assert by_steps.next_goal(short, 0, 0.0) == by_steps.next_goal(short, 300, 70.0) == 300
    assert by_steps.next_goal(CELL, 1500, 901.0) == 1500


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("table tabel-2", "There is no table 'tabel-2'; did you mean 'table-2'?"),
        ("table table-2 --classes caar", "found 'caar'; did you mean 'car'?"),
        ("table table-2 --classes car car", "Expected --classes that differ, found car car."),
        ("table table-2 --steps 5 --budget 3", "Expected either --steps or --budget, found both."),
        ("table table-2 --starts 2 --budget 3", "Expected either --starts or --budget, found both."),
        ("table table-2 --starts 0", "Expected --starts from 1 to 100, found 0."),
        ("table table-2 --steps -1", "Expected --steps from 0 to 1000000000, found -1."),
        ("table table-2 --budget nan", "Expected --budget from 0 to 1000000, found nan."),
        ("table table-2 --seeds 1 1", "Expected 1 to 100 different --seeds, found (1, 1)."),
        ("table table-2 --seeds -1", "Expected seed from 0 to 2.14748e+09, found -1."),
        ("table table-2 --preset shrap", "no preset 'shrap'; did you mean 'sharp'?"),
        ("table table-2 --workers -2", "Expected --workers from 0 to 1024, found -2."),
        ("table table-2 --test-views 0", "Expected --test-views from 1 to 1000, found 0."),
        ("table table-5 --test-views 4", "Expected --test-views to be a multiple of 3, found 4: table-5 judges 3"),
        ("table table-2 --shapenet absent", "expected ShapeNetCore at HERE/absent"),
    ],
)
def test_a_mistake_is_answered_in_a_sentence_and_nothing_is_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: str, sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, output, errors = answer(capsys, *arguments.split())
    assert (status, output) == (2, "")
    assert sentence.replace("HERE", str(tmp_path)) in errors
    assert not list(tmp_path.iterdir())


def test_a_plan_writes_nothing(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, plan, _ = answer(capsys, "table", "comparisons", "--dry-run", "--budget", "96")
    assert status == 0
    assert plan.count("train car") == 24
    assert "96 of 96 trainings to do, 1.0 minutes each" in plan
    # One view in four lights, of which three views share one: four training folders a class, and two test folders each.
    assert plan.count("render out/tables/pictures/128x96/procedural/sofa/fixed-colour/") == 4
    assert plan.count("render out/tables/pictures/128x96/procedural/sofa/") == 4 + 3 + 3
    assert not list(tmp_path.iterdir())


def test_what_is_zoomed_into_is_rendered_larger(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, plan, _ = answer(capsys, "table", "ablation", "--dry-run", "--classes", "car", "--seeds", "0")
    assert status == 0
    # Of the preset `sharp`, 64 × 48; what is not zoomed into is of the same pictures.
    assert plan.count("out/tables/pictures/128x96/procedural/car/fixed-colour/") == plan.count("render ") == 3
    assert "train car, zoom-1, seed 0" in plan
