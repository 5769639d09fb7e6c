"""Training on tiny pictures: it learns, it repeats itself exactly, and it stops as it says."""

import json
import math
import os
import signal
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from tests.trainer.training.runs import run, spoiling, with_steps
from trainer.config import OptimiserConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.errors import DataError, StorageError
from trainer.model.loss import LossTerms
from trainer.training import loop
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint
from trainer.training.intervals import Intervals
from trainer.training.loop import MOST_SKIPPED_STEPS, split_instances


def metrics(directory: Path) -> list[dict[str, float]]:
    lines = [json.loads(line) for line in (directory / "metrics.jsonl").read_text().splitlines()]
    return [{name: value for name, value in line.items() if name != "seconds"} for line in lines]


def assert_same(first: Checkpoint, second: Checkpoint) -> None:
    """Bit for bit, the optimiser's state included."""
    pairs = ((first.model.state_dict(), second.model.state_dict()), (first.optimiser_state, second.optimiser_state))
    for one, other in pairs:
        assert one.keys() == other.keys()
        assert [name for name, tensor in one.items() if not torch.equal(tensor, other[name])] == []


@pytest.mark.parametrize("objective", ["exact", "paper"])
def test_a_few_dozen_steps_explain_the_pictures_better(
    config: TrainConfig, images: ImageSet, tmp_path: Path, objective: Literal["exact", "paper"]
) -> None:
    optimiser = OptimiserConfig(batch_size=24, steps=80, learning_rate=3e-3)
    config = replace(config, optimiser=optimiser, loss=replace(config.loss, objective=objective))
    seen: list[dict[str, float]] = []
    last = run(config, images, tmp_path, report=lambda step, figures: seen.append(figures))
    assert last.step == len(seen) == 80
    for name in ("loss", "reconstruction"):
        values = np.array([figures[name] for figures in seen])
        assert values[-10:].mean() < 0.65 * values[:5].mean(), name
    for figures in seen:
        assert figures["loss"] == pytest.approx(sum(figures[term] for term in LossTerms._fields), rel=1e-5)
    assert (seen[-1]["prior_matching"] > 0) == (objective == "paper")
    assert (seen[-1]["distillation"] > 0) == (objective == "exact")


