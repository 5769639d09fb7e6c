"""The renderer on a GPU: the same differentiable functions as `cpu`, over Triton kernels.

All tensors of a call lie on one device, and everything stays there. Of each drawing some numbers come back to the host:
whether all is finite; how many hypotheses matter, how many faces interpenetrate and how many places cut a line, to
allocate no more than that. A step that is recorded (`trainer.recording`) allocates what was agreed instead. Where
`TRITON_INTERPRET=1` was set before triton's first import, its interpreter runs the kernels on the CPU.
"""

from typing import Any

import torch
import triton
from jaxtyping import Float, Int64
from torch import Tensor
from torch.autograd.function import once_differentiable

from rasteriser.pictures import CREASE
from rasteriser.topology import Topology
from trainer import recording
from trainer.rendering.cpu import NEGLIGIBLE_RESPONSIBILITY, NEGLIGIBLE_WEIGHT
from trainer.rendering.reference import binarised
from trainer.rendering.triton_kernels.mesh import Mesh, mesh_on
from trainer.rendering.triton_kernels.picture import pictures_of
from trainer.rendering.triton_kernels.pyramid import residual_log_likelihood

Options = tuple[float, float]  # crease, binarise


def draw(
    screen: Float[Tensor, "N V 3"],
    colours: Float[Tensor, "N V C"],
    topology: Topology,
    width: int,
    height: int,
    crease: float = CREASE,
) -> Float[Tensor, "N C H W"]:
    """Antialiased pictures on black, differentiable in `screen` (x, y, inverse depth) and `colours`.

    Raises:
        FloatingPointError: vertices or colours are not finite; the message names the first bad mesh.
        ValueError: shapes or faces that do not fit, or tensors that are not on a GPU.
    """
    _check(screen, colours, topology, 3)
    pictures = _draw(screen, colours, mesh_on(topology, screen.device), width, height, crease)
    return pictures.to(screen.dtype)


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
    whose incoming gradient is not negligible (below 1e-4 of the largest). Raises as `draw` does, where hypothesis r of
    picture b counts as mesh b · R + r. Where `binarise` is positive, it is the η of the silhouette loss (section 5.3):
    pixels p of both pictures become p / (p + η) first.
    """
    _check(screen, colours, topology, 4)
    values: Tensor = _LogLikelihood.apply(
        screen, colours, pictures, mesh_on(topology, screen.device), (crease, binarise)
    )
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
    at all: of the twelve poses of a picture, one to three matter. Options and errors are those of `log_likelihood`.
    """
    _check(screen, colours, topology, 4)
    mesh = mesh_on(topology, screen.device)
    values: Tensor = _ExpectedLogLikelihood.apply(screen, colours, pictures, weights, mesh, (crease, binarise))
    return values


class _LogLikelihood(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, screen: Tensor, colours: Tensor, pictures: Tensor, mesh: Mesh, options: Options) -> Tensor:
        ctx.save_for_backward(screen, colours, pictures)
        ctx.mesh, ctx.options = mesh, options
        everything = torch.arange(screen[..., 0, 0].numel(), device=screen.device)
        values = _values(*_hypotheses(screen, colours, pictures, everything), mesh, *options)
        values = values.to(screen.dtype)
        return values.reshape(*screen.shape[:2], *values.shape[1:])

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, Tensor, None, None, None]:
        screen, colours, pictures = ctx.saved_tensors
        largest = torch.cat((upstream.new_zeros(1), upstream.abs().flatten())).amax()
        wanted = torch.where(upstream.abs() < NEGLIGIBLE_WEIGHT * largest, 0.0, upstream)
        _, to_screen, to_colours = _weighed_values(screen, colours, pictures, wanted, ctx.mesh, ctx.options)
        return to_screen, to_colours, None, None, None


class _ExpectedLogLikelihood(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, screen: Tensor, colours: Tensor, pictures: Tensor, weights: Tensor, mesh: Mesh, options: Options
    ) -> Tensor:
        wanted = torch.where(weights < NEGLIGIBLE_RESPONSIBILITY, 0.0, weights)
        values, *gradients = _weighed_values(screen, colours, pictures, wanted, mesh, options)
        ctx.save_for_backward(*gradients)
        return values.flatten(1).sum(1).to(screen.dtype)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, Tensor, None, None, None, None]:
        to_screen, to_colours = (part * upstream.reshape(-1, *(1,) * (part.ndim - 1)) for part in ctx.saved_tensors)
        return to_screen, to_colours, None, None, None, None


