"""`python -m trainer select`: a real selection of tiny models, and what it answers to mistakes."""

import json
import os
import shutil
import signal
import time
from pathlib import Path

import pytest

from tests.trainer.command_line import answer, start
from trainer.config import WHITE_RIG, SceneConfig
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.presets import load_preset
from trainer.selection.page import as_markdown
from trainer.training.checkpoint import load_checkpoint

TINY = """
width = 32
height = 24
[model]
hidden = 8
encoder_channels = [4, 4, 8, 8, 8, 16]
[optimiser]
batch_size = 8
steps = 8
"""
FEW = ["--forms", "subdivision-2", "ortho-block-2", "--latents", "2", "--lights", "fixed"]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures") / "car"
    render_folder(folder, RenderSettings("car"), SceneConfig(32, 24), 24, 1, 1, show_progress=False)
    return folder


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.toml"
    path.write_text(TINY)
    return path


def options(pictures: Path, tiny: Path, out: Path) -> list[str | Path]:
    return [
        "select", "--images", pictures, "--output", out, "--preset", tiny, "--validation-share", "0.5", "--rungs", "2",
        "--samples", "2", "--workers", "1", *FEW,
    ]  # fmt: skip


def test_a_selection_from_pictures_to_a_preset_and_on(
    pictures: Path, tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = options(pictures, tiny, out)
    status, page, errors = answer(capsys, *command)
    assert status == 0, errors
    assert "4 candidates to step 4, 1 at once" in errors
    assert "2 candidates to step 8, 1 at once" in errors
    found = json.loads((out / "selection.json").read_text())
    assert [(rung["step"], rung["candidates"], rung["kept"]) for rung in found["rungs"]] == [(4, 4, 2), (8, 2, 2)]
    assert (found["pictures"], found["held_out_pictures"], found["held_out_objects"]) == (12, 12, 12)
    assert [candidate["verdict"] for candidate in found["candidates"]][2:] == ["dropped", "dropped"]
    bounds = [candidate["rungs"][-1]["bound"]["value"] for candidate in found["candidates"]]
    assert bounds[:2] == sorted(bounds[:2], reverse=True)
    assert as_markdown(found) == (out / "selection.md").read_text()
    assert found["chosen"] in page
    assert str(tmp_path) not in (out / "selection.md").read_text()

    # The setting is one that `trainer train` takes, and its training goes on.
    config = load_preset(str(out / "preset.toml"))
    chosen = next(candidate for candidate in found["candidates"] if candidate["name"] == found["chosen"])
    assert (config.model.latent, config.model.light) == (2, "fixed")
    assert {candidate["symmetry"] for candidate in found["candidates"]} == {"none", "mirror"}
    assert config.model.symmetry == chosen["symmetry"]
    assert (config.optimiser.steps, config.validation_share, config.width) == (8, 0.5, 32)
    assert load_checkpoint(out / "winner").config == config
    status, _, errors = answer(capsys, "train", "--run", out / "winner", "--resume", "--optimiser.steps", "10")
    assert status == 0, errors
    assert load_checkpoint(out / "winner").step == 10
    anew = ["train", "--images", pictures, "--preset", out / "preset.toml", "--run", tmp_path / "anew"]
    anew += ["--reframing-share", "0"]
    status, _, errors = answer(capsys, *anew)
    assert status == 0, errors
    after, before = load_checkpoint(tmp_path / "anew"), load_checkpoint(out / "candidates" / found["chosen"])
    assert after.step == before.step == 8
    for name, weights in before.model.state_dict().items():
        assert weights.equal(after.model.state_dict()[name]), name

    # Once more: nothing is trained again, and what went on is left alone.
    times = {path: path.stat().st_mtime_ns for path in out.rglob("candidates/**/*")}
    status, again, errors = answer(capsys, *command)
    assert (status, again) == (0, page)
    assert "candidates to step" not in errors
    assert {path: path.stat().st_mtime_ns for path in times} == times
    assert load_checkpoint(out / "winner").step == 10
    status, _, errors = answer(capsys, *command, "--samples", "3")
    assert status == 2
    assert "holds a selection of other options or pictures than these: there, samples 2." in errors


def test_labels_and_test_pictures_make_no_difference(
    pictures: Path, tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where poses and lights are wrong, and even say that the lights turn, all figures are the same."""
    wrong = tmp_path / "car"
    shutil.copytree(pictures, wrong)
    header, *rows = (wrong / "metadata.csv").read_text().splitlines()
    assert header == "file_name,instance,azimuth_degrees,light_azimuth_degrees"
    rows = [",".join([*row.split(",")[:2], "12.5", "77.0"]) for row in rows]
    (wrong / "metadata.csv").write_text("\n".join([header, *rows]) + "\n")
    told = []
    for name, folder in (("right", pictures), ("wrong", wrong)):
        command = options(folder, tiny, tmp_path / name)
        status, _, errors = answer(capsys, *command, "--steps", "2", "--latents", "2")
        assert status == 0, errors
        found = json.loads((tmp_path / name / "selection.json").read_text())
        told.append([(candidate["name"], candidate["rungs"][-1]["bound"]) for candidate in found["candidates"]])
    assert told[0] == told[1]


def test_own_pictures_have_the_lights_that_they_are_said_to_have(
    tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine, out = tmp_path / "mine", tmp_path / "out"
    render_folder(mine, RenderSettings("car"), SceneConfig(64, 48), 24, 1, 1, show_progress=False)
    for name in ("scene.json", "render.json", "metadata.csv"):
        (mine / name).unlink()
    lit = ["--rig", "white", "--camera.elevation-degrees", "20", "--class", "car"]
    status, _, errors = answer(capsys, *options(mine, tiny, out), "--steps", "2", "--latents", "2", *lit)
    assert status == 0, errors
    assert "24 pictures with a plain background, which was found and removed, and framed" in errors
    assert (out / "prepared.png").exists()
    assert "--run RUN --class car --rig white --camera.elevation-degrees 20.0" in errors
    winner = load_checkpoint(out / "winner")
    assert winner.scene.lights == WHITE_RIG
    assert winner.scene.camera.elevation_degrees == 20.0
    assert winner.category == "car"


@pytest.mark.slow
def test_ctrl_c_saves_and_the_same_command_goes_on(pictures: Path, tiny: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    tiny.write_text(TINY.replace("steps = 8", "steps = 600"))
    command = options(pictures, tiny, out)
    with start(*command) as process:
        deadline = time.monotonic() + 120
        while not any(path.stat().st_size > 0 for path in out.rglob("metrics.jsonl")):
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < deadline
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert output == ""
    assert "Traceback" not in errors
    (saved,) = out.rglob("checkpoint.safetensors")
    step = load_checkpoint(saved).step
    assert step >= 20
    lines = (saved.parent / "metrics.jsonl").read_text().splitlines()
    with start(*command) as process:
        while not list(saved.parent.glob("bound-*.json")):
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < deadline + 120
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
    assert process.returncode == 130
    kept = [line for line in lines if json.loads(line)["step"] <= step]
    assert (saved.parent / "metrics.jsonl").read_text().splitlines()[: len(kept)] == kept
    assert load_checkpoint(saved).step == 300


def test_a_plan_writes_nothing(pictures: Path, tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, plan, _ = answer(capsys, *options(pictures, tiny, tmp_path / "out"), "--dry-run", "--minutes", "2.5")
    assert status == 0
    assert "4 candidates, 2 rungs, 2.5 minutes of a core in all; 12 pictures, 12 held out" in plan
    assert plan.strip().startswith("ortho-block-2_latent-2_fixed")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("--forms cube-3 subdivision-3", "Expected --forms such as subdivision-4 or cup-4 (segments), ortho-block-6"),
        (
            "--forms subdivision-3 --latents 4 --lights fixed --symmetries none",
            "Expected two candidates or more, found 1",
        ),
        ("--forms subdivision-3 subdivision-3", "Expected --forms that differ, found subdivision-3 subdivision-3."),
        ("--latents 4 4", "Expected --latents that differ, found 4 4."),
        ("--latents 0", "Expected model.latent from 1 to 1024, found 0."),
        ("--lights dark", "dark"),
        ("--steps 5 --minutes 3", "Expected either --steps or --minutes, found both."),
        ("--steps 1", "Expected --steps from 2 (--rungs) to 8, those of"),
        ("--steps 9", "found 9. Name a longer preset, or fewer steps."),
        ("--minutes nan", "Expected --minutes from 0 to 1000000, found nan."),
        ("--rungs 0", "Expected --rungs from 1 to 10, found 0."),
        ("--samples 0", "Expected --samples from 1 to 1000, found 0."),
        ("--workers -1", "Expected --workers from 0 to 1024, found -1."),
        ("--seed -1", "Expected seed from 0 to 2.14748e+09, found -1."),
        ("--validation-share 0.6", "Expected validation_share from 0 to 0.5, found 0.6."),
        ("--validation-share 0.1", "Expected 10 held-out objects or more to judge by, found 2 of 24"),
        ("--preset shrap", "no preset 'shrap'; did you mean 'sharp'?"),
        ("--preset poses.toml", "found loss.pose_supervision azimuth in poses.toml: a selection looks at pictures"),
        ("--preset views.toml", "found optimiser.views_per_instance 3 in views.toml"),
        ("--preset free.toml", "Expected loss.kl_weight above 0 in free.toml, found 0"),
        ("--preset outlines.toml --lights varying", "Expected --lights fixed with outlines.toml, found varying"),
        ("--class Große", "category of small letters, digits, - and _"),
        ("--rig white", "Expected --camera and --rig only for pictures whose scene is not known"),
        ("--images absent", "expected a folder of pictures at absent, found nothing"),
    ],
)
def test_a_mistake_is_answered_in_a_sentence_and_nothing_is_written(
    capsys: pytest.CaptureFixture[str],
    pictures: Path,
    tiny: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: str,
    sentence: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "poses.toml").write_text('[loss]\npose_supervision = "azimuth"\n')
    (tmp_path / "views.toml").write_text("[optimiser]\nviews_per_instance = 3\nbatch_size = 96\n")
    (tmp_path / "outlines.toml").write_text('[loss]\nkind = "silhouette"\n')
    (tmp_path / "free.toml").write_text("[loss]\nkl_weight = 0\n")
    before = sorted(tmp_path.iterdir())
    status, output, errors = answer(capsys, *options(pictures, tiny, tmp_path / "out"), *arguments.split())
    assert (status, output) == (2, "")
    assert sentence in errors
    assert sorted(tmp_path.iterdir()) == before
