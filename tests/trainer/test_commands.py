"""`python -m trainer`: the whole road works, from pictures to figures."""

import json
import os
import re
import signal
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.trainer.command_line import SMALL, answer, opened, run, start, wait_for
from trainer.__main__ import main
from trainer.commands.render import RenderCommand
from trainer.data.plan import read_settings
from trainer.data.shapes.catalogue import make_shape
from trainer.training.checkpoint import load_checkpoint


def test_a_folder_called_like_a_class_is_not_taken_for_the_class(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    vertices, faces = make_shape("chair", 0)
    (tmp_path / "car").mkdir()
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "car" / "thing.ply")
    RenderCommand(Path("from_files"), meshes=Path("car"), width=32, height=24, workers=1).run()
    settings = read_settings(tmp_path / "from_files")
    assert settings is not None
    assert settings.source == str(tmp_path / "car")
    assert [path.name for path in (tmp_path / "from_files").rglob("*.png")] == ["thing.ply-00.png"]
    # And the class is not taken for the folder.
    RenderCommand(Path("from_seeds"), category="car", instances=2, width=32, height=24, workers=1).run()
    assert sorted(path.name for path in (tmp_path / "from_seeds/car").iterdir()) == [
        "car-0000000-00.png",
        "car-0000001-00.png",
    ]


def test_fresh_views_are_remembered_on_resume_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "things").mkdir()
    for seed in range(3):
        vertices, faces = make_shape("chair", seed)
        trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "things" / f"{seed}.ply")
    (tmp_path / "mine.toml").write_text("ambient = [0.5, 0.5, 0.5]\n")
    (tmp_path / "small.toml").write_text(
        "width = 32\nheight = 24\n[model]\nlight = 'varying'\nsegments = 2\nencoder_channels = [4, 4, 8, 8, 8, 16]\n"
        "[optimiser]\nbatch_size = 2\nsteps = 1\n"
    )
    monkeypatch.chdir(tmp_path)
    options = ["--meshes", "things", "--rig", "mine.toml", "--rotate-lights", "--camera.distance", "2.5"]
    status, _, errors = answer(capsys, "train", "--run", "run", "--preset", "small.toml", *options)
    assert status == 0
    assert "fresh views of 3 objects, 0 more held out, things" in errors
    monkeypatch.chdir("/")
    status, _, errors = answer(capsys, "train", "--run", tmp_path / "run", "--resume", "--optimiser.steps", "2")
    assert status == 0
    assert "finished at step 2" in errors
    checkpoint = load_checkpoint(tmp_path / "run")
    assert (checkpoint.scene.ambient, checkpoint.scene.lights) == ((0.5, 0.5, 0.5), ())
    assert (checkpoint.scene.camera.distance, checkpoint.category) == (2.5, "things")
    remembered = checkpoint.run["fresh"]
    assert (remembered["meshes"], remembered["rotate_lights"]) == (str(tmp_path / "things"), True)


