"""Lines and planes of meshes on the screen: small dense torch, differentiable, in float64."""

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int32
from torch import Tensor

from trainer.rendering.borders import SMALLEST_DOUBLED_AREA, THIN
from trainer.rendering.triton_kernels.mesh import Mesh


class Geometry(NamedTuple):
    """Differentiable numbers of N meshes. A line or plane (a, b, c) has the value a + b·x + c·y."""

    screen: Float[Tensor, "N V 3"]
    lines: Float[Tensor, "N E 3"]
    """Through both ends of each edge."""
    planes: Float[Tensor, "N F P 3"]
    """P = 1 + 2C: inverse depth; each channel times inverse depth; each channel by itself. Faces too thin to have a
    slope of colour have their mean colour."""


class Records(NamedTuple):
    """Fixed numbers from which kernels decide what is seen."""

    faces: Float[Tensor, "N F 18"]
    """Lines of three sides (9), plane of inverse depth (3), box (left, top, right, bottom), range of depth (2)."""
    sides: Int32[Tensor, "N F"]
    """Bit c: the face lies on the positive side of its side c."""
    drawn: Bool[Tensor, "N F"]
    """Whether a face has an area. The box of one that has not is empty."""


def lines_and_planes(screen: Float[Tensor, "N V 3"], colours: Float[Tensor, "N V C"], mesh: Mesh) -> Geometry:
    """The geometry of meshes in float64, differentiable in `screen` and `colours`."""
    screen, colours = screen.double().contiguous(), colours.double()
    (ax, ay), (bx, by) = (screen[:, mesh.edges[:, end], :2].unbind(-1) for end in range(2))
    lines = torch.stack((bx * ay - ax * by, by - ay, ax - bx), -1)

    corners = screen[:, mesh.faces]
    x, y, depth = corners.unbind(-1)
    doubled = _doubled_areas(x, y)
    sides = torch.hypot(x - x.roll(1, -1), y - y.roll(1, -1)).detach()
    thickness = doubled.abs() / sides.amax(-1).clamp(min=SMALLEST_DOUBLED_AREA**0.5)
    painted = colours[:, mesh.faces]
    painted = torch.where((thickness < THIN)[..., None, None], painted.mean(2, keepdim=True), painted)
    values = torch.cat((depth[..., None], depth[..., None] * painted, painted), -1)
    first, second = values[:, :, 1] - values[:, :, 0], values[:, :, 2] - values[:, :, 0]
    (ax, bx), (ay, by) = ((at[..., None, 1:] - at[..., None, :1]).unbind(-1) for at in (x, y))
    divisor = torch.where(doubled.abs() > SMALLEST_DOUBLED_AREA, doubled, 1.0)[..., None]
    slope_x, slope_y = (first * by - second * ay) / divisor, (second * ax - first * bx) / divisor
    origin = values[:, :, 0] - slope_x * x[..., :1] - slope_y * y[..., :1]
    return Geometry(screen, lines, torch.stack((origin, slope_x, slope_y), -1))


@torch.no_grad()
def records_of(geometry: Geometry, mesh: Mesh) -> Records:
    """What kernels decide from."""
    corners = geometry.screen[:, mesh.faces]
    x, y, depth = corners.unbind(-1)
    drawn = _doubled_areas(x, y).abs() > SMALLEST_DOUBLED_AREA
    lines = geometry.lines[:, mesh.face_edges]
    positive = side_of(lines, x, y).to(torch.int32)
    sides = positive[..., 0] + 2 * positive[..., 1] + 4 * positive[..., 2]
    low, high = (torch.where(drawn[..., None], box, torch.inf) for box in (corners.amin(2), -corners.amax(2)))
    parts = (lines.flatten(2), geometry.planes[:, :, 0], low[..., :2], -high[..., :2], depth.amin(2, keepdim=True))
    faces = torch.cat((*parts, depth.amax(2, keepdim=True)), -1)
    return Records(faces.contiguous(), sides.contiguous(), drawn.contiguous())


def side_of(lines: Float[Tensor, "*N 3"], x: Float[Tensor, "*N"], y: Float[Tensor, "*N"]) -> Bool[Tensor, "*N"]:
    """Whether points lie on the positive side of lines; rounds as the kernels and the reference do."""
    return lines[..., 1] * x + lines[..., 2] * y + lines[..., 0] >= 0


def _doubled_areas(x: Float[Tensor, "*N 3"], y: Float[Tensor, "*N 3"]) -> Float[Tensor, "*N"]:
    """Twice the signed areas of triangles."""
    ax, bx, ay, by = x[..., 1] - x[..., 0], x[..., 2] - x[..., 0], y[..., 1] - y[..., 0], y[..., 2] - y[..., 0]
    return ax * by - bx * ay
