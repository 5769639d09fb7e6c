"""The antialiased picture of N meshes: decisions on fixed numbers first, then a differentiable function of geometry."""

import math
from typing import Any, NamedTuple

import torch
from jaxtyping import Float, Int32
from torch import Tensor
from torch.autograd.function import once_differentiable

from trainer.rendering.triton_kernels.boundaries import add_boundaries, boundaries_gradient
from trainer.rendering.triton_kernels.crossings import Crossings, crossings, no_crossings
from trainer.rendering.triton_kernels.cuts import Cuts, cuts_of
from trainer.rendering.triton_kernels.geometry import Geometry, Records, lines_and_planes, records_of
from trainer.rendering.triton_kernels.interior import interior, interior_gradient
from trainer.rendering.triton_kernels.mesh import Mesh
from trainer.rendering.triton_kernels.nearest import visible_faces
from trainer.rendering.triton_kernels.pieces import Pieces, pieces_of
from trainer.rendering.triton_kernels.segments import Segments, segments_of


class Borders(NamedTuple):
    """Where what is seen changes abruptly within a pixel."""

    crossings: Crossings
    segments: Segments
    cuts: Cuts
    pieces: Pieces


class View(NamedTuple):
    """What is seen where: all that is decided, none of it differentiable."""

    records: Records
    visible: Int32[Tensor, "N H W"]
    borders: Borders | None
    """None where nothing is antialiased."""


def pictures_of(
    screen: Float[Tensor, "N V 3"],
    colours: Float[Tensor, "N V C"],
    mesh: Mesh,
    width: int,
    height: int,
    crease: float,
) -> Float[Tensor, "N C H W"]:
    """Pictures in float32, on black, of at least one mesh with at least one face; all must be finite."""
    geometry = lines_and_planes(screen, colours, mesh)
    view = _view(Geometry(*(part.detach() for part in geometry)), mesh, width, height, crease)
    lines = geometry.lines.flatten(0, 1)
    if view.borders is not None:
        met = view.borders.crossings
        one, two = (geometry.planes[met.mesh, met.faces[:, which], 0] for which in range(2))
        lines = torch.cat((lines, one - two))
    pictures: Tensor = _Paint.apply(geometry.screen, lines, geometry.planes, view)
    return pictures


def _view(geometry: Geometry, mesh: Mesh, width: int, height: int, crease: float) -> View:
    records = records_of(geometry, mesh)
    visible = visible_faces(records, width, height)
    if crease < 0:
        return View(records, visible, None)
    crossed = crossings(geometry, records, mesh) if crease < math.inf else no_crossings(geometry)
    segments = segments_of(geometry, records, crossed, mesh, crease)
    cuts = cuts_of(segments, width, height)
    pieces = pieces_of(records, segments, cuts, geometry.lines[..., 0].numel(), width, height)
    return View(records, visible, Borders(crossed, segments, cuts, pieces))


class _Paint(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, screen: Tensor, lines: Tensor, planes: Tensor, view: View) -> Tensor:
        ctx.save_for_backward(screen, lines, planes)
        ctx.view = view
        # Summed in float64, so that neither cancellation nor the order of the pieces shows in float32.
        picture = interior(planes, view.visible)
        if view.borders is not None:
            _, segments, cuts, pieces = view.borders
            add_boundaries(screen, lines, planes, view.records, segments, cuts, pieces, picture)
        return picture.float()

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor | None, Tensor | None, Tensor, None]:
        screen, lines, planes = ctx.saved_tensors
        view, upstream = ctx.view, upstream.contiguous()
        to_planes = interior_gradient(planes, view.records, view.visible, upstream)
        if view.borders is None:
            return None, None, to_planes, None
        _, segments, cuts, pieces = view.borders
        to_screen, to_lines = boundaries_gradient(
            screen, lines, planes, view.records, segments, cuts, pieces, upstream, to_planes
        )
        return to_screen, to_lines, to_planes, None