def test_a_run_directory_holds_what_the_documentation_says(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    last = run(config, images, tmp_path / "run")
    names = {path.relative_to(tmp_path / "run").as_posix() for path in (tmp_path / "run").rglob("*") if path.is_file()}
    board = {name for name in names if name.startswith("tensorboard/events")}
    assert names - board == {"config.json", "metrics.jsonl", FILE_NAME, "previews/000006.png"}
    assert len(board) == 1
    assert [line["step"] for line in metrics(tmp_path / "run")] == [1, 2, 3, 4, 5, 6]
    assert json.loads((tmp_path / "run/config.json").read_text())["optimiser"]["batch_size"] == 8
    stored = load_checkpoint(tmp_path / "run")
    assert_same(stored, last)
    assert (stored.category, stored.step, stored.scene) == ("chair", 6, images.scene)
    assert (stored.run["images"], stored.run["pictures"], stored.run["validation_pictures"]) == ("here", 36, 12)
    assert stored.run["device"] == "cpu"


def test_a_resumed_training_hides_nothing_in_tensorboard(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    run(with_steps(config, 3), images, tmp_path)
    run(with_steps(config, 5), images, tmp_path, resume=True)
    board = EventAccumulator(str(tmp_path / "tensorboard"))
    board.Reload()
    assert [event.step for event in board.Scalars("loss")] == [1, 2, 3, 4, 5]


def test_the_same_seed_gives_the_same_model_and_another_another(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    first, second = (run(config, images, tmp_path / name) for name in ("first", "second"))
    assert_same(first, second)
    assert metrics(tmp_path / "first") == metrics(tmp_path / "second")
    other = run(replace(config, seed=1), images, tmp_path / "other")
    assert not torch.equal(first.model.heads.shape_mean.weight, other.model.heads.shape_mean.weight)


@pytest.mark.parametrize("steps", [3, 100])
def test_some_steps_and_as_many_more_are_twice_as_many(
    steps: int, config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    config, seldom = with_steps(config, 2 * steps), Intervals(log=max(1, steps // 4), preview=1000, checkpoint=1000)
    whole = run(config, images, tmp_path / "whole", intervals=seldom)
    half = run(with_steps(config, steps), images, tmp_path / "parts", intervals=seldom)
    seconds = half.run["seconds"]
    assert half.step == steps
    resumed = run(config, images, tmp_path / "parts", resume=True, intervals=seldom)
    assert resumed.step == 2 * steps
    assert resumed.run["seconds"] > seconds
    assert resumed.run["core_seconds"] > half.run["core_seconds"] > 0
    assert_same(whole, resumed)
    assert_same(load_checkpoint(tmp_path / "parts"), whole)
    assert metrics(tmp_path / "whole") == metrics(tmp_path / "parts")


def test_what_a_crash_left_behind_is_forgotten_on_resume(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    """Steps 4 and 5 were logged but not saved, and the last line was cut short."""
    run(with_steps(config, 3), images, tmp_path)
    with (tmp_path / "metrics.jsonl").open("a") as file:
        file.write('{"step": 4, "loss": 1.0}\n{"step": 5, "lo')
    run(config, images, tmp_path, resume=True)
    assert [line["step"] for line in metrics(tmp_path)] == [1, 2, 3, 4, 5, 6]
    assert "lo" not in metrics(tmp_path)[4]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_saves_and_a_resume_goes_on(
    config: TrainConfig, images: ImageSet, tmp_path: Path, number: signal.Signals
) -> None:
    def interrupt(step: int, figures: dict[str, float]) -> None:
        if step == 2:
            os.kill(os.getpid(), number)

    before = signal.getsignal(number)
    stopped = run(config, images, tmp_path / "parts", report=interrupt)
    assert signal.getsignal(number) is before
    assert stopped.step == 2
    assert load_checkpoint(tmp_path / "parts").step == 2
    resumed = run(config, images, tmp_path / "parts", resume=True)
    assert_same(resumed, run(config, images, tmp_path / "whole"))


def test_an_interruption_after_the_last_step_is_not_lost(
    config: TrainConfig, images: ImageSet, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    # A shell's background jobs are born deaf to Ctrl-C.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))

    def interrupt(step: int, figures: dict[str, float]) -> None:
        if step == config.optimiser.steps:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run(config, images, tmp_path, report=interrupt)
    assert load_checkpoint(tmp_path).step == config.optimiser.steps


def test_a_second_interruption_stops_at_once(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    def interrupt(step: int, figures: dict[str, float]) -> None:
        if step == 4:
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run(config, images, tmp_path, report=interrupt)
    assert load_checkpoint(tmp_path).step == 3


@pytest.mark.parametrize("kind", ["gradient", "vertices"])
def test_a_step_that_is_not_finite_changes_nothing_and_is_noted(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    monkeypatch.setattr(loop, "forward", spoiling(kind, {3}))
    three = run(with_steps(config, 3), images, tmp_path / "a")
    monkeypatch.setattr(loop, "forward", spoiling(kind, {3}))
    four = run(with_steps(config, 4), images, tmp_path / "b")
    assert_same(three, four)
    assert not (tmp_path / "a/log.txt").exists()
    assert (tmp_path / "b/log.txt").read_text() == "step 4: the gradient is not finite; the step was skipped\n"
    assert [line["step"] for line in metrics(tmp_path / "b")] == [1, 2, 3]
    monkeypatch.setattr(loop, "forward", spoiling(kind, {3}))
    six = run(config, images, tmp_path / "c")
    assert all(torch.isfinite(tensor).all() for tensor in six.model.state_dict().values())
    assert [line["step"] for line in metrics(tmp_path / "c")] == [1, 2, 3, 5, 6]


def test_many_such_steps_in_a_row_end_the_training_and_the_checkpoint_stays(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    alternating = set(range(5, 5 + 2 * MOST_SKIPPED_STEPS, 2))
    monkeypatch.setattr(loop, "forward", spoiling("gradient", alternating))
    assert run(with_steps(config, 50), images, tmp_path / "alternating").step == 50

    monkeypatch.setattr(loop, "forward", spoiling("gradient", set(range(3, 100))))
    with pytest.raises(
        DataError, match=rf"in {MOST_SKIPPED_STEPS} steps in a row, the last at step {MOST_SKIPPED_STEPS + 3}"
    ):
        run(with_steps(config, 100), images, tmp_path / "lasting")
    stored = load_checkpoint(tmp_path / "lasting")
    assert all(torch.isfinite(tensor).all() for tensor in stored.model.state_dict().values())


def test_supervision_needs_azimuths_and_uses_them(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    config = replace(config, loss=replace(config.loss, pose_supervision="azimuth"))
    with pytest.raises(DataError, match=r"needs the column azimuth_degrees .* has none\. Add it, name a training"):
        run(config, replace(images, azimuths=None), tmp_path / "none")
    assert not (tmp_path / "none").exists()
    assert images.azimuths is not None
    true = run(config, images, tmp_path / "true")
    turned = run(config, replace(images, azimuths=images.azimuths + math.pi), tmp_path / "turned")
    assert not torch.equal(true.model.heads.azimuth_logits.weight, turned.model.heads.azimuth_logits.weight)


def test_a_full_disk_ends_the_training_in_a_sentence(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this machine has no /dev/full to write to")
    run(with_steps(config, 3), images, tmp_path)
    (tmp_path / "log.txt").symlink_to("/dev/full")
    monkeypatch.setattr(loop, "forward", spoiling("gradient", {0}))
    with pytest.raises(StorageError, match=r"cannot be written \(No space left on device\)\. Make room and continue"):
        run(config, images, tmp_path, resume=True)
    assert load_checkpoint(tmp_path).step == 3


def test_views_of_one_object_are_held_out_together(images: ImageSet) -> None:
    training, validation = split_instances(images, 0.25, seed=0)
    assert sorted([*training.tolist(), *validation.tolist()]) == list(range(48))
    assert len(validation) == 12
    assert not set(images.instances[training.numpy()]) & set(images.instances[validation.numpy()])
    assert validation.tolist() != split_instances(images, 0.25, seed=1)[1].tolist()


def test_antialiasing_all_borders_changes_the_gradient(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    config = with_steps(config, 1)
    contours = run(config, images, tmp_path / "contours")
    borders = run(replace(config, loss=replace(config.loss, antialias="borders")), images, tmp_path / "borders")
    names = [name for name in contours.model.state_dict() if name.startswith("decoder")]
    assert any(not torch.equal(contours.model.state_dict()[name], borders.model.state_dict()[name]) for name in names)
