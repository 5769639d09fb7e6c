"""`scripts/reteach.py`, with commands that only pretend: what is asked for, and what the figures say of it."""

import json
import shlex
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import tyro

from exporter.restoring import RestoringOptions
from tests.scripts_as_modules import loaded
from trainer.commands.train import TrainCommand


def test_a_bundle_s_encoder_is_taught_and_the_figures_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = loaded("reteach", monkeypatch)
    models, asked = tmp_path / "models", list[tuple[str, ...]]()
    models.mkdir()
    first = {"command": "python -m trainer train ...", "seconds": 100.0, "on": "GPU"}
    known = {"lamp": {"parameterisation": "subdivision", "trainings": [first], "screened_iou": {}}}
    (models / "figures.json").write_text(json.dumps(known))

    def run(*arguments: object, quiet: bool) -> None:
        asked.append(tuple(map(str, arguments)))
        directory = Path(asked[-1][asked[-1].index("--run") + 1])
        directory.mkdir(parents=True, exist_ok=True)
        (directory / "checkpoint.safetensors").touch()
        (directory / "metrics.jsonl").write_text(json.dumps({"step": 11250, "seconds": 350.5}))

    def publish(
        workshop: Any, model: Any, chosen: str, directory: Path, trainings: list[dict[str, Any]]
    ) -> dict[str, Any]:
        return {"trainings": trainings, "test": {"iou": 0.5}, "published": [chosen, directory.name]}

    def write_figures(output: Path, name: str, figures: dict[str, Any]) -> None:
        (output / "figures.json").write_text(json.dumps({name: figures}))

    for name, pretended in (("run", run), ("publish", publish), ("write_figures", write_figures)):
        monkeypatch.setattr(script, name, pretended)
    monkeypatch.setattr(script, "render", lambda workshop, model: None)
    restored = SimpleNamespace(run={"restored_from": {"seconds": 120.0}})
    monkeypatch.setattr(script, "load_checkpoint", lambda directory: restored)
    folders = ["--models", models, "--work", tmp_path / "work", "--only", "lamp"]
    monkeypatch.setattr(sys, "argv", ["reteach.py", *map(str, folders)])
    for _ in range(2):  # the second time nothing is restored, and nothing told twice
        assert script.main() == 0
    assert [arguments[0] for arguments in asked] == ["exporter.restoring", "trainer", "trainer"]
    assert asked[0][2] == str(models / "lamp")
    assert asked[1][asked[1].index("--reframing-share") + 1] == "0.375"
    figures = json.loads((models / "figures.json").read_text())["lamp"]
    assert figures["published"] == ["subdivision", "again"]
    before, taught = figures["trainings"]
    assert before == first
    assert (taught["seconds"], taught["on"]) == (230.5, "core")
    restoring, training = taught["command"].split(" && ")
    tyro.cli(RestoringOptions, args=shlex.split(restoring)[3:])
    options = [option for option in shlex.split(training)[3:] if option != "--resume"]
    assert tyro.cli(TrainCommand, args=options[1:], default=TrainCommand.default(options)).reframing_share == 0.375
