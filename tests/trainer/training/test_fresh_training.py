"""Training on views that are drawn while it runs: it learns, and goes on exactly where it stopped."""

import os
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.training.runs import EVERY_STEP, Report, silent, with_steps
from trainer.config import OptimiserConfig, SceneConfig, TrainConfig
from trainer.data.fresh import FreshViews, fresh_views
from trainer.data.plan import RenderSettings
from trainer.errors import ConfigError
from trainer.training.checkpoint import Checkpoint, load_checkpoint
from trainer.training.loop import train


def chairs(config: TrainConfig, scene: SceneConfig | None = None, memory: int = 2**30) -> FreshViews:
    scene = scene or SceneConfig(config.width, config.height)
    settings = RenderSettings("chair", seed=1, supersampling=2)
    return fresh_views(settings, scene, 24, config.validation_share, config.seed, memory)


def run(
    config: TrainConfig, views: FreshViews, directory: Path, resume: bool = False, report: Report = silent
) -> Checkpoint:
    return train(config, views, "chair", directory, EVERY_STEP, resume, report, {"fresh": {"instances": 24}})


def same(first: Checkpoint, second: Checkpoint) -> bool:
    """Bit for bit, the optimiser's state included."""
    pairs = ((first.model.state_dict(), second.model.state_dict()), (first.optimiser_state, second.optimiser_state))
    return all(torch.equal(one[name], other[name]) for one, other in pairs for name in one.keys() | other.keys())


def test_a_few_dozen_steps_explain_views_never_seen_better(config: TrainConfig, tmp_path: Path) -> None:
    config = replace(config, optimiser=OptimiserConfig(batch_size=24, steps=80, learning_rate=3e-3))
    losses: list[float] = []
    last = run(config, chairs(config), tmp_path, report=lambda step, figures: losses.append(figures["loss"]))
    assert np.mean(losses[-10:]) < 0.8 * np.mean(losses[:5])
    assert (last.run["pictures"], last.run["validation_pictures"]) == (18, 6)
    assert load_checkpoint(tmp_path).run["fresh"] == {"instances": 24}
    assert (tmp_path / "previews/000080.png").exists()


def test_three_steps_and_three_more_are_six(config: TrainConfig, tmp_path: Path) -> None:
    whole = run(config, chairs(config), tmp_path / "whole")
    run(with_steps(config, 3), chairs(config), tmp_path / "parts")
    # With next to no memory, so that every mesh is made again: it must not matter.
    resumed = run(config, chairs(config, memory=1), tmp_path / "parts", resume=True)
    assert resumed.step == 6
    assert same(whole, resumed)
    assert not same(whole, run(replace(config, seed=1), chairs(config), tmp_path / "other"))


def test_an_interruption_saves_and_a_resume_goes_on(config: TrainConfig, tmp_path: Path) -> None:
    def interrupt(step: int, figures: dict[str, float]) -> None:
        if step == 2:
            os.kill(os.getpid(), signal.SIGINT)

    assert run(config, chairs(config), tmp_path / "parts", report=interrupt).step == 2
    assert same(
        run(config, chairs(config), tmp_path / "parts", resume=True), run(config, chairs(config), tmp_path / "a")
    )


def test_another_camera_is_refused_on_resume(config: TrainConfig, tmp_path: Path) -> None:
    run(with_steps(config, 1), chairs(config), tmp_path)
    scene = SceneConfig(config.width, config.height, ambient=(0.1, 0.1, 0.1))
    with pytest.raises(ConfigError, match="another camera or other lights"):
        run(config, chairs(config, scene), tmp_path, resume=True)


def test_views_of_other_objects_are_refused_on_resume(config: TrainConfig, tmp_path: Path) -> None:
    run(with_steps(config, 1), chairs(config), tmp_path)
    for fresh in ({"instances": 24, "shape_seed": 5}, {}):
        with pytest.raises(ConfigError, match="trained on other pictures than these"):
            train(config, chairs(config), "chair", tmp_path, EVERY_STEP, True, silent, {"fresh": fresh})
    roomier = {"fresh": {"instances": 24, "mesh_memory_mib": 7}}
    assert train(config, chairs(config), "chair", tmp_path, EVERY_STEP, True, silent, roomier).step == 6


def test_azimuths_are_known_for_supervision(config: TrainConfig, tmp_path: Path) -> None:
    supervised = replace(config, loss=replace(config.loss, pose_supervision="azimuth"))
    free, told = run(config, chairs(config), tmp_path / "free"), run(supervised, chairs(config), tmp_path / "told")
    assert not torch.equal(free.model.heads.azimuth_logits.weight, told.model.heads.azimuth_logits.weight)
