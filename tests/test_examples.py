"""The jobs of examples/ ask for commands that there are; what would start them only notes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from trainer.commands.line import run
from trainer.commands.render import RenderCommand
from trainer.commands.train import TrainCommand
from trainer.data.shapes.catalogue import CATEGORIES

ROOT = Path(__file__).parents[1]


def asked(script: str, number: int, folder: Path) -> list[list[str]]:
    """What one job of the array runs, after the Python that it begins with."""
    noted = folder / "noted"
    noted.write_text("")
    (folder / "srun").write_text(f'#!/bin/bash\nprintf "%s\\n" "$*" >> {noted}\n')
    (folder / "srun").chmod(0o755)
    known = {"SLURM_ARRAY_TASK_ID": str(number), "SLURM_CPUS_PER_TASK": "4", "PATH": f"{folder}:{os.environ['PATH']}"}
    subprocess.run(["bash", ROOT / "examples" / script], check=True, cwd=folder, env=os.environ | known)
    return [line.split(".venv/bin/python ", 1)[1].split() for line in noted.read_text().splitlines()]


def test_the_sweep_trains_every_class_with_three_seeds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trained: list[tuple[str, int]] = []
    rendered: list[str] = []
    monkeypatch.setattr(RenderCommand, "run", lambda self: rendered.append(self.category))
    monkeypatch.setattr(TrainCommand, "run", lambda self: trained.append((self.category, self.config.seed)))
    for number in range(39):
        for python, program, *arguments in asked("sweep.slurm", number, tmp_path):
            assert (python, program) == ("-m", "trainer")
            assert run(arguments) == 0
    assert sorted(trained) == sorted((category, seed) for category in CATEGORIES for seed in range(3))
    assert rendered == [category for category, _ in trained]


def test_a_job_of_the_sweep_goes_on_where_it_was(tmp_path: Path) -> None:
    checkpoint = tmp_path / "out" / "sweep" / "runs" / "chair-1" / "checkpoint.safetensors"
    checkpoint.parent.mkdir(parents=True)
    checkpoint.touch()
    _, training = asked("sweep.slurm", 4, tmp_path)
    assert "--resume" in training
    assert "--seed" not in training


def test_every_model_that_ships_is_one_job_s(tmp_path: Path) -> None:
    made = []
    for number in range(15):
        ((script, *options),) = asked("models.slurm", number, tmp_path)
        assert script == "scripts/models.py"
        made.append(dict(zip(options[::2], options[1::2], strict=True)))
    assert {one["--only"] for one in made} == set(json.loads((ROOT / "models" / "figures.json").read_text()))
    assert len({one["--output"] for one in made}) == 15
    assert len({one["--work"] for one in made}) == 1
    asking = [sys.executable, ROOT / "scripts" / "models.py", "--help"]
    known = subprocess.run(asking, check=True, capture_output=True, text=True)
    assert all(option in known.stdout for option in made[0])
