"""`make models`, with commands that only pretend: what is trained, how long, and what is chosen."""

import json
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
import tyro

from tests.scripts_as_modules import SCRIPTS, loaded
from trainer.commands.train import TrainCommand
from trainer.training.checks import check_settings

OVERLAPS = {"subdivision": 0.3, "full-block": 0.4}


class Commands:
    """What is asked for, in order; trainings and judgements leave the files that the script reads."""

    def __init__(self, figures: tuple[str, ...]) -> None:
        self.figures = figures
        self.trained: list[tuple[str, int, bool]] = []
        self.told: dict[str, object] = {}
        self.unknown: dict[str, tuple[object, object]] = {}
        self.reframed: dict[str, float] = {}
        self.judged: list[str] = []
        self.rivals: list[str] = []

    def __call__(self, module: str, *arguments: object, quiet: bool = False) -> None:
        options = dict(zip(map(str, arguments), arguments[1:], strict=False))
        if module == "exporter":
            bundle = Path(str(options["--output"]))
            bundle.mkdir(parents=True, exist_ok=True)
            (bundle / "manifest.json").write_text(str(options["--checkpoint"]))
        elif module == "exporter.rivals":
            assert all((Path(str(options["--models"])) / name / "manifest.json").exists() for name in self.rivals)
            self.rivals.append("fitted")
        elif arguments[0] == "render" and "rivals" in str(options["--output"]):
            self.rivals.append(str(options["--class"]))
        elif arguments[0] == "train":
            directory, steps = Path(str(options["--run"])), int(str(options["--optimiser.steps"]))
            self.trained.append((directory.name, steps, "--resume" in arguments))
            self.told[directory.name] = options.get("--poses-of")
            self.unknown[directory.name] = options.get("--unknown-to"), options.get("--unknown-poses-of")
            directory.mkdir(parents=True, exist_ok=True)
            (directory / "checkpoint.safetensors").touch()
            self.reframed[directory.name] = float(str(options["--reframing-share"]))
            last = steps + round(self.reframed[directory.name] * steps)
            (directory / "metrics.jsonl").write_text(json.dumps({"step": last, "seconds": 1.0}) + "\n")
        elif arguments[0] == "evaluate":
            directory, output = Path(str(options["--checkpoint"])), Path(str(options["--output"]))
            self.judged.append(output.name)
            output.mkdir(parents=True, exist_ok=True)
            told = {
                **dict.fromkeys(self.figures, 0.5),
                "iou": OVERLAPS[directory.name.removesuffix("-screened")],
            }
            (output / "metrics.json").write_text(json.dumps(told))
            (output / "sheet.png").write_text(f"{directory.name}, {output.name}")


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return loaded("models", monkeypatch)


@pytest.fixture
def make(script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Commands]:
    def made(*options: str) -> Commands:
        commands = Commands(script.FIGURES)
        monkeypatch.setattr(script, "run", commands)
        monkeypatch.setattr(script, "write_invented", lambda *paths: None)
        monkeypatch.setattr(script, "load_checkpoint", _on_a_gpu_at_first)
        folders = ["--output", tmp_path / "models", "--work", tmp_path / "work", "--real-meshes", tmp_path / "none"]
        monkeypatch.setattr(sys, "argv", ["models.py", *map(str, folders), *options])
        assert script.main() == 0
        return commands

    return made


def test_several_bundles_are_judged_beside_each_other(make: Callable[..., Commands]) -> None:
    assert make("--only", "sofa", "car-white-light", "--steps", "50").rivals == []
    assert make("--only", "car", "--steps", "50").rivals == ["car", "sofa", "fitted"]


def test_all_candidates_are_screened_and_the_best_is_trained(make: Callable[..., Commands], tmp_path: Path) -> None:
    commands = make("--only", "loudspeaker", "--screening-steps", "20", "--steps", "50")
    screened = [("subdivision-screened", 20, False), ("full-block-screened", 20, False)]
    assert commands.trained == [*screened, ("full-block", 50, False)]
    assert commands.judged == ["screening", "screening", "test"]
    assert (tmp_path / "models/loudspeaker/manifest.json").read_text().endswith("runs/loudspeaker/full-block")
    assert (tmp_path / "models/loudspeaker.png").read_text() == "full-block, test"
    figures = _figures(tmp_path)["loudspeaker"]
    assert figures["parameterisation"] == "full-block"
    assert figures["screened_iou"] == OVERLAPS
    (training,) = figures["trainings"]
    assert "--optimiser.steps 50 --class loudspeaker --model.parameterisation full-block" in training["command"]
    assert "render --class loudspeaker --seed 0 --instances 4000 --rig colour --output PICTURES" in figures["pictures"]


def test_what_is_there_is_not_made_again_but_trained_longer(make: Callable[..., Commands], tmp_path: Path) -> None:
    make("--only", "loudspeaker", "--screening-steps", "20", "--steps", "50")
    again = make("--only", "loudspeaker", "--screening-steps", "20", "--steps", "50")
    assert not again.trained
    assert not again.judged
    longer = make("--only", "loudspeaker", "--screening-steps", "20", "--steps", "80")
    assert longer.trained == [("full-block", 80, True)]
    assert longer.judged == ["test"]


def test_one_that_was_stopped_before_its_last_phase_goes_on(make: Callable[..., Commands], tmp_path: Path) -> None:
    make("--only", "loudspeaker", "--candidates", "subdivision", "--steps", "50")
    told = tmp_path / "work/runs/loudspeaker/subdivision/metrics.jsonl"
    told.write_text(json.dumps({"step": 50, "seconds": 1.0}) + "\n")
    again = make("--only", "loudspeaker", "--candidates", "subdivision", "--steps", "50")
    assert again.trained == [("subdivision", 50, True)]
    assert again.judged == ["test"]


