"""Batch normalisation over the batch of all processes that train together.

torch has such a layer for GPUs only.
"""

import torch
from torch import Tensor, nn
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
        if not self.training:
            normalised: Tensor = super().forward(input)
            return normalised
        values = input.to(torch.promote_types(input.dtype, torch.float32))
        others = [axis for axis in range(values.ndim) if axis != 1]
        along = [1, -1, *[1] * (values.ndim - 2)]
        mean = processes.mean(values.mean(others))
        centred = values - mean.view(along)
        variance = processes.mean(centred.square().mean(others))
        self._keep(mean.detach(), variance.detach(), processes.count() * values.numel() // self.num_features)
        scale = self.weight * (variance + self.eps).rsqrt()
        return (centred * scale.view(along) + self.bias.view(along)).to(input.dtype)

    @torch.no_grad()
    def _keep(self, mean: Tensor, variance: Tensor, size: int) -> None:
        """The running statistics; `size` values were averaged."""
        assert self.running_mean is not None
        assert self.running_var is not None
        assert self.num_batches_tracked is not None
        assert self.momentum is not None
        self.running_mean.lerp_(mean, self.momentum)
        self.running_var.lerp_(variance * (size / (size - 1)), self.momentum)
        self.num_batches_tracked.add_(1)
