"""The encoder learns to see objects where the rule sets them and as another camera took them, and nothing else."""

import json
import os
import signal
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from imaging.decoding import Picture
from imaging.framing import box_around, frame_of, framed
from tests.imaging.photographs import shape
from tests.trainer.training.runs import EVERY_STEP, run, silent, with_steps
from trainer.config import SceneConfig, TrainConfig
from trainer.data.images import ImageSet, Preparation, frame_in
from trainer.data.picture import draw
from trainer.errors import DataError
from trainer.model.vae import Model
from trainer.training import lessons as lessons_module
from trainer.training import reframing
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint
from trainer.training.lessons import Studied, lessons
from trainer.training.longer_look import Look, energy_of, look_longer
from trainer.training.loop import MOST_SKIPPED_STEPS
from trainer.training.reframing import reframe, reframed, retaken

SCENE = SceneConfig(64, 48)
STEPS = 40


def rendered(category: str, seed: int, size: int) -> Tensor:
    """[3, H, W], `size` times as large as the scene's."""
    scene = SceneConfig(size * SCENE.width, size * SCENE.height)
    return torch.from_numpy(draw(shape(category, seed), seed * 2.4, 0.0, scene, 2)[0].transpose(2, 0, 1).copy())


def by_rule(picture: Tensor) -> Tensor:
    """As the service brings a cut-out object into the scene's frame."""
    colour = picture.numpy()
    columns, rows = (np.arange(count + 1.0) for count in reversed(colour.shape[1:]))
    large = Picture(colour, None, columns, rows, 1)
    frame = frame_of(SCENE.width, SCENE.height, SCENE.camera.distance, SCENE.camera.field_of_view_degrees)
    box = box_around(large, (colour.max(0) > 0.003).astype(np.float32))
    return torch.from_numpy(framed(large, box, frame))


def test_objects_are_brought_where_the_rule_sets_them() -> None:
    drawn = [(category, seed) for category in ("car", "chair", "airplane") for seed in range(8)]
    pictures = torch.stack([rendered(category, seed, 1) for category, seed in drawn])
    expected = torch.stack([by_rule(rendered(category, seed, 8)) for category, seed in drawn])
    found = reframed(pictures, frame_in(SCENE), torch.zeros(len(drawn), 3))
    left = (found - expected).square().sum((1, 2, 3)) / (pictures - expected).square().sum((1, 2, 3))
    assert left.median() < 0.12
    assert left.max() < 0.6


def test_noise_moves_and_scales() -> None:
    picture = torch.zeros(1, 3, 48, 64)
    picture[:, 1, 20:28, 24:40] = 0.5
    frame = frame_in(SCENE)

    def extent(*noise: float) -> tuple[float, float, float]:
        light = reframed(picture, frame, torch.tensor([noise]))[0, 1]
        x, y = (torch.arange(count) + 0.5 for count in (64, 48))
        return (
            float(light.sum()),
            float((light.sum(0) * x).sum() / light.sum()),
            float((light.sum(1) * y).sum() / light.sum()),
        )

    area, right, down = extent(0, 0, 0)
    assert (right, down) == (pytest.approx(32, abs=0.1), pytest.approx(24 + frame.drop, abs=0.1))
    larger, moved_right, moved_down = extent(2, 3, -3)
    assert larger / area == pytest.approx(np.exp(2 * 2 * 0.03), rel=0.02)
    assert moved_right - right == pytest.approx(0.03 * frame.diagonal, abs=0.05)
    assert moved_down - down == pytest.approx(-0.03 * frame.diagonal, abs=0.05)


def test_a_picture_of_nothing_stays_black() -> None:
    assert not reframed(torch.zeros(2, 3, 48, 64), frame_in(SCENE), torch.randn(2, 3)).any()


def test_another_camera_is_brighter_or_darker_of_another_balance_and_cuts_off_what_is_too_bright() -> None:
    picture = torch.zeros(1, 3, 48, 64)
    picture[:, :, 20:28, 24:40] = torch.tensor([0.2, 0.4, 0.8])[:, None, None]

    def middle(exposure: float, *balance: float) -> list[float]:
        return retaken(picture, torch.tensor([[0.0, exposure, *balance]]))[0, :, 24, 32].tolist()

    assert torch.equal(retaken(picture, torch.zeros(1, 5)), picture)
    assert middle(1, 0, 0, 0) == pytest.approx([0.2 * np.exp(0.5), 0.4 * np.exp(0.5), 1])
    assert middle(-2, 1, 0, -1) == pytest.approx([0.2 * np.exp(-0.9), 0.4 * np.exp(-1), 0.8 * np.exp(-1.1)])
    assert not retaken(torch.zeros(2, 3, 48, 64), torch.randn(2, 5)).any()


