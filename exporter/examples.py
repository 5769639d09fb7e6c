"""Inputs for parity and probe: random, but of the kind that the graphs will see."""

import torch
from jaxtyping import Float
from torch import Tensor


def random_pictures(
    batch: int, height: int, width: int, generator: torch.Generator
) -> Float[Tensor, "{batch} 3 {height} {width}"]:
    """Bright discs of random place and size with a gradient over them, on black, in 8-bit steps."""
    rows = torch.linspace(-1, 1, height)[None, :, None]
    columns = torch.linspace(-1, 1, width)[None, None, :]
    centre_y, centre_x, radius, slope = (torch.rand(4, batch, 1, 1, generator=generator) * 2 - 1).unbind(0)
    inside = (rows - centre_y / 2) ** 2 + (columns - centre_x / 2) ** 2 < (0.5 + radius / 4) ** 2
    shade = (0.5 + slope * columns / 2)[:, None] * torch.rand(batch, 3, 1, 1, generator=generator)
    noise = 0.1 * torch.rand(batch, 3, height, width, generator=generator)
    return ((shade + noise).clamp(0, 1) * inside[:, None] * 255).round() / 255


def random_shape_codes(batch: int, latent: int, generator: torch.Generator) -> Float[Tensor, "{batch} {latent}"]:
    """Shape codes from the prior."""
    return torch.randn(batch, latent, generator=generator)
