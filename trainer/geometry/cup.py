"""A cup, the other base mesh of the *subdivision* parameterisation: for what is hollow."""

import numpy as np
from jaxtyping import Float

from trainer.geometry.topology import BaseMesh

# Half of its width, and how thick wall and floor are, for a cup of height 1.
RADIUS, WALL, FLOOR = 0.55, 0.165, 0.25


def subdivided_cup(segments: int, side: float = 1.0) -> BaseMesh:
    """A round cup around the origin that opens upwards: as high as the cube of that side, with as many vertices around
    as the cube has around its middle, 4·segments, on its wall's outside, inside, floor and underside.

    The topology is the cube's, that of a ball. The diagonals are laid so that the mesh is its own mirror image in x and
    z.
    """
    around = 4 * segments
    angles = 2 * np.pi * np.arange(around) / around
    circle = np.stack((np.sin(angles), np.cos(angles)), 1)
    profile = side * _profile(segments)
    rings = np.empty((len(profile), around, 3))
    rings[:, :, [0, 2]] = profile[:, :1, None] * circle
    rings[:, :, 1] = profile[:, 1:]
    bottom, floor = (side * np.array([[0.0, height, 0.0]]) for height in (-0.5, FLOOR - 0.5))
    vertices = np.concatenate((bottom, rings.reshape(-1, 3), floor)).round(12)

    def corner(ring: int, place: int) -> int:
        return 1 + ring * around + place % around

    last = len(profile) - 1
    faces: list[tuple[int, int, int]] = []
    for place in range(around):
        faces.append((0, corner(0, place + 1), corner(0, place)))
        for ring in range(last):
            a, b = corner(ring, place), corner(ring, place + 1)
            c, d = corner(ring + 1, place + 1), corner(ring + 1, place)
            # From quarter to quarter the other way.
            faces += [(a, b, c), (a, c, d)] if place // segments % 2 else [(a, b, d), (b, c, d)]
        faces.append((len(vertices) - 1, corner(last, place), corner(last, place + 1)))
    return BaseMesh(vertices, np.array(faces, np.int64))


def _profile(segments: int) -> Float[np.ndarray, "S 2"]:
    """(radius, height) of each ring, from the middle of the underside along the outside, the rim and the inside to the
    middle of the floor, for a cup of height 1."""
    shares = np.arange(1, segments // 2) / max(segments // 2, 1)
    hollow = RADIUS - WALL
    underside = [(RADIUS * share, -0.5) for share in shares]
    outside = [(RADIUS, height) for height in np.linspace(-0.5, 0.5, segments + 1)]
    inside = [(hollow, height) for height in np.linspace(0.5, FLOOR - 0.5, max(segments, 2))]
    floor = [(hollow * share, FLOOR - 0.5) for share in shares[::-1]]
    return np.array(underside + outside + inside + floor)
