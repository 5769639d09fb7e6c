"""`python -m trainer`: every option is explained, every mistake is answered in a sentence, and the whole road works."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from trainer.__main__ import main
from trainer.commands import render as render_command
from trainer.commands.render import RenderCommand
from trainer.data.plan import read_settings
from trainer.data.shapes.catalogue import make_shape

SMALL = ["--width", "32", "--height", "24"]
COMMANDS = ("render", "train", "evaluate", "sample")


def start(*arguments: str | Path) -> subprocess.Popen[str]:
    """`python -m trainer …` in a process group of its own, as a terminal would start it: with Ctrl-C not ignored, as it
    is where these tests themselves run in the background of a shell."""
    command = [sys.executable, "-m", "trainer", *map(str, arguments)]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
    finally:
        signal.signal(signal.SIGINT, before)


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    with start(*arguments) as process:
        output, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors
    return subprocess.CompletedProcess(process.args, process.returncode, output, errors)


def answer(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str, str]:
    """(status, standard output, standard error) of a command in this process, line breaks and frames taken away."""
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as ending:
        status = int(ending.code or 0)
    captured = capsys.readouterr()
    return status, *(re.sub(r"[\s│╭╮╰╯─]+", " ", text) for text in captured)


@pytest.fixture(autouse=True)
def _width_of_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Options stand in one column only on a narrow one."""
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.parametrize(
    ("command", "phrases"),
    [
        ("render", ["--output PATH", "--category STR", "--width INT Width of a picture, pixels. (default: 128)"]),
        (
            "render",
            ["--camera.elevation-degrees FLOAT Height of the camera above the horizon, degrees. (default: 30.0)"],
        ),
        ("train", ["--images PATH", "--run PATH", "--optimiser.learning-rate FLOAT", "(paper: 10⁻³, constant)"]),
        ("train", ["--threads INT", "0 means one per core. (default: 0)", "--intervals.checkpoint INT", "steps;"]),
        ("train", ["Presets: ", "demo", "paper", "--preset STR", "(default: demo)"]),
        ("evaluate", ["--checkpoint PATH", "--views INT", "1 to 360 (paper: 24)", "(default: 24)", "--json"]),
        ("sample", ["--count INT How many shapes, 1 to 100. (default: 6)", "--temperature FLOAT", "(default: 1.0)"]),
    ],
)
def test_help_explains_every_option(capsys: pytest.CaptureFixture[str], command: str, phrases: list[str]) -> None:
    status, output, _ = answer(capsys, command, "--help")
    assert status == 0
    for phrase in phrases:
        assert phrase in output


@pytest.mark.parametrize("command", COMMANDS)
def test_no_option_is_without_an_explanation(capsys: pytest.CaptureFixture[str], command: str) -> None:
    assert main_help(capsys, command)
    for option, text in main_help(capsys, command).items():
        assert re.search(r"\w{3,} .*\((default: .*|required)\)$", text), f"{option}: {text!r}"


def main_help(capsys: pytest.CaptureFixture[str], command: str) -> dict[str, str]:
    """The explanation of each option."""
    _, output, _ = answer(capsys, command, "--help")
    parts = re.split(r" (?=--[a-z.]+[a-z-]* (?:[A-Z{]|, --))", output.partition("--help")[2])
    found = dict(part.split(" ", 1) for part in parts if part.startswith("--"))
    return {option: re.sub(r"\)[^)]*$", ")", text) for option, text in found.items()}