@pytest.fixture(scope="module")
def road(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures to train, validate and test on, and a model that was interrupted, and then trained on to the end."""
    root = tmp_path_factory.mktemp("road")
    for seed, (name, count) in enumerate((("train", 20), ("validation", 4), ("test", 4))):
        options = [
            "--class",
            "car",
            "--seed",
            str(seed),
            "--instances",
            str(count),
            "--views",
            "2",
            "--workers",
            "1",
        ]
        assert main(["render", "--output", str(root / name), *options, *SMALL]) == 0
    settings = root / "settings.toml"
    settings.write_text(
        "width = 32\nheight = 24\n[model]\nsegments = 2\nencoder_channels = [4, 4, 8, 8, 8, 16]\n"
        "[optimiser]\nbatch_size = 8\nsteps = 100000\n"
    )
    options = ["--preset", settings, "--class", "car", "--threads", "1", "--starts", "1", "--intervals.log", "1"]
    metrics = root / "run" / "metrics.jsonl"
    with start("train", "--images", root / "train", "--run", root / "run", *options) as process:
        wait_for(process, lambda: metrics.exists() and len(metrics.read_text().splitlines()) > 3)
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=120)
    assert (process.returncode, output) == (130, ""), errors
    assert re.search(r"stopped; continue with --resume at step \d+", " ".join(errors.split()))
    reached = len(metrics.read_text().splitlines())
    assert 4 <= reached < 100000
    resumed = run(
        "train", "--run", root / "run", "--resume", "--intervals.log", "1", "--optimiser.steps", str(reached + 5)
    )
    assert resumed.returncode == 0, resumed.stderr
    steps, alone = reached + 5, round((reached + 5) / 2)
    assert f"finished at step {steps} and {alone} more for the encoder after" in " ".join(resumed.stderr.split())
    assert [json.loads(line)["step"] for line in metrics.read_text().splitlines()] == list(range(1, steps + alone + 1))
    return root


def test_the_road_from_pictures_to_figures(road: Path) -> None:
    judged = run(
        "evaluate",
        "--checkpoint",
        road / "run",
        "--validation",
        road / "validation",
        "--images",
        road / "test",
        "--json",
    )
    assert judged.returncode == 0, judged.stderr
    report = json.loads(judged.stdout)
    assert judged.stdout == json.dumps(report) + "\n"
    assert json.loads((road / "run/evaluation/metrics.json").read_text()) == report
    assert (report["objects"], report["pictures"], report["category"]) == (4, 8, "car")
    assert 0 < report["iou_interval"][0] <= report["iou"] <= report["iou_interval"][1] < 1
    assert 0 <= report["azimuth_error_degrees"] <= 180
    assert 0 < report["mean_shape_iou"] < 1
    assert 0 < report["nearest_neighbour_iou"] < 1
    assert 0 < report["chamfer_distance"] < 1
    assert report["light_error_degrees"] is None
    page = (road / "run/evaluation/report.md").read_text()
    assert page.startswith("# car: 4 objects in 8 pictures")
    told = re.search(r"\| IoU at 32³ \| (0\.\d{3}) \[", page)
    # Both are rounded, to a digit more or less.
    assert told
    assert float(told[1]) == pytest.approx(report["iou"], abs=0.0006)
    # A row for each of the eight pictures, and one for each of the four objects.
    assert len(opened(road / "run/evaluation/sheet.png")) > 8 * 24
    assert len(opened(road / "run/evaluation/worst.png")) > 4 * 24


def test_the_judge_takes_mesh_files_and_prints_for_people(
    road: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for seed, ending in ((5, "glb"), (6, "obj")):
        vertices, faces = make_shape("car", seed)
        trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / f"car{seed}.{ending}")
    arguments = ["--checkpoint", road / "run", "--validation", road / "validation", "--meshes", tmp_path]
    status, output, _ = answer(capsys, "evaluate", *arguments, "--views", "3", "--output", tmp_path / "judged")
    assert status == 0
    report = json.loads((tmp_path / "judged/metrics.json").read_text())
    assert (report["objects"], report["pictures"]) == (2, 6)
    assert output.startswith("2 objects, 6 pictures of car IoU at 32³ ")
    printed = re.search(r"IoU at 32³ ([\d.]+) \[.*azimuth error, median ([\d.]+)°", output)
    assert printed is not None
    assert float(printed[1]) == pytest.approx(report["iou"], abs=0.001)
    assert float(printed[2]) == pytest.approx(report["azimuth_error_degrees"], abs=0.1)


def test_the_judge_shows_several_views_at_once(road: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--checkpoint", road / "run", "--images", road / "test", "--output", tmp_path]
    status, output, _ = answer(capsys, "evaluate", *arguments, "--views-per-instance", "2")
    assert status == 0
    assert output.startswith("4 objects, 8 pictures of car, shown 2 at once IoU at 32³ ")
    report = json.loads((tmp_path / "metrics.json").read_text())
    assert (report["objects"], report["pictures"], report["views_per_instance"]) == (4, 8, 2)
    assert (tmp_path / "report.md").read_text().startswith("# car: 4 objects in 8 pictures, shown 2 at once\n")
    status, _, errors = answer(capsys, "evaluate", *arguments, "--views-per-instance", "3")
    assert status == 2
    assert "expected a multiple of 3 pictures of each object" in errors


def test_without_validation_pictures_only_the_model_s_own_frame_is_judged(
    road: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--checkpoint", road / "run", "--images", road / "test", "--output", tmp_path]
    status, output, _ = answer(capsys, "evaluate", *arguments)
    assert status == 0
    assert "neither azimuth offset nor temperature are fitted" in output
    report = json.loads((tmp_path / "metrics.json").read_text())
    assert report["iou"] is report["mean_shape_iou"] is report["azimuth_offset_degrees"] is None
    assert 0 < report["iou_unaligned"] < 1


def test_samples_differ_by_their_seed_only(road: Path, tmp_path: Path) -> None:
    sheets = []
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        arguments = ["--checkpoint", str(road / "run"), "--output", str(tmp_path / f"{name}.png"), "--seed", seed]
        assert main(["sample", *arguments, "--count", "2", "--temperature", "3"]) == 0
        sheets.append(opened(tmp_path / f"{name}.png"))
    np.testing.assert_array_equal(sheets[0], sheets[1])
    assert (sheets[0] != sheets[2]).any()


def test_samples_are_drawn_from_where_pictures_have_their_codes(
    road: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["sample", "--checkpoint", str(road / "run"), "--count", "2", "--output", str(tmp_path / "a.png")]
    status, output, _ = answer(capsys, *arguments, "--images", road / "train")
    assert status == 0
    assert "2 samples of" in output
    fitted = opened(tmp_path / "a.png")
    assert main(arguments) == 0
    assert fitted.shape == opened(tmp_path / "a.png").shape
    (tmp_path / "few").mkdir()
    (tmp_path / "few/scene.json").write_bytes((road / "train/scene.json").read_bytes())
    for number, path in enumerate(sorted((road / "train").rglob("*.png"))[:3]):
        (tmp_path / "few" / f"{number}.png").write_bytes(path.read_bytes())
    status, _, errors = answer(capsys, *arguments, "--images", tmp_path / "few")
    assert status == 2
    assert "Expected 40 pictures at least to learn where shape codes lie, found 3" in errors


def test_a_broken_picture_among_many_is_named_and_skipped(
    road: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    pictures = tmp_path / "mine"
    pictures.mkdir()
    for index, path in enumerate(sorted((road / "train").rglob("*.png"))[:8]):
        (pictures / f"{index}.png").write_bytes(path.read_bytes()[: 60 if index == 3 else None])
    (pictures / "scene.json").write_bytes((road / "train/scene.json").read_bytes())
    options = ["--preset", road / "settings.toml", "--optimiser.steps", "1", "--optimiser.batch-size", "2"]
    status, _, errors = answer(capsys, "train", "--images", pictures, "--run", tmp_path / "run", *options)
    assert status == 0
    assert "7 pictures of 7 objects, mine" in errors
    (warning,) = caplog.messages
    assert warning.startswith("skipped 1 of 8 pictures that cannot be read; first: ")
    assert "3.png cannot be read as a picture" in warning
    assert (tmp_path / "run/checkpoint.safetensors").exists()
