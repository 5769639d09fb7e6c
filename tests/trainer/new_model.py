"""A model that nobody has trained, whose shapes differ all the same."""

from pathlib import Path

import torch

from trainer.config import ModelConfig, SceneConfig, TrainConfig
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint, save_checkpoint

WIDTH, HEIGHT = 32, 24


def new_model() -> Model:
    """Six blocks under varying light."""
    torch.manual_seed(0)
    config = ModelConfig(latent=3, parameterisation="ortho-block", light="varying", encoder_channels=(4, 4, 4, 4, 4, 8))
    model = Model(config, WIDTH, HEIGHT).eval()
    with torch.no_grad():
        model.heads.shape_mean.weight.mul_(300)
        model.decoder.offsets.weight.mul_(30)  # type: ignore[union-attr, operator]
    return model


def save_model(path: Path, model: Model) -> None:
    """Stores it as a checkpoint of cars."""
    config = TrainConfig(width=WIDTH, height=HEIGHT, model=model.config)
    save_checkpoint(path, Checkpoint(config, SceneConfig(WIDTH, HEIGHT), "car", 1, model, {}, {"seconds": 1.0}))
