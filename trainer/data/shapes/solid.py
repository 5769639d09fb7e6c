"""Closed solids that objects are put together from, and the mesh value that carries them.

Frame: +Y up, +Z front, +X to the object's own left; lengths in metres until `normalise`. Every building block is a
closed surface of counter-clockwise faces that look outward. Blocks overlap freely: the object is their union.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64
from numpy import ndarray

from trainer.data.shapes.arithmetic import centred, rotated, tube_sections, volume, with_centres

Point = tuple[float, float, float] | Float64[ndarray, "3"]


class Mesh(NamedTuple):
    """A triangle mesh."""

    vertices: Float64[ndarray, "V 3"]
    faces: Int64[ndarray, "F 3"]


def loft(rings: Float64[ndarray, "S N 3"]) -> Mesh:
    """The solid that passes through S rings of N points, with flat fans as caps.

    Each ring is a closed polygon that is star-shaped about the mean of its points; either winding is accepted.
    """
    mesh = _oriented(rings, rising=True)
    return mesh if signed_volume(mesh) >= 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1])


def _oriented(rings: Float64[ndarray, "S N 3"], rising: bool) -> Mesh:
    """A loft whose winding is known: rings that turn right-handedly about the way from the first to the last, or
    (`rising` false) left-handedly."""
    sections, points, _ = rings.shape
    faces = _loft_faces(sections, points)
    return Mesh(with_centres(rings), faces if rising else faces[:, ::-1])


@lru_cache(maxsize=256)
def _loft_faces(sections: int, points: int) -> Int64[ndarray, "F 3"]:
    """Faces of a loft: the sides, then the cap around the last vertex but one, then that around the last. They cannot
    be written to: all lofts of this size have them in common."""
    here = np.arange(points)
    following = (here + 1) % points
    lower = (np.arange(sections - 1) * points)[:, None]
    a, b, c, d = lower + here, lower + following, lower + points + following, lower + points + here
    sides = np.concatenate((np.stack((a, b, c), -1).reshape(-1, 3), np.stack((a, c, d), -1).reshape(-1, 3)))
    first, last = sections * points, (sections - 1) * points
    bottom = np.stack((np.full(points, first), following, here), -1)
    top = np.stack((np.full(points, first + 1), last + here, last + following), -1)
    faces = np.concatenate((sides, bottom, top)).astype(np.int64)
    faces.setflags(write=False)
    return faces


def ring(
    radius_x: float, radius_z: float, y: float, points: int = 16, roundness: float = 2.0
) -> Float64[ndarray, "N 3"]:
    """A superellipse |x/a|^n + |z/b|^n = 1 in the plane of height y; `roundness` n: 2 ellipse, 8 nearly a rectangle."""
    reach, cosine, sine = superellipse(points, roundness)
    outline = np.empty((points, 3))
    outline[:, 0], outline[:, 1], outline[:, 2] = radius_x * reach * cosine, y, radius_z * reach * sine
    return outline


@lru_cache(maxsize=256)
def superellipse(points: int, roundness: float = 2.0) -> tuple[Float64[ndarray, "N"], ...]:
    """(radius, cosine, sine) of evenly spread points on |x|^n + |z|^n = 1, which begin half a step from +x towards +z.
    They cannot be written to: all sections of this kind have them in common."""
    angle = (np.arange(points) + 0.5) * 2 * np.pi / points
    cosine, sine = np.cos(angle), np.sin(angle)
    # Radially, so that the points stay evenly spread: a rectangle keeps its corners' neighbourhood.
    reach = (np.abs(cosine) ** roundness + np.abs(sine) ** roundness) ** (-1 / roundness)
    for part in (reach, cosine, sine):
        part.setflags(write=False)
    return reach, cosine, sine


def box(size: Point, centre: Point = (0.0, 0.0, 0.0), taper: tuple[float, float] = (1.0, 1.0)) -> Mesh:
    """A cuboid; `taper` is the size of its top relative to its bottom along x and z."""
    x, y, z = size[0] / 2, size[1] / 2, size[2] / 2
    top_x, top_z = x * taper[0], z * taper[1]
    bottom = ((-x, -y, -z), (x, -y, -z), (x, -y, z), (-x, -y, z))
    top = ((-top_x, y, -top_z), (top_x, y, -top_z), (top_x, y, top_z), (-top_x, y, top_z))
    vertices = np.array((*bottom, *top, (0.0, -y, 0.0), (0.0, y, 0.0)))
    vertices += centre
    return Mesh(vertices, _loft_faces(2, 4)[:, ::-1])


def cushion(size: Point, centre: Point = (0.0, 0.0, 0.0), bevel: float = 0.02, roundness: float = 8.0) -> Mesh:
    """A slab with a rounded outline and edges bevelled by `bevel`; its flat sides face up and down."""
    x, y, z = size[0] / 2, size[1] / 2, size[2] / 2
    bevel = min(bevel, 0.9 * y, 0.5 * x, 0.5 * z)
    levels = ((-y, bevel), (-y + bevel, 0.0), (y - bevel, 0.0), (y, bevel))
    rings = [ring(x - inset, z - inset, level, 24, roundness) for level, inset in levels]
    mesh = _oriented(np.concatenate(rings).reshape(len(levels), -1, 3), rising=False)
    return moved(mesh, centre)


def prism(outline: Float64[ndarray, "N 2"], low: float, high: float) -> Mesh:
    """An outline of (y, z) points, star-shaped about its mean, extruded along x from `low` to `high`."""
    return loft(np.stack([np.insert(outline, 0, x, axis=1) for x in (low, high)]))


def lathe(profile: Sequence[tuple[float, float]], points: int = 20) -> Mesh:
    """A solid of revolution about +Y: (radius, y) pairs from one end to the other; radii above zero."""
    reach, cosine, sine = superellipse(points)
    levels = np.asarray(profile, np.float64)
    radii = levels[:, :1] * reach
    rings = np.empty((len(levels), points, 3))
    rings[:, :, 0], rings[:, :, 1], rings[:, :, 2] = radii * cosine, levels[:, 1:], radii * sine
    return loft(rings)


def tube(
    path: Sequence[Point] | Float64[ndarray, "S 3"],
    radius: float | tuple[float, float] | Sequence[float],
    points: int = 10,
    square: bool = False,
) -> Mesh:
    """A bar along a path, of one radius or of one a path point; `square` gives it four flat sides.

    The section is carried along by the smallest turn at each bend, so that it does not twist, and set across the
    bisector there, without widening.
    """
    centres = np.asarray(path, np.float64)
    steps = len(centres)
    radii = np.interp(np.linspace(0, 1, steps), np.linspace(0, 1, np.size(radius)), np.atleast_1d(radius))
    sides = 4 if square else points
    _, cosine, sine = superellipse(sides)
    reach = radii * np.sqrt(2) if square else radii
    return _oriented(tube_sections(centres, reach, cosine, sine), rising=True)


def cylinder(start: Point, end: Point, radius: float, points: int = 16) -> Mesh:
    """A straight round bar."""
    return tube((start, end), radius, points)


def moved(mesh: Mesh, offset: Point) -> Mesh:
    """The mesh, translated."""
    return Mesh(mesh.vertices + np.asarray(offset, np.float64), mesh.faces)


def turned(mesh: Mesh, axis: int, angle: float, pivot: Point = (0.0, 0.0, 0.0)) -> Mesh:
    """The mesh, rotated right-handedly by `angle` radians about the axis (0 x, 1 y, 2 z) through `pivot`."""
    return Mesh(
        rotated(mesh.vertices, axis, math.cos(angle), math.sin(angle), np.asarray(pivot, np.float64)), mesh.faces
    )


def mirrored(mesh: Mesh) -> Mesh:
    """The mesh on the other side of the plane x = 0, its faces still outward."""
    return Mesh(mesh.vertices * (-1.0, 1.0, 1.0), mesh.faces[:, ::-1])


def both_sides(mesh: Mesh) -> Mesh:
    """The mesh and its mirror image."""
    return joined(mesh, mirrored(mesh))


def joined(*meshes: Mesh) -> Mesh:
    """All the meshes in one."""
    offsets = accumulate((len(mesh.vertices) for mesh in meshes[:-1]), initial=0)
    faces = [mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def normalise(mesh: Mesh) -> Mesh:
    """The mesh centred on its bounding box and scaled to a unit bounding-box diagonal (ShapeNet's convention)."""
    return Mesh(centred(mesh.vertices, mesh.faces), mesh.faces)


def signed_volume(mesh: Mesh) -> float:
    """The volume that the faces enclose, parts that overlap counted twice; negative where they look inward."""
    return float(volume(mesh.vertices, mesh.faces))
