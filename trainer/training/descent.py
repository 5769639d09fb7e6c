"""One step of the optimiser, which changes either everything or nothing."""

import math
from collections.abc import Callable
from typing import NamedTuple

import torch

from trainer.model.vae import Model
from trainer.training.step import StepResult


class Descent(NamedTuple):
    result: StepResult
    gradient_norm: float
    """Euclidean, over all parameters, before clipping."""


def descend(
    model: Model, optimiser: torch.optim.Optimizer, gradient_clip: float, forward: Callable[[], StepResult]
) -> Descent | None:
    """Forward, backward, clip, step. None where a vertex or the gradient is not finite: model and optimiser are then as
    before, the running means of the batch normalisation included."""
    before = [buffer.clone() for buffer in model.buffers()]
    optimiser.zero_grad()
    try:
        result = forward()
        result.terms.total().backward()
        norm = float(torch.nn.utils.clip_grad_norm_(model.parameters(), gradient_clip))
    except FloatingPointError:
        norm = math.nan
    if math.isfinite(norm):
        optimiser.step()
        return Descent(result, norm)
    with torch.no_grad():
        for buffer, value in zip(model.buffers(), before, strict=True):
            buffer.copy_(value)
    return None
