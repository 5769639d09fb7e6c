"""The conventions that every other file relies on.

Frames    object frame = glTF: right-handed, +Y up, +Z front, counter-clockwise faces outward.
Scale     a mesh is centred on its bounding box and has a unit bounding-box diagonal.
Pose      the azimuth θ in [-π, π) is a right-handed rotation of the object about +Y; the camera stays where it is.
Camera    perspective, looks at the origin from a fixed elevation and distance, from the +Z side; +Y is up.
Pictures  [C, H, W], float 0..1, row 0 on top, pixel centres at +0.5, linear colour inside, sRGB in files.
Light     a direction is the unit vector from the surface towards the light; Lambert, double-sided |n·l|, Gouraud.
Angles    radians inside; degrees at every boundary, where the name ends in `_degrees`.
"""

import math

import torch
from jaxtyping import Float
from torch import Tensor


def wrap_angle(angle: Float[Tensor, "..."]) -> Float[Tensor, "..."]:
    """The same angle in [-π, π); radians."""
    return torch.remainder(angle + math.pi, 2 * math.pi) - math.pi


def rotation_about_y(angle: Float[Tensor, "*N"]) -> Float[Tensor, "*N 3 3"]:
    """Right-handed rotation about +Y by `angle` radians, for column vectors: +Z turns towards +X."""
    cosine, sine = torch.cos(angle), torch.sin(angle)
    zero, one = torch.zeros_like(angle), torch.ones_like(angle)
    rows = (
        torch.stack((cosine, zero, sine), -1),
        torch.stack((zero, one, zero), -1),
        torch.stack((-sine, zero, cosine), -1),
    )
    return torch.stack(rows, -2)


def euler_rotation(angles: Float[Tensor, "*N 3"]) -> Float[Tensor, "*N 3 3"]:
    """R_y(a₀) · R_x(a₁) · R_z(a₂), each right-handed, for column vectors; radians."""
    # Turning all axes round by one place makes of a rotation about +Y one about +Z, and by two one about +X.
    about_y, about_x, about_z = (
        rotation_about_y(angle).roll((shift, shift), (-2, -1))
        for angle, shift in zip(angles.unbind(-1), (0, 2, 1), strict=True)
    )
    return about_y @ about_x @ about_z
