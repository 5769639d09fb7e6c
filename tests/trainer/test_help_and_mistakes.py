"""Every command explains itself, and answers a mistake in a sentence."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.trainer.command_line import answer

COMMANDS = (
    "shapes",
    "render",
    "train",
    "evaluate",
    "sample",
    "interpolate",
    "reconstruct",
    "table",
    "select",
    "stability",
    "frontier",
)


@pytest.fixture(autouse=True)
def _width_of_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Options stand in one column only on a narrow one."""
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.parametrize(
    ("command", "phrases"),
    [
        ("shapes", ["--class STR", "--sheet PATH"]),
        ("render", ["--output PATH", "--class STR", "--width INT Width of a picture, pixels. (default: 128)"]),
        (
            "render",
            ["--camera.elevation-degrees FLOAT Height of the camera above the horizon, degrees. (default: 30.0)"],
        ),
        (
            "render",
            ["--rig STR Lights: colour, white, or a TOML file", "--rotate-lights", "--renderer {chiaro,pyrender}"],
        ),
        ("render", ["--shapenet {None}|PATH", "--split {all,train,validation,test}"]),
        ("train", ["--meshes DIR Instead of --images", "--shapenet DIR", "--instances INT", "--mesh-memory-mib INT"]),
        ("train", ["--images {None}|PATH", "--run PATH", "--optimiser.learning-rate FLOAT", "(paper: 10⁻³, constant)"]),
        ("train", ["--threads INT", "0 means one per core. (default: 0)", "--intervals.checkpoint INT", "steps;"]),
        ("train", ["Presets: ", "balanced", "paper", "--preset STR", "(default: sharp)"]),
        (
            "evaluate",
            ["--checkpoint {None}|PATH", "--bundle {None}|PATH", "1 to 360 (paper: 24)", "(default: 24)", "--json"],
        ),
        ("sample", ["--count INT How many shapes, 1 to 100. (default: 6)", "--temperature FLOAT", "(default: 1.0)"]),
        ("sample", ["--turntable, --no-turntable Also write an animation in which all shapes turn"]),
        ("reconstruct", ["--images PATH", "--turntable, --no-turntable Also write an animation in which the shape"]),
        ("interpolate", ["PATH Picture of the object to begin with", "--steps INT How many shapes, 2 to 64"]),
        ("table", ["STR Which table. (required)", "--seeds", "(default: 0 1 2)", "--budget FLOAT Instead of --steps"]),
        ("frontier", ["--budget STR Which points", "--report {None}|PATH", "--dry-run, --no-dry-run Only say"]),
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
    for phrase in (
        "render Render pictures", "train Learn shape and pose", "evaluate Judge", "sample Invent shapes",
        "interpolate Change one object into another", "reconstruct Reconstruct one object", "table Train and judge",
    ):  # fmt: skip
        assert phrase in output


@pytest.mark.parametrize("command", ["render", "shapes"])
def test_what_needs_no_torch_does_not_wait_for_it(command: str) -> None:
    program = (
        "import sys\nfrom trainer.commands.line import run\n"
        f"status = run(['{command}', '--class', 'zebra'] + ['--output', 'out'] * ('{command}' == 'render'))\n"
        "sys.exit(status if not {'torch', 'scipy.interpolate', 'trimesh'} & set(sys.modules) else 1)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert "found 'zebra'" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("rendr", "render, train, evaluate, sample"),
        ("render --output out --class car --widht 3", "Perhaps you meant: --width INT"),
        ("train --images a --run b --optimiser.step 3", "Perhaps you meant: --optimiser.steps INT"),
        ("train --images a --run b --loss.objectve exact", "Perhaps you meant: --loss.objective {exact,paper}"),
        ("train --images a --run b --loss.objective best", "best"),
        ("train --images a --run b --preset shrap", "no preset 'shrap'; did you mean 'sharp'?"),
        ("render --output out --class car --width ten", "--width"),
        ("render --output out", "either --class CLASS or --meshes DIRECTORY, found both or neither"),
        ("render --output out --class car --meshes there", "found both or neither"),
        ("render --output out --class caar", "found 'caar'; did you mean 'car'?"),
        ("render --output out --class .", "expected a class out of airplane, bathtub, bench, car"),
        ("render --output out --meshes absent", "expected a folder of meshes at HERE/absent, found nothing"),
        ("render --output out --class car --width 0", "width: expected 1 to 8192, found 0"),
        ("render --output out --class car --width 8000 --height 8000", "Expected at most 134,217,728 samples"),
        ("render --output out --class car --instances -1", "--instances from 0 to 1000000, found -1"),
        ("render --output out --class car --views 0", "--views from 1 to 1000, found 0"),
        ("render --output out --class car --supersampling 0", "--supersampling from 1 to 32, found 0"),
        ("render --output out --class car --stretch 0.6", "--stretch from 0 to 0.5, found 0.6"),
        ("render --output out --class car --workers -2", "--workers from 0 to 1024, found -2"),
        ("render --output out --class car --seed -1", "expected a seed of 0 or more"),
        ("render --output out --class car --camera.distance nan", "distance: expected 0.56 to 10000.0, found nan"),
        ("render --output out --class car --rig wite", "There is no rig 'wite'; did you mean 'white'?"),
        ("render --output out --class car --rig my.toml", "The rig my.toml cannot be read"),
        ("render --output out --class car --renderer pyrendr", "pyrendr"),
        (
            "render --output out --class car --split test",
            "Expected --shapenet DIRECTORY beside --split test, found none",
        ),
        (
            "render --output out --shapenet there",
            "Expected --class CLASS and no --meshes beside --shapenet DIRECTORY, found no",
        ),
        ("render --output out --class car --shapenet there --meshes here", "beside --shapenet DIRECTORY, found both"),
        ("render --output out --class caar --shapenet there", "found 'caar'; did you mean 'car'?"),
        (
            "render --output out --class car --shapenet there",
            "expected ShapeNetCore at HERE/there, that is folders such",
        ),
        (
            "train --run b",
            "Expected one of --images DIR, --shards DIR, --meshes DIR, --shapenet DIR and --class CLASS, found none.",
        ),
        ("train --run b --images here --meshes there", "and --class CLASS, found here and there."),
        ("train --run b --class caar", "found 'caar'; did you mean 'car'?"),
        ("train --run b --meshes absent", "expected a folder of meshes at HERE/absent, found nothing"),
        ("train --run b --class car --shapenet absent", "expected ShapeNetCore at HERE/absent"),
        ("train --run b --class car --instances 1", "Expected at least 2 objects to train on, found 1 in car"),
        ("train --run b --class car --instances -1", "--instances from 0 to 1000000, found -1"),
        ("train --run b --class car --supersampling 0", "--supersampling from 1 to 32, found 0"),
        ("train --run b --class car --stretch -0.1", "--stretch from 0 to 0.5, found -0.1"),
        ("train --run b --class car --mesh-memory-mib 0", "--mesh-memory-mib from 1 to 1048576, found 0"),
        ("train --run b --class car --shape-seed -1", "--shape-seed from 0 to 2147483647, found -1"),
        ("train --run b --class car --rig wite", "There is no rig 'wite'; did you mean 'white'?"),
        ("train --run b --class car --camera.distance 0", "distance: expected 0.56 to 10000.0, found 0.0"),
        ("train --run b --class car --rotate-lights", "Expected --model.light varying with --rotate-lights"),
        ("train --images absent --run b", "expected a folder of pictures at absent, found nothing"),
        ("train --images . --run b --class cars", "expected pictures (.png, .jpg, .jpeg, .webp) in . or below it"),
        ("train --images a --run b --width 0", "Expected width from 16 to 2048, found 0"),
        (
            "train --images a --run b --loss.front-back-weight 20 --loss.front-back-after 600 --optimiser.steps 600",
            "Expected loss.front_back_after below optimiser.steps, 600, found 600: front and back would never",
        ),
        ("train --images a --run b --threads -1", "Expected --threads from 0 to"),
        ("train --images a --run b --threads 100000", "all that this machine offers, found 100000"),
        ("train --images a --run b --intervals.log 0", "--intervals.log of 1 step or more, found 0"),
        ("train --images a --run b --class Große-Autos", "category of small letters, digits, - and _"),
        ("train --images a --run absent --resume", "Expected a checkpoint at absent, found nothing"),
        ("evaluate --checkpoint absent --validation v --images a", "Expected a checkpoint at absent, found nothing"),
        ("evaluate --checkpoint absent --validation v", "either --images or --meshes, found both or neither"),
        ("evaluate --checkpoint absent --validation v --images a --meshes b", "found both or neither"),
        ("evaluate --checkpoint absent --validation v --meshes a --views 0", "--views from 1 to 360, found 0"),
        ("evaluate --checkpoint a --images b --views-per-instance 0", "--views-per-instance from 1 to 64, found 0"),
        ("evaluate --checkpoint a --meshes b --views-per-instance 5", "a multiple of --views-per-instance 5, found 24"),
        ("evaluate --images a", "either --checkpoint or --bundle, found both or neither"),
        ("evaluate --checkpoint a --bundle b --images c", "either --checkpoint or --bundle, found both or neither"),
        ("evaluate --bundle absent --images a", "Expected a bundle at absent, found no manifest.json"),
        ("interpolate a.png b.png --checkpoint absent", "Expected a checkpoint at absent, found nothing"),
        ("interpolate a.png b.png --checkpoint absent --steps 1", "--steps from 2 to 64, found 1"),
        ("interpolate a.png --checkpoint absent", "required"),
        ("reconstruct --checkpoint absent --images a", "Expected a checkpoint at absent, found nothing"),
        ("sample --checkpoint absent", "Expected a checkpoint at absent, found nothing"),
        ("sample --checkpoint absent --count 0", "--count from 1 to 100, found 0"),
        ("sample --checkpoint absent --temperature nan", "--temperature from 0 to 10, found nan"),
        ("sample --checkpoint absent --seed -1", "--seed from 0 to"),
        ("sample --checkpoint absent --turntable --output a.webp", "to end in .png beside --turntable, found a.webp"),
        ("table tabel-2", "There is no table 'tabel-2'; did you mean 'table-2'"),
        ("table table-2 --classes caar", "found 'caar'; did you mean 'car'?"),
        ("table table-2 --steps 5 --budget 1", "Expected either --steps or --budget, found both"),
        ("train --class car --run b --model.parameterisation ortho-block --model.segments 3", "blocks have none"),
        (
            "train --class car --run b --model.light-bins 5",
            "Expected model.light_bins left at 3 with model.light fixed",
        ),
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