def test_the_commands_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    status, output, _ = answer(capsys, "--help")
    assert status == 0
    for phrase in ("render Render pictures", "train Learn shape and pose", "evaluate Judge", "sample Invent shapes"):
        assert phrase in output


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("rendr", "render, train, evaluate, sample"),
        ("render --output out --category car --widht 3", "Perhaps you meant: --width INT"),
        ("train --images a --run b --optimiser.step 3", "Perhaps you meant: --optimiser.steps INT"),
        ("train --images a --run b --loss.objectve exact", "Perhaps you meant: --loss.objective {exact,paper}"),
        ("train --images a --run b --loss.objective best", "best"),
        ("train --images a --run b --preset deno", "no preset 'deno'; did you mean 'demo'?"),
        ("render --output out --category car --width ten", "--width"),
        ("render --output out", "either --category CLASS or --meshes DIRECTORY, found both or neither"),
        ("render --output out --category car --meshes there", "found both or neither"),
        ("render --output out --category caar", "found 'caar'; did you mean 'car'?"),
        ("render --output out --category .", "expected a class out of car, chair, found '.'"),
        ("render --output out --meshes absent", "expected a folder of meshes at HERE/absent, found nothing"),
        ("render --output out --category car --width 0", "width: expected 1 to 8192, found 0"),
        ("render --output out --category car --width 8000 --height 8000", "Expected at most 134,217,728 samples"),
        ("render --output out --category car --instances -1", "--instances from 0 to 1000000, found -1"),
        ("render --output out --category car --views 0", "--views from 1 to 1000, found 0"),
        ("render --output out --category car --supersampling 0", "--supersampling from 1 to 32, found 0"),
        ("render --output out --category car --workers -2", "--workers from 0 to 1024, found -2"),
        ("render --output out --category car --seed -1", "expected a seed of 0 or more"),
        ("render --output out --category car --camera.distance nan", "distance: expected 0.51 to 10000.0, found nan"),
        ("train --images absent --run b", "expected a folder of pictures at absent, found nothing"),
        ("train --images . --run b --category cars", "expected pictures (.png, .jpg, .jpeg, .webp) in . or below it"),
        ("train --images a --run b --width 0", "Expected width from 16 to 2048, found 0"),
        ("train --images a --run b --threads -1", "Expected --threads from 0 to"),
        ("train --images a --run b --threads 100000", "all that this machine offers, found 100000"),
        ("train --images a --run b --intervals.log 0", "--intervals.log of 1 step or more, found 0"),
        ("train --images a --run b --category Große-Autos", "category of small letters, digits, - and _"),
        ("train --images a --run absent --resume", "Expected a checkpoint at absent, found nothing"),
        ("evaluate --checkpoint absent --validation v --images a", "Expected a checkpoint at absent, found nothing"),
        ("evaluate --checkpoint absent --validation v", "either --images or --meshes, found both or neither"),
        ("evaluate --checkpoint absent --validation v --images a --meshes b", "found both or neither"),
        ("evaluate --checkpoint absent --validation v --meshes a --views 0", "--views from 1 to 360, found 0"),
        ("sample --checkpoint absent", "Expected a checkpoint at absent, found nothing"),
        ("sample --checkpoint absent --count 0", "--count from 1 to 100, found 0"),
        ("sample --checkpoint absent --temperature nan", "--temperature from 0 to 10, found nan"),
        ("sample --checkpoint absent --seed -1", "--seed from 0 to"),
    ],
)
def test_a_mistake_is_answered_in_a_sentence_and_nothing_is_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: str, sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, output, errors = answer(capsys, *arguments.split())
    assert status == 2
    assert output == ""
    assert sentence.replace("HERE", str(tmp_path)) in errors
    assert not list(tmp_path.iterdir())


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


