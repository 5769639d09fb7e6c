"""Fixed numbers in a device's memory."""

from functools import lru_cache

import torch
from torch import Tensor

Numbers = float | tuple["Numbers", ...]


def constant(numbers: Numbers, like: Tensor) -> Tensor:
    """A tensor of these numbers, of the type and on the device of `like`. It is sent there once, and not to be
    changed."""
    return _constant(numbers, like.dtype, like.device)


@lru_cache(maxsize=256)
def _constant(numbers: Numbers, dtype: torch.dtype, device: torch.device) -> Tensor:
    return torch.tensor(numbers, dtype=dtype, device=device)
