"""How large a candidate is: what is to be learnt, and what its bundle would weigh."""

from typing import NamedTuple

import torch
from torch import Tensor

from trainer.config import TrainConfig
from trainer.model.vae import Model

# As the bundles that ship have it: a face stands in graph, manifest and probe.
_BYTES_PER_WEIGHT, _BYTES_PER_FACE, _OTHER_BYTES = 4, 150, 20_000


class Size(NamedTuple):
    parameters: int
    """Numbers that are learnt, in encoder and decoder."""
    shape_parameters: int
    """Those of the decoder alone."""
    vertices: int
    """Of each shape."""
    bundle_bytes: int
    """An estimate of the exported bundle's size."""


def size_of(config: TrainConfig) -> Size:
    """The size of a model of this setting; its weights are made and thrown away."""
    with torch.random.fork_rng(devices=[]):
        model = Model(config.model, config.width, config.height)
    learnt, shape = (sum(weight.numel() for weight in part.parameters()) for part in (model, model.decoder))
    # Of layers that are tied to their mirror image a graph holds both halves.
    layers = [getattr(module, name, None) for module in model.modules() for name in ("weight", "bias")]
    stored = sum(layer.numel() for layer in layers if isinstance(layer, Tensor))
    bundle = _BYTES_PER_WEIGHT * stored + _BYTES_PER_FACE * len(model.faces) + _OTHER_BYTES
    return Size(learnt, shape, len(model.decoder.base_vertices), bundle)
