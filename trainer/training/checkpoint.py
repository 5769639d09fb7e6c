"""A checkpoint: one safetensors file with weights and optimiser state, and everything else as JSON in its header.

It is written beside its name and then renamed, so that the name always holds a whole checkpoint.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor

from trainer.config import SceneConfig, TrainConfig
from trainer.errors import CheckpointError, ConfigError, StorageError
from trainer.mapping import from_mapping, to_mapping
from trainer.model.vae import Model

FORMAT_VERSION = 1
FILE_NAME = "checkpoint.safetensors"


@dataclass(frozen=True)
class Checkpoint:
    """A training at one step."""

    config: TrainConfig
    scene: SceneConfig
    """Camera, lights and size of the pictures that the model saw (already reduced to the training's size)."""
    category: str
    """What the pictures show, one word."""
    step: int
    """Steps taken."""
    model: Model
    optimiser_state: dict[str, Tensor]
    """Adam's moments and step counts, named `<state>.<parameter>`."""
    run: dict[str, Any]
    """Summary of the run so far: seconds, pictures, validation figures."""


def save_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Raises StorageError where the file cannot be written; an older checkpoint at `path` then stays."""
    tensors = {f"model.{name}": tensor.contiguous() for name, tensor in checkpoint.model.state_dict().items()}
    tensors |= {f"optimiser.{name}": tensor.contiguous() for name, tensor in checkpoint.optimiser_state.items()}
    header = {
        "format_version": FORMAT_VERSION,
        "config": to_mapping(checkpoint.config),
        "scene": to_mapping(checkpoint.scene),
        "category": checkpoint.category,
        "step": checkpoint.step,
        "run": checkpoint.run,
    }
    beside = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_file(tensors, beside, metadata={"chiaro": json.dumps(header)})
        beside.replace(path)
    except (OSError, SafetensorError) as error:
        beside.unlink(missing_ok=True)
        raise StorageError(
            f"The checkpoint {path} could not be written ({error}). Nothing was lost: the last whole checkpoint is still "
            "there. Free some space or name another run directory, then continue with --resume."
        ) from error


def load_checkpoint(path: Path) -> Checkpoint:
    """A checkpoint from its file or from its run directory; the model is in evaluation mode.

    Raises:
        CheckpointError: no such file, not a checkpoint, another format version, or tensors that do not fit the model.
    """
    file = path / FILE_NAME if path.is_dir() else path
    if not file.is_file():
        raise CheckpointError(
            f"Expected a checkpoint at {file}, found nothing. Name a run directory that `trainer train` has written, or "
            f"its {FILE_NAME}."
        )
    try:
        with safe_open(file, framework="pt") as opened:
            header = json.loads((opened.metadata() or {}).get("chiaro", "null"))
            tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118
    except (SafetensorError, OSError, ValueError) as error:
        raise CheckpointError(f"{file} is not a checkpoint of chiaro ({error}). Train again, or use a copy.") from error
    if not isinstance(header, dict) or "format_version" not in header:
        raise CheckpointError(f"{file} holds tensors, but not chiaro's header. Name a file that chiaro has written.")
    if header["format_version"] != FORMAT_VERSION:
        raise CheckpointError(
            f"{file} has format version {header['format_version']}, this chiaro reads version {FORMAT_VERSION}. Use the "
            "chiaro that wrote it, or train again."
        )
    try:
        config = from_mapping(TrainConfig, header["config"], f"{file}, config")
        scene = from_mapping(SceneConfig, header["scene"], f"{file}, scene")
        category, step, run = str(header["category"]), int(header["step"]), dict(header["run"])
        model = Model(config.model, config.width, config.height)
        model.load_state_dict(_under("model.", tensors))
    except (ConfigError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"{file} does not hold the model that its header describes: {error}") from error
    return Checkpoint(config, scene, category, step, model.eval(), _under("optimiser.", tensors), run)


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def optimiser_tensors(optimiser: torch.optim.Adam, model: Model) -> dict[str, Tensor]:
    """Adam's state, named by parameter."""
    named = {}
    for name, parameter in model.named_parameters():
        for key, value in optimiser.state.get(parameter, {}).items():
            named[f"{key}.{name}"] = value
    return named


def restore_optimiser(optimiser: torch.optim.Adam, model: Model, tensors: dict[str, Tensor]) -> None:
    """The inverse of `optimiser_tensors`."""
    for name, parameter in model.named_parameters():
        state = {key.removesuffix(f".{name}"): value for key, value in tensors.items() if key.endswith(f".{name}")}
        optimiser.state[parameter] = {key: value for key, value in state.items() if "." not in key}