def _weighed_values(
    screen: Tensor, colours: Tensor, pictures: Tensor, weights: Tensor, mesh: Mesh, options: Options
) -> tuple[Float[Tensor, "B R *L"], Float[Tensor, "B R V 3"], Float[Tensor, "B R V *L C"]]:
    """w log p of each hypothesis and its gradients. What has no weight in any light is not drawn."""
    each = weights.flatten(0, 1)
    weighty = (each != 0).reshape(len(each), -1).any(1)
    wanted = weighty.logical_not().int().argsort(stable=True)[: recording.length(weighty.sum())]
    values = torch.zeros(each.shape, dtype=torch.float64, device=screen.device)
    to_screen, to_colours = torch.zeros_like(screen).flatten(0, 1), torch.zeros_like(colours).flatten(0, 1)
    if len(wanted):
        one, two, targets = _hypotheses(screen.detach(), colours.detach(), pictures, wanted)
        if recording.is_recorded():
            # There may be more room than they need. What follows then has no weight, and no area.
            one = torch.where(weighty[wanted, None, None], one, 0.0)
        with torch.enable_grad():
            drawn = one.requires_grad_(), two.requires_grad_()
            weighed = _values(*drawn, targets, mesh, *options) * each[wanted]
            to_screen[wanted], to_colours[wanted] = torch.autograd.grad(weighed.sum(), drawn)
        values[wanted] = weighed.detach()
    return values.reshape(weights.shape), to_screen.reshape(screen.shape), to_colours.reshape(colours.shape)


def _hypotheses(
    screen: Tensor, colours: Tensor, pictures: Tensor, which: Int64[Tensor, "N"]
) -> tuple[Float[Tensor, "N V 3"], Float[Tensor, "N V *L C"], Float[Tensor, "N C H W"]]:
    """Those of all hypotheses that are asked for, each with its picture."""
    return screen.flatten(0, 1)[which], colours.flatten(0, 1)[which], pictures[which // screen.shape[1]]


def _values(
    screen: Tensor, colours: Tensor, targets: Tensor, mesh: Mesh, crease: float, binarise: float
) -> Float[Tensor, "N *L"]:
    channels, height, width = targets.shape[1:]
    # Lights are so many more channels of one drawing.
    drawn = _draw(screen, colours.flatten(2), mesh, width, height, crease)
    if binarise > 0:
        drawn, targets = binarised(drawn, binarise), binarised(targets, binarise)
    residuals = drawn.unflatten(1, (-1, channels)) - targets[:, None]
    return residual_log_likelihood(residuals.flatten(0, 1)).reshape(len(screen), *colours.shape[2:-1])


def _draw(screen: Tensor, colours: Tensor, mesh: Mesh, width: int, height: int, crease: float) -> Tensor:
    if len(screen) == 0 or len(mesh.faces) == 0:
        # Black, and connected to what gets no gradient from it.
        nothing = 0.0 * (screen.sum() + colours.sum())
        return nothing.float().expand(len(screen), colours.shape[2], height, width)
    with torch.cuda.device_of(screen):
        return pictures_of(recording.harmless(screen), colours, mesh, width, height, crease)


def _check(screen: Tensor, colours: Tensor, topology: Topology, dimensions: int) -> None:
    if not (screen.is_cuda or triton.knobs.runtime.interpret):
        raise ValueError(
            f"expected tensors on a GPU, found them on {screen.device}; move them there or use the CPU renderer"
        )
    same = screen.ndim == dimensions and colours.shape[: screen.ndim - 1] == screen.shape[:-1]
    if not same or screen.shape[-1] != 3 or not 0 <= colours.ndim - screen.ndim <= dimensions - 3:
        form, found = "[N, V, ·]" if dimensions == 3 else "[B, R, V, ·]", f"{[*screen.shape]} and {[*colours.shape]}"
        raise ValueError(f"expected screen with 3 numbers and colours as {form} of the same sizes, found {found}")
    vertices = screen.shape[-2]
    if len(topology.faces) and not 0 <= topology.faces.min() <= topology.faces.max() < vertices:
        raise ValueError(f"expected faces that name vertices 0 to {vertices - 1}, found {topology.faces.max()}")
