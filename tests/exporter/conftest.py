"""A small model as training leaves it."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Literal

import pytest
import torch

import exporter.export
from exporter.export import export
from service.manifest import DECODER_FILE, DECODER_INPUT, ENCODER_FILE, ENCODER_INPUT
from trainer.config import CameraConfig, ModelConfig, SceneConfig, TrainConfig
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint

OFFSET = math.radians(25)


def small_checkpoint(light: Literal["fixed", "varying"] = "fixed") -> Checkpoint:
    torch.manual_seed(3)
    config = TrainConfig(
        width=64,
        height=48,
        model=ModelConfig(latent=5, azimuth_bins=7, light=light, encoder_channels=(4, 4, 4, 8, 8, 8)),
    )
    model = Model(config.model, config.width, config.height).eval()
    with torch.no_grad():
        model.decoder.displacements.weight.mul_(40)
        model.heads.azimuth_logits.weight.mul_(100)
    run = {
        "seconds": 1.5,
        "validation": {"likelihood": -3.0},
        "images": "/home/somebody/cars",
        "fresh": {"meshes": "/mnt/meshes", "rig": "colour"},
    }
    scene = SceneConfig(width=64, height=48, camera=CameraConfig(elevation_degrees=20.0))
    return Checkpoint(config, scene, "car", 12, model, {}, run)


def trained_on_views(checkpoint: Checkpoint, views: int) -> Checkpoint:
    """The same, as if so many pictures of each object had been pooled in training."""
    optimiser = replace(checkpoint.config.optimiser, views_per_instance=views)
    return replace(checkpoint, config=replace(checkpoint.config, optimiser=optimiser))


@pytest.fixture
def checkpoint() -> Checkpoint:
    """A checkpoint of the test's own."""
    return small_checkpoint()


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bundle of that checkpoint, offset 25°; to be read only."""
    directory = tmp_path_factory.mktemp("exported") / "deep" / "car"
    export(small_checkpoint(), directory, OFFSET, {"iou": 0.6})
    return directory


@pytest.fixture
def converted(exported: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The graphs of that bundle take the place of a conversion, which takes seconds: same model, same offset."""
    graphs = {ENCODER_INPUT: ENCODER_FILE, DECODER_INPUT: DECODER_FILE}

    def to_onnx(_module: object, _example: object, input_name: str, _output_names: object) -> bytes:
        return (exported / graphs[input_name]).read_bytes()

    monkeypatch.setattr(exporter.export, "to_onnx", to_onnx)
