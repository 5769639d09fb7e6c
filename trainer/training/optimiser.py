"""Adam as Appendix B sets it, and how its learning rates may depart from there."""

import torch
from torch import nn

from trainer.config import OptimiserConfig
from trainer.training.schedule import falling


def adam(model: nn.Module, config: OptimiserConfig) -> torch.optim.Adam:
    """Adam over all parameters; a model's decoder, with the lattice inside of its shapes, and in it the layer that
    decodes rotations, have learning rates of their own."""
    decoder_rate = config.decoder_factor * config.learning_rate
    rates = {
        "decoder.angles.": config.rotation_learning_rate,
        "decoder.": decoder_rate,
        "lattice.": decoder_rate,
        "": config.learning_rate,
    }
    groups: dict[str, list[nn.Parameter]] = {}
    for name, parameter in model.named_parameters():
        prefix = next(prefix for prefix in rates if name.startswith(prefix))
        groups.setdefault(prefix, []).append(parameter)
    return torch.optim.Adam(
        [{"params": groups[prefix], "lr": rates[prefix], "full_rate": rates[prefix]} for prefix in groups],
        # On a GPU one kernel for all parameters; on a CPU torch's usual choice.
        fused=True if next(model.parameters()).is_cuda else None,
    )


def at_step(optimiser: torch.optim.Adam, config: OptimiserConfig, step: int) -> torch.optim.Adam:
    """The same optimiser with the learning rates of a step, counted from 0."""
    for group in optimiser.param_groups:
        group["lr"] = group["full_rate"] * falling(config, step)
    return optimiser