def test_a_single_candidate_is_trained_to_the_end_at_once(make: Callable[..., Commands], tmp_path: Path) -> None:
    commands = make("--only", "loudspeaker", "--candidates", "subdivision", "--steps", "50")
    assert commands.trained == [("subdivision", 50, False)]
    assert commands.judged == ["test"]
    assert _figures(tmp_path)["loudspeaker"]["screened_iou"] == {}


def test_a_first_training_finds_the_poses_that_the_model_is_told(
    make: Callable[..., Commands], script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = script.Model("sofa", "sofa", "sharp", 30, candidates=("full-block",))
    taught = script.Model("sofa", "sofa", "detailed", 70, first=first)
    monkeypatch.setattr(script, "MODELS", (taught,))
    commands = make("--only", "sofa")
    assert commands.trained == [("first", 30, False), ("subdivision", 70, False)]
    assert commands.told == {"first": None, "subdivision": tmp_path / "work/runs/sofa/first"}
    figures, page = _figures(tmp_path)["sofa"], (tmp_path / "models/README.md").read_text()
    assert [training["on"] for training in figures["trainings"]] == ["GPU", "core"]
    found, told = (training["command"] for training in figures["trainings"])
    assert "--preset sharp --optimiser.steps 30 --class sofa" in found
    assert found.endswith("--run FIRST")
    assert told.endswith("--poses-of FIRST --run RUN")
    assert f"{figures['pictures']}\n{found}\n{told}\n" in page
    assert not make("--only", "sofa").trained


def test_a_second_training_finds_the_poses_that_the_first_does_not(
    make: Callable[..., Commands], script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = script.Model("sofa", "sofa", "sharp", 30, candidates=("full-block",))
    second = script.Model("sofa", "sofa", "sharp", 20)
    taught = script.Model("sofa", "sofa", "told", 70, first=first, second=second, reframing_share=1.0)
    monkeypatch.setattr(script, "MODELS", (taught,))
    commands = make("--only", "sofa")
    assert commands.trained == [("first", 30, False), ("second", 20, False), ("subdivision", 70, False)]
    runs = tmp_path / "work/runs/sofa"
    assert commands.told == {"first": None, "second": None, "subdivision": runs / "first"}
    assert commands.unknown == {"first": (None, None), "second": (runs / "first", None),
                                "subdivision": (None, runs / "second")}  # fmt: skip
    assert commands.reframed == {"first": 0.5, "second": 0.5, "subdivision": 1.0}
    _, found, told = (training["command"] for training in _figures(tmp_path)["sofa"]["trainings"])
    assert "--preset sharp --optimiser.steps 20 --class sofa" in found
    assert found.endswith("--unknown-to FIRST --run SECOND")
    assert told.endswith("--reframing-share 1 --poses-of FIRST --unknown-poses-of SECOND --run RUN")


def test_the_page_keeps_models_that_were_made_before(make: Callable[..., Commands], tmp_path: Path) -> None:
    make("--only", "jar", "car-white-light")
    make("--only", "sofa")
    assert list(_figures(tmp_path)) == ["jar", "sofa", "car-white-light"]
    page = (tmp_path / "models/README.md").read_text()
    assert page.count("| sofa | full-block | 0.40 |") == page.count("| jar |") == 1
    assert "(sofa.png)" in page
    assert "(../models-light/car-white-light.png)" in page
    assert (tmp_path / "models-light/car-white-light/manifest.json").exists()
    assert not (tmp_path / "models/car-white-light").exists()


def _on_a_gpu_at_first(directory: Path) -> SimpleNamespace:
    return SimpleNamespace(run={"device": "cuda"} if directory.name == "first" else {})


def _figures(folder: Path) -> dict[str, Any]:
    read: dict[str, Any] = json.loads((folder / "models/figures.json").read_text())
    return read


def test_every_candidate_is_a_training_that_is_taken(script: ModuleType) -> None:
    former = (model for shipped in script.MODELS for model in (shipped.first, shipped.second) if model)
    for model in (*script.MODELS, *former):
        for candidate in model.candidates:
            options = ["--preset", model.preset, *script.training_options(model, candidate)]
            command = tyro.cli(
                TrainCommand,
                args=["--images", "pictures", "--run", "run", *options],
                default=TrainCommand.default(["train", *options]),
            )
            assert command.config.model.parameterisation == candidate
            check_settings(command.config)


def test_the_models_that_ship_were_trained_as_the_script_says(script: ModuleType) -> None:
    known = json.loads((SCRIPTS.with_name("models") / "figures.json").read_text())
    for model in script.MODELS:
        options = shlex.join(script.training_options(model, known[model.name]["parameterisation"]))
        told = f"--preset {model.preset} --optimiser.steps {model.steps} {options} --images"
        commands = [training["command"] for training in known[model.name]["trainings"]]
        # Some had their encoders taught anew afterwards.
        *found, last = (command for command in commands if "exporter.restoring" not in command)
        assert told in last, model.name
        # 0.5 is what it was when these were trained.
        asked = shlex.split(last)
        share = asked[asked.index("--reframing-share") + 1] if "--reframing-share" in asked else 0.5
        assert float(share) == model.reframing_share, model.name
        former = [training for training in (model.first, model.second) if training]
        for training, command in zip(former, found, strict=True):
            (candidate,) = training.candidates
            options = shlex.join(script.training_options(training, candidate))
            told = f"--preset {training.preset} --optimiser.steps {training.steps} {options} --images"
            assert told in command, model.name
