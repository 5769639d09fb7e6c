"""What cannot be drawn is named before it is drawn."""

import torch
from torch import Tensor


def check_finite(screen: Tensor, colours: Tensor) -> None:
    """Raises FloatingPointError, naming the first bad mesh, where a model has decoded what cannot be drawn.

    `screen` is [N, V, 3] or [B, R, V, 3], counted picture by picture; `colours` have the same first axes.
    """
    vertex = screen.ndim - 2
    bad = ~(screen.isfinite().flatten(vertex).all(-1) & colours.isfinite().flatten(vertex).all(-1)).flatten()
    first = int(torch.where(bad, torch.arange(len(bad), device=bad.device), len(bad)).amin()) if len(bad) else 0
    if first < len(bad):
        raise FloatingPointError(f"expected finite vertices and colours, found NaN or infinity first in mesh {first}")
