"""What carries nothing is left out before a model is exported: numbers of the shape code, and blocks.

What the service can be asked for must stay as it is: every reconstruction, and every shape code whose numbers lie
within `LARGEST_NUMBER`. So a number of the code goes only if no value of it moves any vertex, whatever the pictures say
about it, and a block only if none of many shapes, such as pictures and samples have them, makes use of it. Heads that a
setting does not use are never built (`trainer.model.posterior`), and so there are none to leave out.
"""

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, cast

import torch
from jaxtyping import Float, Float32, Int64
from numpy import ndarray
from torch import Tensor, nn

from service.exposure import LEAST_AREA, Surfaces, shown_area, surfaces_of
from service.generation import LARGEST_NUMBER
from service.manifest import Block
from service.thrift import Parsimony
from trainer.model.block_decoder import BlockDecoder
from trainer.model.decoder import Part
from trainer.model.posterior import shape_divergence
from trainer.model.vae import Model

SAMPLES: Final = 256
"""Shape codes at random that are looked at."""
LARGEST_CHANGE: Final = 1e-4
"""How far what is left out may move a vertex, diagonals."""


def slimmed(model: Model, pictures: Float32[ndarray, "N 3 H W"], generator: torch.Generator) -> tuple[Model, Parsimony]:
    """A copy of a model without what carries nothing, and what that is. There may be no pictures."""
    samples = torch.randn(SAMPLES, model.config.latent, generator=generator)
    with torch.inference_mode():
        codes, alive, divergence = samples, samples, None
        if len(pictures):
            posterior = model.encode(torch.from_numpy(pictures))
            codes = torch.cat([samples, posterior.shape_mean])
            alive = codes_alive(posterior.shape_mean, posterior.shape_deviation, samples)
            divergence = shape_divergence(posterior).mean(0)
        latent, change = moving_numbers(model.decode, codes, generator)
        parts = [Block(*part) for part in model.decoder.parts]
        blocks = blocks_in_use(model.decode(alive).numpy(), model.faces.numpy(), parts)
    slim = _with_blocks(_with_latent(model, latent), blocks)
    told = () if divergence is None else tuple(max(0.0, round(divergence[k].item(), 6)) for k in latent)
    names = [part.name for part in model.decoder.parts]
    removed = tuple(name for k, name in enumerate(names) if k not in blocks)
    return slim, Parsimony(model.config.latent, tuple(latent), told, removed, len(pictures), SAMPLES, change)


def codes_alive(
    mean: Float[Tensor, "N Z"], deviation: Float[Tensor, "N Z"], noise: Float[Tensor, "M Z"]
) -> Float[Tensor, "K Z"]:
    """Shape codes as the service has them: what N pictures are answered with, and M samples from around these, which is
    where it draws its own."""
    around = torch.arange(len(noise)) % len(mean)
    return torch.cat([mean, mean[around] + deviation[around] * noise])


def moving_numbers(
    decode: Callable[[Float[Tensor, "N Z"]], Float[Tensor, "N V 3"]],
    codes: Float[Tensor, "N Z"],
    generator: torch.Generator,
) -> tuple[list[int], float]:
    """The numbers of the shape code that move vertices, and how far the others do together, diagonals.

    Each is set to both ends of what is accepted while the others are as in `codes`. One number stays in any case.
    """
    signs = torch.randint(0, 2, codes.shape, generator=generator) * 2.0 - 1

    def movement(numbers: list[int]) -> float:
        still = codes.clone()
        still[:, numbers] = 0
        base, farthest = decode(still), 0.0
        for ends in (signs, -signs):
            moved = still.clone()
            moved[:, numbers] = LARGEST_NUMBER * ends[:, numbers]
            farthest = max(farthest, float((decode(moved) - base).norm(dim=-1).max()))
        return farthest

    numbers = range(codes.shape[1])
    removed: list[int] = []
    change = 0.0
    for number in sorted(numbers, key=lambda number: movement([number]))[:-1]:
        together = movement([*removed, number])
        # Not >: what is not a number moves.
        if not together <= LARGEST_CHANGE:
            break
        removed, change = [*removed, number], together
    return [number for number in numbers if number not in removed], change


def blocks_in_use(
    vertices: Float32[ndarray, "N V 3"], faces: Int64[ndarray, "F 3"], blocks: Sequence[Block]
) -> list[int]:
    """The blocks that count as used (`service.exposure`) in any of N objects."""
    kept = list(range(len(blocks)))
    if len(blocks) == 1:
        return kept
    surfaces = [surfaces_of(one, faces, blocks) for one in vertices]
    for block in sorted(kept, key=lambda block: _most_shown(surfaces, block, kept)):
        if len(kept) > 1 and _most_shown(surfaces, block, kept) < LEAST_AREA:
            kept.remove(block)
    return kept


def _most_shown(surfaces: Sequence[Surfaces], block: int, beside: Sequence[int]) -> float:
    return max(shown_area(surface, block, beside) for surface in surfaces)


def _with_latent(model: Model, latent: Sequence[int]) -> Model:
    """A copy whose shape code holds some numbers only; the others are 0, the prior's mean."""
    slim = copy.deepcopy(model)
    slim.config = replace(model.config, latent=len(latent))
    slim.heads.shape_mean = _rows(slim.heads.shape_mean, latent)
    slim.heads.shape_deviation = _rows(slim.heads.shape_deviation, latent)
    first = cast(nn.Linear, slim.decoder.hidden[0])
    first.weight = nn.Parameter(first.weight[:, list(latent)].detach().clone())
    first.in_features = len(latent)
    return slim


def _with_blocks(model: Model, blocks: Sequence[int]) -> Model:
    """The same model with some of its blocks only. Rows that were tied (`trainer.model.mirror`) are written out."""
    decoder = model.decoder
    if not isinstance(decoder, BlockDecoder):
        decoder.displacements = _rows(decoder.displacements, range(decoder.displacements.out_features))
        return model
    rows = [3 * block + axis for block in blocks for axis in range(3)]
    decoder.offsets, decoder.scales = _rows(decoder.offsets, rows), _rows(decoder.scales, rows)
    decoder.angles = None if decoder.angles is None else _rows(decoder.angles, rows)
    per_block = len(decoder.corners)
    decoder.locations = decoder.locations[list(blocks)]
    decoder.base_vertices = decoder.base_vertices.unflatten(0, (-1, per_block))[list(blocks)].flatten(0, 1)
    # Every block has the same faces, from its own first vertex on.
    faces = decoder.parts[0].face_count
    decoder.faces = decoder.faces[: faces * len(blocks)]
    decoder.parts = tuple(Part(decoder.parts[block].name, k * faces, faces) for k, block in enumerate(blocks))
    return model


def _rows(layer: nn.Linear, rows: Sequence[int]) -> nn.Linear:
    """The layer that gives some of a layer's outputs."""
    part = nn.Linear(layer.in_features, len(rows))
    part.weight = nn.Parameter(layer.weight[list(rows)].detach().clone())
    part.bias = nn.Parameter(layer.bias[list(rows)].detach().clone())
    return part
