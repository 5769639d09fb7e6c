"""One step of the optimiser, which changes either everything or nothing."""

import math
from collections.abc import Callable
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import torch
from jaxtyping import Float
from torch import Tensor, nn

from trainer.model.loss import LossWeights
from trainer.training.longer_look import Look


class Differentiable(Protocol):
    """What a forward pass gives."""

    def loss(self) -> Tensor:
        """A scalar, which is minimised."""


Result = TypeVar("Result", bound=Differentiable)


class Given(NamedTuple):
    """What changes from step to step."""

    pictures: Float[Tensor, "B 3 H W"]
    azimuths: Float[Tensor, "B"] | None
    """True ones, radians, where the step is told them."""
    weights: LossWeights | None
    """None where the loss has no terms to weigh."""
    generator: torch.Generator
    look: Look | None = None
    """What the encoder is taught of these pictures, where that is more than its own word."""


class Descent(NamedTuple, Generic[Result]):
    result: Result
    gradient_norm: float
    """Euclidean, over all parameters, before clipping."""


class Differentiation(Protocol[Result]):
    """Forward pass, backward pass, clipping: leaves the gradients with the parameters. None where a vertex or the
    gradient is not finite: the model is then as before, the running means of the batch normalisation included."""

    def __call__(self, given: Given) -> Descent[Result] | None: ...


class Unrecorded(Differentiation[Result]):
    """Each step by itself, on any device and in any number of processes."""

    def __init__(self, model: nn.Module, gradient_clip: float, forward: Callable[[Given], Result]) -> None:
        self.model, self.gradient_clip, self.forward = model, gradient_clip, forward

    def __call__(self, given: Given) -> Descent[Result] | None:
        before = [buffer.clone() for buffer in self.model.buffers()]
        self.model.zero_grad()
        try:
            result, norm = differentiate(self.model, self.gradient_clip, self.forward, given)
            gradient_norm = float(norm)
        except FloatingPointError:
            gradient_norm = math.nan
        if math.isfinite(gradient_norm):
            return Descent(result, gradient_norm)
        put_back(self.model, before)
        return None


def differentiate(
    model: nn.Module, gradient_clip: float, forward: Callable[[Given], Result], given: Given
) -> tuple[Result, Float[Tensor, ""]]:
    """What the forward pass gives, and the gradient's norm before clipping."""
    result = forward(given)
    result.loss().backward()
    return without_graph(result), torch.nn.utils.clip_grad_norm_(model.parameters(), gradient_clip)


def without_graph(value: Any) -> Any:
    """The same tensors, in the same named tuples, without what led to them. Where that stays, so do the nodes that
    accumulate the parameters' gradients, on the stream of that step, and whatever differentiates next on another stream
    has to wait for it."""
    if isinstance(value, Tensor):
        return value.detach()
    return type(value)(*map(without_graph, value)) if isinstance(value, tuple) else value


def put_back(model: nn.Module, buffers: list[Tensor]) -> None:
    with torch.no_grad():
        for buffer, value in zip(model.buffers(), buffers, strict=True):
            buffer.copy_(value)


def descend(
    optimiser: torch.optim.Optimizer, differentiation: Differentiation[Result], given: Given
) -> Descent[Result] | None:
    """A step, or none: then model and optimiser are as before."""
    taken = differentiation(given)
    if taken is not None:
        optimiser.step()
    return taken
