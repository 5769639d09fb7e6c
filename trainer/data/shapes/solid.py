"""Closed solids that objects are put together from, and the mesh value that carries them.

Frame: +Y up, +Z front, +X to the object's own left; lengths in metres until `normalise`. Every building block is a
closed surface of counter-clockwise faces that look outward. Blocks overlap freely: the object is their union.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64
from numpy import ndarray

Point = tuple[float, float, float] | Float64[ndarray, "3"]


class Mesh(NamedTuple):
    """A triangle mesh."""

    vertices: Float64[ndarray, "V 3"]
    faces: Int64[ndarray, "F 3"]


def loft(rings: Float64[ndarray, "S N 3"]) -> Mesh:
    """The solid that passes through S rings of N points, with flat fans as caps.

    Each ring is a closed polygon that is star-shaped about the mean of its points; either winding is accepted.
    """
    sections, points, _ = rings.shape
    vertices = np.concatenate((rings.reshape(-1, 3), rings[[0, -1]].mean(1)))
    here = np.arange(points)
    following = (here + 1) % points
    lower = (np.arange(sections - 1) * points)[:, None]
    a, b, c, d = lower + here, lower + following, lower + points + following, lower + points + here
    sides = np.concatenate((np.stack((a, b, c), -1).reshape(-1, 3), np.stack((a, c, d), -1).reshape(-1, 3)))
    first, last = sections * points, (sections - 1) * points
    bottom = np.stack((np.full(points, first), following, here), -1)
    top = np.stack((np.full(points, first + 1), last + here, last + following), -1)
    return _outward(Mesh(vertices, np.concatenate((sides, bottom, top)).astype(np.int64)))


def ring(
    radius_x: float, radius_z: float, y: float, points: int = 16, roundness: float = 2.0
) -> Float64[ndarray, "N 3"]:
    """A superellipse |x/a|^n + |z/b|^n = 1 in the plane of height y; `roundness` n: 2 ellipse, 8 nearly a rectangle."""
    angle = (np.arange(points) + 0.5) * 2 * np.pi / points
    cosine, sine = np.cos(angle), np.sin(angle)
    # Radially, so that the points stay evenly spread: a rectangle keeps its corners' neighbourhood.
    radius = (np.abs(cosine) ** roundness + np.abs(sine) ** roundness) ** (-1 / roundness)
    return np.stack((radius_x * radius * cosine, np.full(points, y), radius_z * radius * sine), -1)


def box(size: Point, centre: Point = (0.0, 0.0, 0.0), taper: tuple[float, float] = (1.0, 1.0)) -> Mesh:
    """A cuboid; `taper` is the size of its top relative to its bottom along x and z."""
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * (size[0], size[2])
    bottom = np.insert(corners, 1, -size[1] / 2, axis=1)
    top = np.insert(corners * taper, 1, size[1] / 2, axis=1)
    return moved(loft(np.stack((bottom, top))), centre)


def cushion(size: Point, centre: Point = (0.0, 0.0, 0.0), bevel: float = 0.02, roundness: float = 8.0) -> Mesh:
    """A slab with a rounded outline and edges bevelled by `bevel`; its flat sides face up and down."""
    x, y, z = size[0] / 2, size[1] / 2, size[2] / 2
    bevel = min(bevel, 0.9 * y, 0.5 * x, 0.5 * z)
    levels = ((-y, bevel), (-y + bevel, 0.0), (y - bevel, 0.0), (y, bevel))
    rings = [ring(x - inset, z - inset, level, 24, roundness) for level, inset in levels]
    return moved(loft(np.stack(rings)), centre)


def prism(outline: Float64[ndarray, "N 2"], low: float, high: float) -> Mesh:
    """An outline of (y, z) points, star-shaped about its mean, extruded along x from `low` to `high`."""
    return loft(np.stack([np.insert(outline, 0, x, axis=1) for x in (low, high)]))


def lathe(profile: Sequence[tuple[float, float]], points: int = 20) -> Mesh:
    """A solid of revolution about +Y: (radius, y) pairs from one end to the other; radii above zero."""
    return loft(np.stack([ring(radius, radius, y, points) for radius, y in profile]))


def tube(
    path: Sequence[Point] | Float64[ndarray, "S 3"],
    radius: float | tuple[float, float] | Sequence[float],
    points: int = 10,
    square: bool = False,
) -> Mesh:
    """A bar along a path, of one radius or of one a path point; `square` gives it four flat sides.

    The section is carried along by the smallest turn at each bend and mitred there, so that it does not twist.
    """
    centres = np.asarray(path, np.float64)
    radii = np.interp(np.linspace(0, 1, len(centres)), np.linspace(0, 1, np.size(radius)), np.atleast_1d(radius))
    segments = np.diff(centres, axis=0)
    segments /= np.linalg.norm(segments, axis=1, keepdims=True)
    tangents = np.concatenate((segments[:1], segments[:-1] + segments[1:], segments[-1:]))
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    sides = 4 if square else points
    angle = (np.arange(sides) + 0.5) * 2 * np.pi / sides
    reach = radii * np.sqrt(2) if square else radii
    # A bar keeps its sides parallel to the axis that it leans on least.
    across = np.eye(3)[np.argmin(np.abs(tangents).sum(0))]
    rings = []
    for index, tangent in enumerate(tangents):
        across = across - tangent * (across @ tangent)
        across /= np.linalg.norm(across)
        beside = np.cross(tangent, across)
        rings.append(
            centres[index] + reach[index] * (np.outer(np.cos(angle), across) + np.outer(np.sin(angle), beside))
        )
    return loft(np.stack(rings))


def cylinder(start: Point, end: Point, radius: float, points: int = 16) -> Mesh:
    """A straight round bar."""
    return tube((start, end), radius, points)


def moved(mesh: Mesh, offset: Point) -> Mesh:
    """The mesh, translated."""
    return Mesh(mesh.vertices + np.asarray(offset, np.float64), mesh.faces)


def turned(mesh: Mesh, axis: int, angle: float, pivot: Point = (0.0, 0.0, 0.0)) -> Mesh:
    """The mesh, rotated right-handedly by `angle` radians about the axis (0 x, 1 y, 2 z) through `pivot`."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.eye(3)
    rotation[first, first] = rotation[second, second] = np.cos(angle)
    rotation[first, second], rotation[second, first] = -np.sin(angle), np.sin(angle)
    return Mesh((mesh.vertices - np.asarray(pivot)) @ rotation.T + np.asarray(pivot), mesh.faces)


def mirrored(mesh: Mesh) -> Mesh:
    """The mesh on the other side of the plane x = 0, its faces still outward."""
    return Mesh(mesh.vertices * (-1.0, 1.0, 1.0), mesh.faces[:, ::-1])


def both_sides(mesh: Mesh) -> Mesh:
    """The mesh and its mirror image."""
    return joined(mesh, mirrored(mesh))


def joined(*meshes: Mesh) -> Mesh:
    """All the meshes in one."""
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    faces = [mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def normalise(mesh: Mesh) -> Mesh:
    """The mesh centred on its bounding box and scaled to a unit bounding-box diagonal (ShapeNet's convention)."""
    used = mesh.vertices[mesh.faces.reshape(-1)]
    low, high = used.min(0), used.max(0)
    return Mesh((mesh.vertices - (low + high) / 2) / np.linalg.norm(high - low), mesh.faces)


def signed_volume(mesh: Mesh) -> float:
    """The volume that the faces enclose, parts that overlap counted twice; negative where they look inward."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)


def _outward(mesh: Mesh) -> Mesh:
    return mesh if signed_volume(mesh) >= 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1])