def test_another_camera_is_sharper_or_softer() -> None:
    """A blur of a pixel's width, or what it takes away once more."""
    picture = torch.full((1, 3, 48, 64), 0.25)
    picture[..., 32:] = 0.75
    soft, sharp = (retaken(picture, torch.tensor([[way / 0.7, 0, 0, 0, 0]]))[0, 1, 24, 30:34] for way in (-1.0, 1.0))
    assert soft.tolist() == pytest.approx([0.25, 0.375, 0.625, 0.75])
    assert sharp.tolist() == pytest.approx([0.25, 0.125, 0.875, 0.75])


def test_only_the_encoder_learns_and_agrees_more_with_what_was_said(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    before = run(config, images, tmp_path)
    old = state(before)
    reports: list[tuple[int, dict[str, float]]] = []
    after = reframe(before, tmp_path, images, STEPS, EVERY_STEP, lambda *told: reports.append(told))
    new = state(load_checkpoint(tmp_path))
    changed = {name.partition(".")[0] for name in old if not torch.equal(old[name], new[name])}
    assert changed == {"encoder", "heads"}
    assert (after.step, after.reframing_steps, load_checkpoint(tmp_path).reframing_steps) == (6, STEPS, STEPS)
    assert after.run["seconds"] > 0
    assert [step for step, _ in reports] == list(range(7, 7 + STEPS))
    lines = [json.loads(line) for line in (tmp_path / "metrics.jsonl").read_text().splitlines()]
    assert [line["step"] for line in lines] == list(range(1, 7 + STEPS))
    assert reports[-1][1]["loss"] < 0.7 * reports[0][1]["loss"]


def test_pictures_come_with_what_was_found_in_them(config: TrainConfig, images: ImageSet) -> None:
    look = Look(torch.arange(len(images))[:, None].float(), torch.arange(len(images)) / 100, None)
    pictures, found, _ = next(lessons(config, Studied(images, look), 0))
    assert found is not None
    chosen = found.shape_code[:, 0].long()
    assert len(chosen.unique()) > 1
    assert torch.equal(pictures, images.batch(chosen))
    assert torch.equal(found.azimuth_fine, chosen / 100)


def test_the_encoder_learns_what_a_longer_look_finds(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    """Its word is nearer to that after the phase, and pictures are explained better by it, than with its own word."""
    before = run(with_steps(config, 40), images, tmp_path)
    pictures = images.batch(range(len(images)))
    look = look_longer(before.model, before.scene, config, pictures, 20)

    def off_and_energy(looking: int) -> tuple[float, float]:
        after = reframe(deepcopy(before), tmp_path, images, 60, EVERY_STEP, silent, looking=looking).model.eval()
        with torch.no_grad():
            said = after.encode(pictures)
            word = Look(said.shape_mean, said.azimuth_fine_mean, None)
            energy = energy_of(after, before.scene, config, pictures, said)(word)
        return float((word.shape_code - look.shape_code).square().mean()), float(energy.mean())

    (off, energy), (off_by_itself, energy_by_itself) = off_and_energy(20), off_and_energy(0)
    assert off < 0.8 * off_by_itself
    assert energy < energy_by_itself


def test_objects_that_were_cut_out_stay_where_they_are(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rule has set them all; another camera may still have taken them."""
    placed, taken = list[int](), list[int]()

    def placing(pictures: Tensor, *arguments: Any) -> Tensor:
        placed.append(len(pictures))
        return reframed(pictures, *arguments)

    def retaking(pictures: Tensor, noise: Tensor) -> Tensor:
        taken.append(len(pictures))
        return retaken(pictures, noise)

    monkeypatch.setattr(reframing, "reframed", placing)
    monkeypatch.setattr(reframing, "retaken", retaking)
    before, cut_out = run(config, images, tmp_path), replace(images, preparation=Preparation(background=len(images)))
    assert not reframe(before, tmp_path, cut_out, 2, EVERY_STEP, silent, looking=1).reframed
    assert (placed, taken) == ([], [8, 8])
    assert reframe(before, tmp_path, images, 2, EVERY_STEP, silent, looking=1).reframed
    assert placed == [8, 8]
    assert not before.reframed


def test_as_many_pictures_are_looked_at_as_is_said(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, looked = run(config, images, tmp_path), []

    def looking(model: Model, scene: SceneConfig, config: TrainConfig, pictures: Tensor, steps: int) -> Look:
        looked.append((len(pictures), steps))
        return look_longer(model, scene, config, pictures, 1)

    monkeypatch.setattr(lessons_module, "look_longer", looking)
    monkeypatch.setattr(lessons_module, "_LOOKED_AT_ONCE", 16)
    reframe(before, tmp_path / "all", images, 1, EVERY_STEP, silent, looking=7)
    # A quarter is held out.
    assert looked == [(16, 7), (16, 7), (4, 7)]
    looked.clear()
    monkeypatch.setattr(reframing, "MOST_STUDIED", 20)
    reframe(before, tmp_path / "some", images, 1, EVERY_STEP, silent)
    assert looked == [(16, 20), (4, 20)]
    looked.clear()
    reframe(before, tmp_path / "none", images, 1, EVERY_STEP, silent, looking=0)
    pooled = replace(before, config=replace(config, optimiser=replace(config.optimiser, views_per_instance=2)))
    reframe(pooled, tmp_path / "pooled", images, 1, EVERY_STEP, silent)
    assert not looked


def test_what_was_done_is_not_done_again(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    done = reframe(run(config, images, tmp_path), tmp_path, images, 3, EVERY_STEP, silent)
    written = (tmp_path / FILE_NAME).read_bytes()
    resumed = run(config, images, tmp_path, resume=True)
    assert resumed.reframing_steps == 3
    for steps in (3, 2, 0):
        again = reframe(resumed, tmp_path, images, steps, EVERY_STEP, silent)
        assert (tmp_path / FILE_NAME).read_bytes() == written
        assert_same(again, done)


def test_one_that_is_stopped_begins_anew(
    config: TrainConfig, images: ImageSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(step: int, figures: dict[str, float]) -> None:
        if step == 8:
            os.kill(os.getpid(), signal.SIGINT)

    def look_and_stop(*arguments: Any) -> Look:
        os.kill(os.getpid(), signal.SIGINT)
        return look_longer(*arguments)

    monkeypatch.setattr(lessons_module, "_LOOKED_AT_ONCE", 16)
    whole = reframe(run(config, images, tmp_path / "whole"), tmp_path / "whole", images, 4, EVERY_STEP, silent)
    before = run(config, images, tmp_path / "parts")
    stopped = reframe(before, tmp_path / "parts", images, 4, EVERY_STEP, stop)
    assert stopped.reframing_steps == load_checkpoint(tmp_path / "parts").reframing_steps == 0
    assert_same(load_checkpoint(tmp_path / "parts"), stopped)
    with monkeypatch.context() as looking:
        looking.setattr(lessons_module, "look_longer", look_and_stop)
        assert_same(reframe(before, tmp_path / "parts", images, 4, EVERY_STEP, silent), stopped)
    resumed = run(config, images, tmp_path / "parts", resume=True)
    assert_same(reframe(resumed, tmp_path / "parts", images, 4, EVERY_STEP, silent), whole)


def test_more_steps_of_training_undo_it(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    reframe(run(config, images, tmp_path), tmp_path, images, 3, EVERY_STEP, silent)
    further = run(with_steps(config, 8), images, tmp_path, resume=True)
    assert (further.step, further.reframing_steps) == (8, 0)


def test_a_gradient_that_is_never_finite_ends_it(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    before = run(config, images, tmp_path)
    with torch.no_grad():
        before.model.heads.shape_mean.bias[0] = torch.nan
    with pytest.raises(DataError, match=f"none in {MOST_SKIPPED_STEPS} steps in a row, the last at step 26"):
        reframe(before, tmp_path, images, 40, EVERY_STEP, silent, looking=0)
    with pytest.raises(DataError, match=r"can be drawn: .*finite.* lower --optimiser.learning-rate"):
        reframe(before, tmp_path, images, 40, EVERY_STEP, silent)
    assert load_checkpoint(tmp_path).reframing_steps == 0


def state(checkpoint: Checkpoint) -> dict[str, Tensor]:
    return {name: tensor.clone() for name, tensor in checkpoint.model.state_dict().items()}


def assert_same(first: Checkpoint, second: Checkpoint) -> None:
    one, other = state(first), state(second)
    assert [name for name, tensor in one.items() if not torch.equal(tensor, other[name])] == []
