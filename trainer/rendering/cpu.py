"""The fused numba kernels of `rasteriser` as differentiable torch functions."""

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from jaxtyping import Float, Int64
from torch import Tensor
from torch.autograd.function import once_differentiable

from rasteriser import likelihood, pictures
from rasteriser.pictures import CREASE
from rasteriser.topology import Topology, build_topology

# A hypothesis whose share of the largest gradient is below this gets none: its picture is not drawn again.
NEGLIGIBLE_WEIGHT = 1e-4
# A hypothesis with a smaller posterior probability than this is left out of an expectation.
NEGLIGIBLE_RESPONSIBILITY = 1e-3


def topology_of(faces: Int64[Tensor, "F 3"]) -> Topology:
    """Edges and adjacency of a mesh, computed once for a training."""
    return build_topology(faces.detach().cpu().numpy())


def _owned(array: npt.NDArray[np.float32]) -> Tensor:
    """A tensor in torch's own, aligned memory: elsewhere, matrix products may round differently from run to run."""
    return torch.from_numpy(array).clone()


class _LogLikelihood(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, screen: Tensor, colours: Tensor, pictures: Tensor, topology: Topology, crease: float, binarise: float
    ) -> Tensor:
        ctx.save_for_backward(screen, colours, pictures)
        ctx.topology, ctx.options = topology, (crease, binarise)
        values = likelihood.log_likelihood(
            *_flat(screen, colours), topology, pictures.detach().numpy(), crease, binarise
        )
        return torch.as_tensor(values.reshape(_hypotheses(colours)), dtype=screen.dtype)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, Tensor, None, None, None, None]:
        screen, colours, pictures = ctx.saved_tensors
        scales = upstream.double().flatten(0, 1).numpy().copy()
        scales[np.abs(scales) < NEGLIGIBLE_WEIGHT * np.abs(scales).max(initial=0.0)] = 0.0
        _, gradients = likelihood.log_likelihood_gradient(
            *_flat(screen, colours), ctx.topology, pictures.numpy(), scales, *ctx.options
        )
        to_screen = _owned(gradients.screen).reshape(screen.shape)
        return to_screen, _owned(gradients.colours).reshape(colours.shape), None, None, None, None


class _ExpectedLogLikelihood(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        screen: Tensor,
        colours: Tensor,
        pictures: Tensor,
        weights: Tensor,
        topology: Topology,
        crease: float,
        binarise: float,
    ) -> Tensor:
        scales = weights.detach().double().flatten(0, 1).numpy()
        scales = np.where(scales < NEGLIGIBLE_RESPONSIBILITY, 0.0, scales)
        values, gradients = likelihood.log_likelihood_gradient(
            *_flat(screen, colours), topology, pictures.detach().numpy(), scales, crease, binarise
        )
        ctx.save_for_backward(
            _owned(gradients.screen).reshape(screen.shape),
            _owned(gradients.colours).reshape(colours.shape),
        )
        return torch.as_tensor((values * scales).reshape(len(screen), -1).sum(1), dtype=screen.dtype)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, Tensor, None, None, None, None, None]:
        to_screen, to_colours = (part * upstream.reshape(-1, *(1,) * (part.ndim - 1)) for part in ctx.saved_tensors)
        return to_screen, to_colours, None, None, None, None, None


class _Draw(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, screen: Tensor, colours: Tensor, topology: Topology, width: int, height: int, crease: float
    ) -> Tensor:
        ctx.save_for_backward(screen, colours)
        ctx.topology, ctx.crease = topology, crease
        return torch.from_numpy(
            pictures.draw(screen.detach().numpy(), colours.detach().numpy(), topology, width, height, crease)
        )

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, Tensor, None, None, None, None]:
        screen, colours = ctx.saved_tensors
        gradients = pictures.draw_gradient(screen.numpy(), colours.numpy(), ctx.topology, upstream.numpy(), ctx.crease)
        return _owned(gradients.screen), _owned(gradients.colours), None, None, None, None


def log_likelihood(
    screen: Float[Tensor, "B R V 3"],
    colours: Float[Tensor, "B R V *L C"],
    pictures: Float[Tensor, "B C H W"],
    topology: Topology,
    crease: float = CREASE,
    binarise: float = 0.0,
) -> Float[Tensor, "B R *L"]:
    """log P(x | z, θ) of each picture under each of its R hypotheses (Eqs. 1 to 4, ε = 1, constants left out), or under
    each of them in each of L lights, where `colours` has an axis for these.

    Differentiable in `screen` (x, y, inverse depth) and `colours`. The backward pass draws again only those hypotheses
    whose incoming gradient is not negligible (below 1e-4 of the largest). Options are those of
    `rasteriser.likelihood.log_likelihood`.
    """
    values: Tensor = _LogLikelihood.apply(screen, colours, pictures, topology, crease, binarise)
    return values


def expected_log_likelihood(
    screen: Float[Tensor, "B R V 3"],
    colours: Float[Tensor, "B R V *L C"],
    pictures: Float[Tensor, "B C H W"],
    weights: Float[Tensor, "B R *L"],
    topology: Topology,
    crease: float = CREASE,
    binarise: float = 0.0,
) -> Float[Tensor, "B"]:
    """Σ_r w_r log P(x | z, r) for weights that are known beforehand and take no gradient.

    Each hypothesis is drawn once, for value and gradient together, and those with a weight below one in a thousand not
    at all: of the twelve poses of a picture, one to three matter.
    """
    values: Tensor = _ExpectedLogLikelihood.apply(screen, colours, pictures, weights, topology, crease, binarise)
    return values


def draw(
    screen: Float[Tensor, "N V 3"],
    colours: Float[Tensor, "N V C"],
    topology: Topology,
    width: int,
    height: int,
    crease: float = CREASE,
) -> Float[Tensor, "N C H W"]:
    """Antialiased pictures on black, differentiable in `screen` and `colours`."""
    pictures: Tensor = _Draw.apply(screen, colours, topology, width, height, crease)
    return pictures


def _flat(screen: Tensor, colours: Tensor) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    return screen.detach().flatten(0, 1).numpy(), colours.detach().flatten(0, 1).numpy()


def _hypotheses(colours: Tensor) -> tuple[int, ...]:
    """(B, R) or (B, R, L): the sizes of colours without those of vertices and channels."""
    return (*colours.shape[:2], *colours.shape[3:-1])
