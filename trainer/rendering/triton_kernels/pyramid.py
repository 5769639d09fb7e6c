"""The log-likelihood of pictures by the pyramid of their residuals."""

from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor


def residual_log_likelihood(residual: Float[Tensor, "N C H W"]) -> Float[Tensor, "N"]:
    """Eqs. 1, 2 and 4 with ε = 1 and without constants, in float64: -1/2 Σ_l 4^l |K_l r|² for residuals r = I_0 - x.

    Differentiable. A level is halved by two small matrix products, which are their own adjoint.
    """
    level, weight = residual, 1.0
    total = level.new_zeros(len(level), dtype=torch.float64)
    while True:
        total = total - 0.5 * weight * level.square().sum((1, 2, 3), dtype=torch.float64)
        height, width = level.shape[2:]
        if min(height, width) == 1:
            return total
        level = _halving(height, level.device, level.dtype) @ level @ _halving(width, level.device, level.dtype).T
        weight *= 4.0


@lru_cache(maxsize=64)
def _halving(size: int, device: torch.device, dtype: torch.dtype) -> Float[Tensor, "M size"]:
    """Convolution with [1 4 6 4 1]/16 at every second place, border by reflection."""
    period = max(2 * (size - 1), 1)
    matrix = torch.zeros((size + 1) // 2, size, dtype=torch.float64)
    for row in range(len(matrix)):
        for offset, weight in zip(range(-2, 3), (1, 4, 6, 4, 1), strict=True):
            wrapped = (2 * row + offset) % period
            matrix[row, min(wrapped, period - wrapped) % size] += weight / 16
    return matrix.to(device, dtype)
