"""One step of the optimiser, which changes either everything or nothing."""

import math
from collections.abc import Callable
from typing import Generic, NamedTuple, Protocol, TypeVar

import torch
from torch import Tensor, nn


class Differentiable(Protocol):
    """What a forward pass gives."""

    def loss(self) -> Tensor:
        """A scalar, which is minimised."""


Result = TypeVar("Result", bound=Differentiable)


class Descent(NamedTuple, Generic[Result]):
    result: Result
    gradient_norm: float
    """Euclidean, over all parameters, before clipping."""


def descend(
    model: nn.Module, optimiser: torch.optim.Optimizer, gradient_clip: float, forward: Callable[[], Result]
) -> Descent[Result] | None:
    """Forward, backward, clip, step. None where a vertex or the gradient is not finite: model and optimiser are then as
    before, the running means of the batch normalisation included."""
    before = [buffer.clone() for buffer in model.buffers()]
    optimiser.zero_grad()
    try:
        result = forward()
        result.loss().backward()
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
