"""Ways through the space of shape codes, from one object to another (section 5.4 of the paper)."""

import torch
from jaxtyping import Float
from torch import Tensor


def shape_codes_between(
    first: Float[Tensor, "Z"], last: Float[Tensor, "Z"], shares: Float[Tensor, "T"]
) -> Float[Tensor, "T Z"]:
    """The codes that have gone a share of the straight way from `first` (0, exactly) to `last` (1, exactly)."""
    return torch.lerp(first, last, shares[:, None])


def there_and_back(count: int) -> Float[Tensor, "T"]:
    """Shares of a way that rise evenly from 0 to 1 and fall again; the next one would be the first. `count` is even."""
    return 1 - torch.linspace(-1, 1, count + 1)[:-1].abs()
