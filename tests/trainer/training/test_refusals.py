"""What a training refuses before it begins, and that it then leaves everything as it was."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.trainer.training.runs import run, silent, with_steps
from trainer.config import OptimiserConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.errors import CheckpointError, ChiaroError, ConfigError, DataError, StorageError
from trainer.training.checkpoint import FILE_NAME, load_checkpoint
from trainer.training.intervals import Intervals
from trainer.training.loop import train


def test_a_directory_in_use_and_one_with_nothing_to_resume_are_refused(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    config = with_steps(config, 1)
    with pytest.raises(CheckpointError, match="found nothing"):
        run(config, images, tmp_path / "run", resume=True)
    run(config, images, tmp_path / "run")
    old = (tmp_path / "run" / FILE_NAME).read_bytes()
    with pytest.raises(ConfigError, match=r"already holds a training\. Continue it with --resume, or name another"):
        run(config, images, tmp_path / "run")
    assert (tmp_path / "run" / FILE_NAME).read_bytes() == old
    (tmp_path / "file").write_text("x")
    with pytest.raises(StorageError, match="could not write"):
        run(config, images, tmp_path / "file")


def test_only_the_optimiser_may_change_on_resume(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    run(with_steps(config, 1), images, tmp_path)
    other_loss = replace(config, loss=replace(config.loss, kl_weight=7.0))
    for changed in (other_loss, replace(config, seed=3), replace(config, validation_share=0.5)):
        with pytest.raises(ConfigError, match=r"trained with other settings .* another directory"):
            run(changed, images, tmp_path, resume=True)
    scene = replace(images.scene, camera=replace(images.scene.camera, elevation_degrees=10.0))
    with pytest.raises(ConfigError, match="another camera or other lights"):
        run(config, replace(images, scene=scene), tmp_path, resume=True)
    fewer = replace(images, **{name: getattr(images, name)[:-4] for name in ("pictures", "names", "instances")})
    with pytest.raises(ConfigError, match=r"on other pictures than these: expected \d+ to train on and \d+ held out"):
        run(config, fewer, tmp_path, resume=True)
    with pytest.raises(ConfigError, match=r"of class chair, from the same source, found .* of lamp"):
        train(config, images, "lamp", tmp_path, Intervals(), True, silent, {"images": "here"})
    assert load_checkpoint(tmp_path).step == 1
    slower = replace(config, optimiser=OptimiserConfig(batch_size=4, steps=2, learning_rate=1e-4))
    assert run(slower, images, tmp_path, resume=True).step == 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"width": 8}, "width from 16 to 2048, found 8"),
        ({"seed": -1}, "seed from 0 to .*, found -1"),
        ({"validation_share": math.nan}, "validation_share from 0 to 0.5, found nan"),
        ({"optimiser": {"batch_size": 1}}, "optimiser.batch_size from 2 to .*, found 1"),
        ({"optimiser": {"steps": 0}}, "optimiser.steps from 1 to .*, found 0"),
        ({"optimiser": {"learning_rate": -1.0}}, "optimiser.learning_rate from .*, found -1"),
        ({"model": {"latent": 0}}, "model.latent from 1 to .*, found 0"),
        ({"model": {"segments": 10**6}}, "model.segments from 1 to 64, found 1000000"),
        ({"model": {"encoder_channels": (4, 4, 0, 4, 4, 4)}}, "model.encoder_channels from 1 to 4096, found 0"),
        ({"loss": {"kl_weight": -1.0}}, "loss.kl_weight from 0 to .*, found -1"),
        ({"loss": {"temperature": 0.0}}, "loss.temperature from 1e-09 to .*, found 0"),
        ({"loss": {"laplacian_weight": math.inf}}, "loss.laplacian_weight from 0 to .*, found inf"),
        ({"loss": {"eta": 0.0}}, "loss.eta from 1e-09 to .*, found 0"),
        ({"model": {"light_bins": 0}}, "model.light_bins from 1 to 180, found 0"),
        ({"model": {"parameterisation": "ortho-block", "blocks": -1}}, "model.blocks from 0 to 1024, found -1"),
        ({"optimiser": {"views_per_instance": 0}}, "optimiser.views_per_instance from 1 to 64, found 0"),
        ({"optimiser": {"rotation_learning_rate": 0.0}}, "optimiser.rotation_learning_rate from .*, found 0"),
        ({"model": {"parameterisation": "full-block", "blocks": 1025}}, "model.blocks from 0 to 1024, found 1025"),
        (
            {"model": {"parameterisation": "full-block", "segments": 3}},
            "model.segments left at 4 with model.parameterisation full-block, found 3: blocks have none. .*train subd",
        ),
        (
            {"model": {"parameterisation": "ortho-block", "segments": 4, "base": "cup"}},
            "model.base left at cube with model.parameterisation ortho-block, found cup: .* train subdivision",
        ),
        ({"model": {"proportions": (1, 0, 1)}}, "model.proportions from 1 to 64, found 0"),
        (
            {"model": {"segments": 4, "proportions": (1, 17, 1)}},
            "at most 64 segments along an edge, found model.segments 4 times model.proportions 17",
        ),
        (
            {"model": {"parameterisation": "full-block", "segments": 4, "proportions": (1, 1, 2)}},
            "model.proportions left at 1 1 1 with full-block, found 1 1 2: only a cube's .* train subdivision",
        ),
        (
            {"model": {"base": "cup", "proportions": (1, 2, 1)}},
            "model.proportions left at 1 1 1 with model.base cup, found 1 2 1: .* --model.base cube",
        ),
        (
            {"model": {"light_bins": 5}},
            r"model.light_bins left at 3 with model.light fixed, found 5: .* --model\.light varying",
        ),
        (
            {"loss": {"objective": "paper", "neighbour_weight": 0.5}},
            "loss.neighbour_weight of 0 with loss.objective paper, found 0.5: .* --loss.objective exact",
        ),
        (
            {"loss": {"inversion_weight": 9.0}, "model": {"base": "cup"}},
            "loss.inversion_weight of 0 with model.base cup, found 9: .* --model.base cube",
        ),
        (
            {"loss": {"inversion_weight": 9.0}, "model": {"parameterisation": "full-block", "segments": 4}},
            "loss.inversion_weight of 0 with full-block, found 9: only the inside of a displaced cube .* subdivision",
        ),
        (
            {"loss": {"inner_points": "learnt"}},
            "loss.inner_points carried with loss.inversion_weight of 0, found learnt: .* --loss.inversion-weight 1",
        ),
        (
            {"loss": {"front_back_weight": 5.0}, "model": {"symmetry": "two-mirrors"}},
            "loss.front_back_weight of 0 with model.symmetry two-mirrors, found 5: .* --model.symmetry mirror",
        ),
        (
            {"loss": {"front_back_weight": 5.0}, "model": {"parameterisation": "ortho-block", "segments": 4}},
            "loss.front_back_weight of 0 with ortho-block, found 5: .* train subdivision",
        ),
        (
            {"loss": {"front_back_knee": 2.0}},
            "loss.front_back_knee of 0 with loss.front_back_weight of 0, found 2: .* --loss.front-back-weight 20",
        ),
        (
            {"loss": {"front_back_after": 600}},
            "loss.front_back_after of 0 with loss.front_back_weight of 0, found 600: .* --loss.front-back-weight 20",
        ),
        ({"model": {"blocks": 3}}, "model.blocks of 0 with model.parameterisation subdivision, found 3"),
        ({"optimiser": {"views_per_instance": 3}}, r"optimiser.batch_size to be a multiple .* \(3\) .*, found 8"),
        ({"optimiser": {"views_per_instance": 8}}, r"optimiser.batch_size to be .* of two objects at least, found 8"),
    ],
)
def test_settings_that_mean_nothing_are_refused(
    config: TrainConfig, images: ImageSet, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    changed = {
        name: replace(getattr(config, name), **value) if isinstance(value, dict) else value
        for name, value in change.items()
    }
    with pytest.raises(ConfigError, match=f"Expected {message}"):
        run(replace(config, **changed), images, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_silhouettes_do_not_go_with_lights_that_vary(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    mixed = replace(config, loss=replace(config.loss, kind="silhouette"), model=replace(config.model, light="varying"))
    with pytest.raises(ConfigError, match=r"model\.light fixed with loss\.kind silhouette.* --loss\.kind shading"):
        run(mixed, images, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_several_views_need_objects_that_have_them(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    grouped = with_steps(replace(config, optimiser=OptimiserConfig(batch_size=9, views_per_instance=3)), 1)
    with pytest.raises(DataError, match=r"3 pictures or more of each object, found 2 of chair-.* column instance"):
        run(grouped, images, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_pictures_whose_objects_are_not_named_are_no_views_of_one(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    """Without the column instance each picture is an object of its own."""
    alone = replace(images, instances=np.arange(len(images)), instance_names=images.names)
    grouped = replace(config, optimiser=OptimiserConfig(batch_size=8, views_per_instance=2))
    with pytest.raises(DataError, match=r"Expected 2 pictures or more of each object, found 1 of .* column instance"):
        run(grouped, alone, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_lights_that_are_turned_need_a_model_that_turns_them(
    config: TrainConfig, images: ImageSet, tmp_path: Path
) -> None:
    turned, config = replace(images, light_azimuths=np.linspace(0, 3, len(images))), with_steps(config, 1)
    with pytest.raises(DataError, match=r"found lights that are turned\. Train with --model\.light varying"):
        run(config, turned, tmp_path / "run")
    # To silhouettes it is all the same.
    run(replace(config, loss=replace(config.loss, kind="silhouette")), turned, tmp_path / "silhouette")
    run(replace(config, model=replace(config.model, light="varying")), turned, tmp_path / "varying")


@pytest.mark.parametrize("name", ["log", "preview", "checkpoint"])
def test_intervals_of_no_steps_are_refused(config: TrainConfig, images: ImageSet, tmp_path: Path, name: str) -> None:
    intervals = replace(Intervals(), **{name: 0})
    with pytest.raises(ConfigError, match=f"--intervals.{name} of 1 step or more, found 0"):
        train(config, images, "chair", tmp_path / "run", intervals, False, silent, {})


def test_every_refusal_is_an_error_that_the_command_line_tells() -> None:
    assert all(issubclass(kind, ChiaroError) for kind in (ConfigError, DataError, CheckpointError, StorageError))
