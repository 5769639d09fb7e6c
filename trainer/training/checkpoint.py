"""A checkpoint: one safetensors file with weights and optimiser state, and everything else as JSON in its header.

Its name always holds a whole checkpoint (`data.writing`).
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from trainer.config import SceneConfig, TrainConfig
from trainer.data.writing import write_bytes
from trainer.errors import CheckpointError, ConfigError
from trainer.mapping import from_mapping, to_mapping
from trainer.model.vae import Model, model_of
from trainer.training.checks import check_settings
from trainer.training.neighbours import Memory

FORMAT_VERSION = 1
FILE_NAME = "checkpoint.safetensors"
ADAM_STATES = ("step", "exp_avg", "exp_avg_sq")


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
    """Summary of the run so far: seconds, pictures, the kind of device."""
    memory: Memory | None = None
    """Where neighbours are looked for, if the loss asks them."""

    @property
    def reframing_steps(self) -> int:
        """Steps taken after those, by the encoder alone (`training.reframing`)."""
        return int(self.run.get("reframing_steps", 0))

    @property
    def reframed(self) -> bool:
        """Whether objects were set by the rule in those steps: not where they had been cut out, and set, all along."""
        return self.reframing_steps > 0 and bool(self.run.get("framed", True))


def save_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Raises StorageError where the file cannot be written; an older checkpoint at `path` then stays."""
    tensors = {f"model.{name}": tensor.cpu().contiguous() for name, tensor in checkpoint.model.state_dict().items()}
    tensors |= {f"optimiser.{name}": tensor.contiguous() for name, tensor in checkpoint.optimiser_state.items()}
    if checkpoint.memory:
        kept = checkpoint.memory.state_dict()
        tensors |= {f"memory.{name}": tensor.cpu().contiguous() for name, tensor in kept.items()}
    header = {
        "format_version": FORMAT_VERSION,
        "config": to_mapping(checkpoint.config),
        "scene": to_mapping(checkpoint.scene),
        "category": checkpoint.category,
        "step": checkpoint.step,
        "run": checkpoint.run,
    }
    write_bytes(
        path,
        save(tensors, metadata={"chiaro": json.dumps(header)}),
        "A checkpoint that was there before is untouched: make room, then continue from it with --resume.",
        durable=True,
    )


def load_checkpoint(path: Path) -> Checkpoint:
    """A checkpoint from its file or from its run directory; the model is in evaluation mode.

    Raises:
        CheckpointError: no such file, not a checkpoint, another format version, or tensors that do not fit the model.
    """
    file = path / FILE_NAME if path.is_dir() else path
    if not file.is_file():
        raise CheckpointError(
            f"Expected a checkpoint at {file}, found nothing. Name a run directory that `trainer train` has written, "
            f"or its {FILE_NAME}."
        )
    try:
        with safe_open(file, framework="pt") as opened:
            header = json.loads((opened.metadata() or {}).get("chiaro", "null"))
            tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118
    except (SafetensorError, OSError, ValueError) as error:
        raise CheckpointError(
            f"{file}: expected a checkpoint of chiaro, found a file that is none or is cut short ({error}). "
            "Train again, or use a copy."
        ) from error
    if not isinstance(header, dict) or "format_version" not in header:
        raise CheckpointError(
            f"{file}: expected a checkpoint of chiaro, found tensors without its header. Name a file that chiaro has "
            "written."
        )
    if header["format_version"] != FORMAT_VERSION:
        raise CheckpointError(
            f"{file}: expected format version {FORMAT_VERSION}, found {header['format_version']!r}. "
            "Use the chiaro that wrote it, or train again."
        )
    try:
        config = from_mapping(TrainConfig, header["config"], f"{file}, config")
        scene = from_mapping(SceneConfig, header["scene"], f"{file}, scene")
        category, step, run = str(header["category"]), int(header["step"]), dict(header["run"])
        run["seconds"] = float(run["seconds"])
        check_settings(config)
        model = model_of(config)
        model.load_state_dict(_under("model.", tensors))
        optimiser_state = _under("optimiser.", tensors)
        _check_optimiser(optimiser_state, model)
        memory, kept = None, _under("memory.", tensors)
        if kept:
            memory = Memory(config.model.latent)
            memory.load_state_dict(kept)
    except (ConfigError, KeyError, TypeError, ValueError, RuntimeError) as error:
        raise CheckpointError(
            f"{file}: expected the model that its header describes, found something else ({error}). "
            "The file was altered: use a copy, or train again."
        ) from error
    return Checkpoint(config, scene, category, step, model.eval(), optimiser_state, run, memory)


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def _check_optimiser(tensors: dict[str, Tensor], model: Model) -> None:
    """Raises ValueError for a tensor that belongs to no parameter or has another size than it, and for one that is
    absent."""
    shapes = {name: parameter.shape for name, parameter in model.named_parameters()}
    for key, tensor in tensors.items():
        state, _, name = key.partition(".")
        expected = torch.Size() if state == "step" else shapes.get(name)
        if name not in shapes or state not in ADAM_STATES or tensor.shape != expected:
            raise ValueError(f"optimiser.{key} of size {list(tensor.shape)}")
        for needed in ADAM_STATES:
            if f"{needed}.{name}" not in tensors:
                raise ValueError(f"no optimiser.{needed}.{name}")


def optimiser_tensors(optimiser: torch.optim.Adam, model: Model) -> dict[str, Tensor]:
    """Adam's state, named by parameter."""
    named = {}
    for name, parameter in model.named_parameters():
        for key, value in optimiser.state.get(parameter, {}).items():
            named[f"{key}.{name}"] = value.cpu()
    return named


def restore_optimiser(optimiser: torch.optim.Adam, model: Model, tensors: dict[str, Tensor]) -> None:
    """The inverse of `optimiser_tensors`."""
    parameters = dict(model.named_parameters())
    for key, tensor in tensors.items():
        state, _, name = key.partition(".")
        parameter = parameters[name]
        # In the parameter's own layout, so that a resumed training computes what an uninterrupted one does.
        own = tensor if state == "step" else torch.empty_like(parameter).copy_(tensor)
        if optimiser.defaults["fused"]:
            own = own.to(parameter.device)
        optimiser.state[parameter][state] = own
