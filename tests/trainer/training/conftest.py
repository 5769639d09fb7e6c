"""Tiny pictures and settings: a training step takes a few hundredths of a second."""

from pathlib import Path

import pytest

from trainer.config import LossConfig, ModelConfig, OptimiserConfig, SceneConfig, TrainConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder

WIDTH, HEIGHT = 32, 24


@pytest.fixture(scope="session")
def picture_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """24 chairs, two pictures each, with azimuths."""
    folder = tmp_path_factory.mktemp("pictures") / "chair"
    settings = RenderSettings("chair", seed=1, supersampling=2)
    render_folder(folder, settings, SceneConfig(WIDTH, HEIGHT), 24, 2, 1, show_progress=False)
    return folder


@pytest.fixture(scope="session")
def images(picture_folder: Path) -> ImageSet:
    """To be read only."""
    return load_image_folder(picture_folder, WIDTH, HEIGHT)


@pytest.fixture
def config() -> TrainConfig:
    return TrainConfig(
        width=WIDTH,
        height=HEIGHT,
        precision="float32",
        validation_share=0.25,
        model=ModelConfig(latent=4, azimuth_bins=6, segments=2, encoder_channels=(4, 4, 8, 8, 8, 16)),
        loss=LossConfig(kl_weight=1.0, kl_weight_start=1.0, laplacian_weight=1.0, laplacian_weight_start=1.0),
        optimiser=OptimiserConfig(batch_size=8, steps=6, learning_rate=3e-3),
    )
