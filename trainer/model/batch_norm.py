"""Batch normalisation over the batch of all processes that train together.

torch has such a layer for GPUs only.
"""

from typing import Any

import torch
from torch import Tensor, autograd, nn
from torch.nn import functional
from torch.nn.modules.batchnorm import _BatchNorm

from trainer import processes


def synchronise(module: nn.Module) -> None:
    """Puts a `SynchronisedBatchNorm` with the same parameters and running means in the place of each layer within."""
    for name, child in module.named_children():
        if isinstance(child, nn.BatchNorm1d | nn.BatchNorm2d):
            setattr(module, name, SynchronisedBatchNorm(child))
        else:
            synchronise(child)


class SynchronisedBatchNorm(_BatchNorm):
    """As the layer that it replaces, but mean and variance are those of all processes' pictures together."""

    def __init__(self, replaced: nn.BatchNorm1d | nn.BatchNorm2d) -> None:
        super().__init__(replaced.num_features, replaced.eps, replaced.momentum)
        self._parameters.update(replaced._parameters)
        self._buffers.update(replaced._buffers)

    def _check_input_dim(self, input: Tensor) -> None:
        """Maps and vectors alike."""

    def forward(self, input: Tensor) -> Tensor:
        normalised: Tensor
        if not self.training:
            normalised = super().forward(input)
            return normalised
        normalised, mean, variance = _Normalised.apply(input, self.weight, self.bias, self.eps)  # type: ignore[no-untyped-call]
        assert self.running_mean is not None
        assert self.running_var is not None
        assert self.num_batches_tracked is not None
        assert self.momentum is not None
        with torch.no_grad():
            size = processes.count() * input.numel() // self.num_features
            self.running_mean.lerp_(mean, self.momentum)
            self.running_var.lerp_(variance * (size / (size - 1)), self.momentum)
            self.num_batches_tracked.add_(1)
        return normalised


class _Normalised(autograd.Function):
    """Forward and backward in one message each."""

    @staticmethod
    def forward(context: Any, values: Tensor, weight: Tensor, bias: Tensor, epsilon: float) -> tuple[Tensor, ...]:
        precise = values.to(torch.promote_types(values.dtype, torch.float32))
        others = [axis for axis in range(values.ndim) if axis != 1]
        # Many times as fast as torch.var_mean is over pictures whose colours are side by side.
        own_mean = precise.mean(others, keepdim=True)
        own_variance, own_mean = (precise - own_mean).square_().mean(others), own_mean.flatten()
        mean, square, within = processes.mean(torch.stack([own_mean, own_mean.square(), own_variance]))
        variance = within + (square - mean.square()).clamp_min(0)
        context.save_for_backward(values, weight, mean, variance)
        context.epsilon = epsilon
        context.mark_non_differentiable(mean, variance)
        return functional.batch_norm(values, mean, variance, weight, bias, eps=epsilon), mean, variance

    @staticmethod
    def backward(context: Any, *gradients: Tensor | None) -> tuple[Tensor | None, ...]:
        """As if mean and variance were given, and then what they add: with x̂ the normalised values and w / σ the scale,
        - (w / σ) (⟨g⟩ + x̂ ⟨g x̂⟩), where ⟨⟩ are means over all processes' values."""
        values, weight, mean, variance = context.saved_tensors
        assert gradients[0] is not None
        to_values, to_weight, to_bias = torch.ops.aten.native_batch_norm_backward(
            gradients[0], values, weight, mean, variance, None, None, False, context.epsilon, [True, True, True]
        )
        size = values.numel() // values.shape[1]
        of_bias, of_weight = processes.mean(torch.stack([to_bias, to_weight])) / size
        inverse = (variance + context.epsilon).rsqrt()
        slope = -weight * inverse.square() * of_weight
        shift = -weight * inverse * of_bias - slope * mean
        along = [1, -1, *[1] * (values.ndim - 2)]
        to_values += (values * slope.view(along) + shift.view(along)).to(to_values.dtype)
        return to_values, to_weight, to_bias, None