def test_ctrl_c_is_one_sentence(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(render_command, "render_folder", interrupted)
    status, output, errors = answer(capsys, "render", "--output", "out", "--category", "car")
    assert (status, output) == (130, "")
    assert errors == "interrupted; finished files are kept, and nothing is half-written "


def test_ctrl_c_while_several_processes_render(tmp_path: Path) -> None:
    """A terminal sends the signal to all of them: one sentence, no traceback, and whole pictures only."""
    options = ["--category", "chair", "--instances", "4000", "--workers", "2", *SMALL]
    with start("render", "--output", tmp_path / "out", *options) as process:
        wait_for(process, lambda: any((tmp_path / "out").rglob("*.png")))
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert output == ""
    assert errors.endswith("interrupted; finished files are kept, and nothing is half-written\n")
    assert "Traceback" not in errors
    pictures = list((tmp_path / "out").rglob("*.png"))
    assert 0 < len(pictures) < 4000
    assert {opened(path).shape for path in pictures} == {(24, 32, 3)}
    assert not list((tmp_path / "out").rglob("*.part"))


def opened(path: Path) -> np.ndarray:
    with Image.open(path) as picture:
        return np.asarray(picture)


def wait_for(process: subprocess.Popen[str], happened: object) -> None:
    assert callable(happened)
    deadline = time.monotonic() + 60
    while not happened():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.fixture(scope="module")
def road(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures to train, validate and test on, and a model that was interrupted, and then trained on to the end."""
    root = tmp_path_factory.mktemp("road")
    for seed, (name, count) in enumerate((("train", 20), ("validation", 4), ("test", 4))):
        options = [
            "--category",
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
    options = ["--preset", settings, "--category", "car", "--threads", "1", "--intervals.log", "1"]
    metrics = root / "run" / "metrics.jsonl"
    with start("train", "--images", root / "train", "--run", root / "run", *options) as process:
        wait_for(process, lambda: metrics.exists() and len(metrics.read_text().splitlines()) > 3)
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    assert (process.returncode, output) == (0, ""), errors
    assert re.search(r"stopped; continue with --resume at step \d+", " ".join(errors.split()))
    reached = len(metrics.read_text().splitlines())
    assert 4 <= reached < 100000
    resumed = run(
        "train", "--run", root / "run", "--resume", "--intervals.log", "1", "--optimiser.steps", str(reached + 5)
    )
    assert resumed.returncode == 0, resumed.stderr
    assert f"finished at step {reached + 5}" in " ".join(resumed.stderr.split())
    assert [json.loads(line)["step"] for line in metrics.read_text().splitlines()] == list(range(1, reached + 6))
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
    # A row for each of the eight pictures.
    assert len(opened(road / "run/evaluation/sheet.png")) > 8 * 24


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
    assert output.startswith("2 objects, 6 pictures of car IoU ")
    printed = re.search(r"IoU ([\d.]+) \[.*azimuth error ([\d.]+)° \(median\)", output)
    assert printed is not None
    assert float(printed[1]) == pytest.approx(report["iou"], abs=0.001)
    assert float(printed[2]) == pytest.approx(report["azimuth_error_degrees"], abs=0.1)


def test_samples_differ_by_their_seed_only(road: Path, tmp_path: Path) -> None:
    sheets = []
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        arguments = ["--checkpoint", str(road / "run"), "--output", str(tmp_path / f"{name}.png"), "--seed", seed]
        assert main(["sample", *arguments, "--count", "2", "--temperature", "3"]) == 0
        sheets.append(opened(tmp_path / f"{name}.png"))
    np.testing.assert_array_equal(sheets[0], sheets[1])
    assert (sheets[0] != sheets[2]).any()


def test_a_broken_picture_among_many_is_named_and_skipped(
    road: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    pictures = tmp_path / "mine"
    pictures.mkdir()
    for index, path in enumerate(sorted((road / "train").rglob("*.png"))[:8]):
        (pictures / f"{index}.png").write_bytes(path.read_bytes()[: 60 if index == 3 else None])
    options = ["--preset", road / "settings.toml", "--optimiser.steps", "1", "--optimiser.batch-size", "2"]
    status, _, errors = answer(capsys, "train", "--images", pictures, "--run", tmp_path / "run", *options)
    assert status == 0
    assert "7 pictures of 7 objects, mine" in errors
    (warning,) = caplog.messages
    assert warning.startswith("skipped 1 of 8 pictures that cannot be read; first: ")
    assert "3.png cannot be read as a picture" in warning
    assert (tmp_path / "run/checkpoint.safetensors").exists()
