"""Adam as Appendix B sets it."""

from typing import Any

import torch

from trainer.config import OptimiserConfig
from trainer.model.vae import Model


def adam(model: Model, config: OptimiserConfig) -> torch.optim.Adam:
    """Adam over all parameters; the layer that decodes rotations has a learning rate of its own."""
    rotations = [parameter for name, parameter in model.named_parameters() if name.startswith("decoder.angles.")]
    if not rotations:
        return torch.optim.Adam(model.parameters(), lr=config.learning_rate)
    others = [parameter for name, parameter in model.named_parameters() if not name.startswith("decoder.angles.")]
    groups: list[dict[str, Any]] = [{"params": others}, {"params": rotations, "lr": config.rotation_learning_rate}]
    return torch.optim.Adam(groups, lr=config.learning_rate)
