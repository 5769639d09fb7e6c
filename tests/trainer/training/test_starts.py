"""Several starts, of which the best goes on; trainings of a few steps."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from tests.trainer.command_line import answer
from tests.trainer.training.runs import EVERY_STEP, run, silent, with_steps
from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.errors import ConfigError, DataError
from trainer.presets import DEFAULT, load_preset
from trainer.selection import starts as starts_module
from trainer.selection.starts import STARTS_FILE, Start, best_start, first_steps, usual_starts
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint
from trainer.training.device import CPU


def begin(
    config: TrainConfig, images: ImageSet, directory: Path, count: int = 3, device: torch.device = CPU
) -> tuple[TrainConfig, list[Start]]:
    told: list[Start] = []
    own = "chair", directory, EVERY_STEP, told.append, silent, {"images": "here"}
    return best_start(config, count, images, *own, device=device), told


def test_the_best_of_the_starts_goes_on_as_if_it_had_been_alone(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    # Learning rates fall from the second step on, towards the tenth and not towards the choice.
    config = replace(with_steps(config, 10), seed=4)
    config = replace(config, optimiser=replace(config.optimiser, decoder_factor=4.0, falling_share=0.9))
    chosen, told = begin(config, images, tmp_path / "run")
    assert [start.seed for start in told] == [4, 5, 6]
    bounds = {start.seed: start.bound for start in told if start.bound is not None}
    assert len(set(bounds.values())) == 3
    assert chosen == replace(config, seed=max(bounds, key=lambda seed: bounds[seed]))
    written = json.loads((tmp_path / "run" / STARTS_FILE).read_text())
    assert written["step"] == 2
    assert written["chosen"] == chosen.seed
    assert [start["bound"] for start in written["starts"]] == list(bounds.values())
    assert load_checkpoint(tmp_path / "run").step == 2

    went_on = run(chosen, images, tmp_path / "run", resume=True)
    alone = run(chosen, images, tmp_path / "alone")
    for name, tensor in alone.model.state_dict().items():
        assert torch.equal(went_on.model.state_dict()[name], tensor), name
    lines = (tmp_path / "run" / "metrics.jsonl").read_text().splitlines()
    assert [json.loads(line)["step"] for line in lines] == list(range(1, 11))


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
def test_starts_on_a_gpu_have_the_bounds_that_they_have_on_the_cpu(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    config = replace(with_steps(config, 10), precision="float32")
    there, here = (begin(config, images, tmp_path / where, 2, torch.device(where))[1] for where in ("cuda", "cpu"))
    assert [start.bound for start in there] == pytest.approx([start.bound for start in here], rel=0.01)


def test_a_start_that_fails_is_passed_over_and_none_at_all_is_an_error(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing = {0, 2}

    def failing_train(config: TrainConfig, *arguments: Any, **options: Any) -> Checkpoint:
        if config.seed in failing:
            raise DataError("Expected finite gradients, found none")
        return train(config, *arguments, **options)

    train = starts_module.train
    monkeypatch.setattr(starts_module, "train", failing_train)
    chosen, told = begin(config, images, tmp_path / "run")
    assert chosen.seed == 1
    assert [start.problem for start in told] == ["Expected finite gradients, found none", None, told[0].problem]
    failing.add(1)
    with pytest.raises(DataError, match=r"None of 3 starts came to step 1.*Expected finite gradients"):
        begin(config, images, tmp_path / "other")
    assert not (tmp_path / "other" / FILE_NAME).exists()


def test_what_an_interrupted_call_has_done_is_not_done_again(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, whole = begin(config, images, tmp_path / "whole")

    def interrupted_train(config: TrainConfig, *arguments: Any, **options: Any) -> Checkpoint:
        if config.seed == 2:
            raise KeyboardInterrupt
        return train(config, *arguments, **options)

    train = starts_module.train
    monkeypatch.setattr(starts_module, "train", interrupted_train)
    with pytest.raises(KeyboardInterrupt):
        begin(config, images, tmp_path / "parts")
    monkeypatch.setattr(starts_module, "train", train)
    done = (tmp_path / "parts/starts/seed-1" / "metrics.jsonl").read_text()
    chosen, again = begin(config, images, tmp_path / "parts")
    assert [start.bound for start in again] == [start.bound for start in whole]
    kept = tmp_path / "parts" / ("." if chosen.seed == 1 else "starts/seed-1") / "metrics.jsonl"
    assert kept.read_text() == done


def test_a_directory_that_holds_a_training_is_left_alone(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    run(config, images, tmp_path)
    before = (tmp_path / FILE_NAME).read_bytes()
    with pytest.raises(ConfigError, match="already holds a training"):
        begin(config, images, tmp_path)
    assert (tmp_path / FILE_NAME).read_bytes() == before


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--starts", "-1"), "Expected --starts from 1 to 100, found -1."),
        (("--starts", "101"), "Expected --starts from 1 to 100, found 101."),
    ],
)
def test_mistakes_are_answered_in_a_sentence(
    options: tuple[str, ...],
    sentence: str,
    picture_folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    command = ("train", "--images", picture_folder, "--run", tmp_path / "run", *options)
    status, _, errors = answer(capsys, *command)
    assert status == 2
    assert sentence in errors
    assert not (tmp_path / "run" / "starts").exists()


def test_poses_that_have_to_be_found_are_looked_for_in_several_starts() -> None:
    default = load_preset(DEFAULT)
    assert [usual_starts(load_preset(name)) for name in (DEFAULT, "detailed", "fast", "balanced", "paper")] == [
        3,
        3,
        1,
        1,
        1,
    ]
    for loss in (replace(default.loss, pose_supervision="azimuth"), replace(default.loss, moved_steps=10)):
        assert usual_starts(replace(default, loss=loss)) == 1
    assert [first_steps(with_steps(default, steps)) for steps in (1, 10, 1500, 6000)] == [1, 2, 300, 300]


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    path = tmp_path / "tiny.toml"
    path.write_text(
        "width = 32\nheight = 24\n[model]\nhidden = 8\nencoder_channels = [4, 4, 8, 8, 8, 16]\n"
        "[optimiser]\nbatch_size = 8\nsteps = 5\n"
    )
    return path


def test_starts_that_were_interrupted_are_resumed(
    picture_folder: Path,
    tiny: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted_train(config: TrainConfig, *arguments: Any, **options: Any) -> Checkpoint:
        if config.seed == 8:
            raise KeyboardInterrupt
        return train(config, *arguments, **options)

    options = ("--images", picture_folder, "--preset", tiny, "--seed", "7", "--starts", "3", "--device", "cpu")
    assert answer(capsys, "train", "--run", tmp_path / "whole", *options)[0] == 0
    train = starts_module.train
    with monkeypatch.context() as patch:
        patch.setattr(starts_module, "train", interrupted_train)
        status, _, errors = answer(capsys, "train", "--run", tmp_path / "parts", *options)
        assert status == 130
        assert "stopped before one of 3 starts was chosen; continue with --resume" in errors
    resumed = ("train", "--run", tmp_path / "parts", "--resume", "--device", "cpu")
    status, _, errors = answer(capsys, *resumed, "--starts", "2")
    assert status == 2
    assert "keep its number of starts, 3, found --starts 2" in errors
    status, _, errors = answer(capsys, *resumed)
    assert status == 0, errors
    assert [start["seed"] for start in json.loads((tmp_path / "parts" / STARTS_FILE).read_text())["starts"]] == [
        7,
        8,
        9,
    ]
    whole, parts = (load_checkpoint(tmp_path / name) for name in ("whole", "parts"))
    assert parts.config == whole.config
    for name, tensor in whole.model.state_dict().items():
        assert torch.equal(parts.model.state_dict()[name], tensor), name


def test_the_command_says_which_start_goes_on(
    picture_folder: Path, tiny: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ("train", "--images", picture_folder, "--run", tmp_path / "run", "--preset", tiny, "--starts", "2")
    status, _, errors = answer(capsys, *command)
    assert status == 0, errors
    chosen = json.loads((tmp_path / "run" / STARTS_FILE).read_text())["chosen"]
    assert "start from seed 0: log p" in errors
    assert f"seed {chosen} explains pictures best, and goes on" in errors
    checkpoint = load_checkpoint(tmp_path / "run")
    assert (checkpoint.step, checkpoint.config.seed) == (5, chosen)
    status, _, errors = answer(capsys, "train", "--run", tmp_path / "run", "--resume", "--starts", "2")
    assert status == 2
    assert "found --starts 2" in errors
