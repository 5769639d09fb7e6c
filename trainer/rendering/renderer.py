"""The one door to the renderer: three backends with the same mathematics, chosen by name or by where the tensors are.

`reference` is plain torch, slow, in any precision: the oracle. `cpu` are the fused numba kernels on all cores. `cuda`
are Triton kernels. All differentiate with respect to vertices, inverse depths, colours and the background.
"""

import importlib
from types import ModuleType
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from rasteriser.pictures import CREASE
from rasteriser.topology import Topology
from trainer.rendering import cpu, reference
from trainer.rendering.finite import check_finite

Backend = Literal["auto", "reference", "cpu", "cuda"]


def draw(
    screen: Float[Tensor, "N V 3"],
    colours: Float[Tensor, "N V C"],
    topology: Topology,
    width: int,
    height: int,
    background: Float[Tensor, "#N C #H #W"] | None = None,
    crease: float = CREASE,
    backend: Backend = "auto",
) -> Float[Tensor, "N C+1 H W"]:
    """Antialiased pictures of N meshes that share one topology, and their coverage as the last channel.

    `screen` holds x and y in pixels from the top left corner, and the inverse depth; `colours` are linear, and
    interpolated perspective-correctly. The background is black where none is given. Edges inside the surface are
    antialiased where the colour's change per pixel jumps by `crease` or more, and so are lines where faces
    interpenetrate: 0 is exact; if it is infinite, only contours are antialiased, which is several times as fast; if it
    is `rasteriser.pictures.HARD`, nothing is.

    Raises:
        FloatingPointError: vertices or colours that are not finite.
    """
    check_finite(screen, colours)
    # Coverage is the colour of a mesh that is white all over.
    painted = torch.cat((colours, torch.ones_like(colours[..., :1])), -1)
    match _resolved(backend, screen):
        case "reference":
            faces = torch.as_tensor(topology.faces).long()
            drawn = [
                reference.draw(one, paint, faces, width, height, crease)
                for one, paint in zip(screen, painted, strict=True)
            ]
            pictures = torch.stack(drawn) if drawn else screen.new_zeros((0, painted.shape[2], height, width))
        case "cpu":
            pictures = cpu.draw(screen, painted, topology, width, height, crease)
        case "cuda":
            pictures = _cuda().draw(screen, painted, topology, width, height, crease)
    if background is None:
        return pictures
    return torch.cat((pictures[:, :-1] + (1 - pictures[:, -1:]) * background, pictures[:, -1:]), 1)


def log_likelihood(
    screen: Float[Tensor, "B R V 3"],
    colours: Float[Tensor, "B R V *L C"],
    pictures: Float[Tensor, "B C H W"],
    topology: Topology,
    crease: float = CREASE,
    binarise: float = 0.0,
    backend: Backend = "auto",
) -> Float[Tensor, "B R *L"]:
    """log P(x | z, θ) of each picture under each of its R hypotheses (Eqs. 1 to 4, ε = 1, constants left out).

    Where `colours` has an axis for L lights, it is log P(x | z, θ, λ) for each of them: what is seen where is found
    once, and a finite `crease` is one for all lights. On black. Where `binarise` is positive, it is the
    η of the silhouette loss (section 5.3): pixels p of both pictures become p / (p + η) first. The fast backends draw
    again, for the gradient, only hypotheses whose incoming gradient is not negligible (below 1e-4 of the largest).

    Raises:
        FloatingPointError: vertices or colours that are not finite.
    """
    check_finite(screen, colours)
    match _resolved(backend, screen):
        case "reference":
            return _reference_log_likelihood(screen, colours, pictures, topology, crease, binarise)
        case "cpu":
            return cpu.log_likelihood(screen, colours, pictures, topology, crease, binarise)
        case "cuda":
            values: Tensor = _cuda().log_likelihood(screen, colours, pictures, topology, crease, binarise)
            return values


def expected_log_likelihood(
    screen: Float[Tensor, "B R V 3"],
    colours: Float[Tensor, "B R V *L C"],
    pictures: Float[Tensor, "B C H W"],
    weights: Float[Tensor, "B R *L"],
    topology: Topology,
    crease: float = CREASE,
    binarise: float = 0.0,
    backend: Backend = "auto",
) -> Float[Tensor, "B"]:
    """Σ_r w_r log P(x | z, r) for weights that are known beforehand and take no gradient; those below one in a thousand
    count as nothing. Everything else is as for `log_likelihood`."""
    check_finite(screen, colours)
    match _resolved(backend, screen):
        case "reference":
            kept = torch.where(weights < cpu.NEGLIGIBLE_RESPONSIBILITY, 0.0, weights)
            values = _reference_log_likelihood(screen, colours, pictures, topology, crease, binarise)
            return (values * kept).flatten(1).sum(1)
        case "cpu":
            return cpu.expected_log_likelihood(screen, colours, pictures, weights, topology, crease, binarise)
        case "cuda":
            expected: Tensor = _cuda().expected_log_likelihood(
                screen, colours, pictures, weights, topology, crease, binarise
            )
            return expected


def _cuda() -> ModuleType:
    """Imported when asked for: Triton comes with torch's CUDA build alone."""
    return importlib.import_module("trainer.rendering.cuda")


def _resolved(backend: Backend, tensor: Tensor) -> Literal["reference", "cpu", "cuda"]:
    if backend == "auto":
        return "cuda" if tensor.is_cuda else "cpu"
    return backend


def _reference_log_likelihood(
    screen: Tensor, colours: Tensor, pictures: Tensor, topology: Topology, crease: float, binarise: float
) -> Float[Tensor, "B R *L"]:
    faces = torch.as_tensor(topology.faces).long()
    channels, height, width = pictures.shape[1:]
    values = []
    for shapes, paints, picture in zip(screen, colours, pictures, strict=True):
        for one, paint in zip(shapes, paints.flatten(2) if paints.ndim == 4 else paints, strict=True):
            drawn = reference.draw(one, paint, faces, width, height, crease)
            values += [reference.log_likelihood(light, picture, binarise) for light in drawn.split(channels)]
    return torch.stack(values).reshape(*colours.shape[:2], *colours.shape[3:-1])
