"""Vertex normals, from which Gouraud shading takes its colours."""

from jaxtyping import Float, Int64
from torch import Tensor

# Squared doubled areas below this (an edge of a hundred-thousandth of the object) count as no surface at all.
SMALLEST_SQUARED_AREA = 1e-20


def vertex_normals(vertices: Float[Tensor, "*B V 3"], faces: Int64[Tensor, "F 3"]) -> Float[Tensor, "*B V 3"]:
    """Unit normals, the area-weighted mean over the faces around each vertex; outward for counter-clockwise faces.

    A vertex whose faces have no area gets a normal of length (almost) zero, and a finite gradient.
    """
    corners = vertices[..., faces, :]
    first, second, third = corners.unbind(-2)
    doubled_area = (second - first).cross(third - first, dim=-1)
    summed = vertices.new_zeros(vertices.shape)
    for corner in range(3):
        summed = summed.index_add(-2, faces[:, corner], doubled_area)
    return summed * (summed.square().sum(-1, keepdim=True) + SMALLEST_SQUARED_AREA).rsqrt()
