"""Corner normals: hard where a solid has edges, smooth where it is round."""

import time

import numpy as np
import pytest
import trimesh

from trainer.data.normals import corner_normals
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, cylinder


def test_a_box_has_the_normals_of_its_sides() -> None:
    mesh = box((1.0, 2.0, 3.0))
    centres = mesh.vertices[mesh.faces].mean(1)
    sides = np.argmax(np.abs(centres) / (0.5, 1.0, 1.5), axis=1)
    expected = np.eye(3)[sides] * np.sign(np.take_along_axis(centres, sides[:, None], 1))
    np.testing.assert_allclose(corner_normals(mesh), np.repeat(expected[:, None], 3, 1), atol=1e-12)


def test_a_cylinder_is_round_along_its_wall_and_hard_at_its_rim() -> None:
    mesh = cylinder((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.5, 24)
    points, normals = mesh.vertices[mesh.faces], corner_normals(mesh)
    wall = np.ptp(points[..., 1], axis=1) > 0
    np.testing.assert_allclose(normals[wall], points[wall] * (1, 0, 1) / 0.5, atol=1e-12)
    np.testing.assert_allclose(
        np.abs(normals[~wall]), np.broadcast_to((0.0, 1.0, 0.0), normals[~wall].shape), atol=1e-12
    )


def test_a_sphere_has_radial_normals() -> None:
    sphere = trimesh.creation.icosphere(3)
    normals = corner_normals(Mesh(np.asarray(sphere.vertices), np.asarray(sphere.faces, np.int64)))
    assert (normals * sphere.vertices[sphere.faces]).sum(-1).min() > np.cos(np.radians(1.0))


@pytest.mark.parametrize(("turn", "joined"), [(34.0, True), (36.0, False)])
def test_the_crease_angle_decides(turn: float, joined: bool) -> None:
    angle = np.radians(turn)
    vertices = np.array([(0, 0, 0), (0, 0, 1), (-1, 0, 0), (np.cos(angle), -np.sin(angle), 0)], float)
    normals = corner_normals(Mesh(vertices, np.array([(0, 2, 1), (0, 1, 3)])))
    shared = normals[0, 0] @ normals[1, 0]
    assert shared == pytest.approx(1.0 if joined else np.cos(angle))


def test_a_large_flat_face_stays_flat_beside_its_bevels() -> None:
    """A table top whose rim falls by 30°, hence is shaded as one with it."""
    side, rim, fall = 1.0, 0.01, 0.01 * np.tan(np.radians(30.0))
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    inner, outer = np.insert(square * side, 1, 0.0, axis=1), np.insert(square * (side + rim), 1, -fall, axis=1)
    around = [(0, 4, 5), (0, 5, 1), (1, 5, 6), (1, 6, 2), (2, 6, 7), (2, 7, 3), (3, 7, 4), (3, 4, 0)]
    mesh = Mesh(np.concatenate((inner, outer)), np.array([(0, 1, 2), (0, 2, 3), *around]))
    normals = corner_normals(mesh)
    assert np.abs(normals[:2, :, 1]).min() > np.cos(np.radians(1.0))
    # And the rim goes over into it: level where the two meet, as steep as it is at its outer edge.
    assert abs(normals[2, 0, 1]) > np.cos(np.radians(1.0))
    assert abs(normals[2, 1, 1]) == pytest.approx(np.cos(np.radians(30.0)))


def test_which_side_is_outside_does_not_matter() -> None:
    """As in many files that were never meant to be lit: some faces are turned inside out."""
    sphere = trimesh.creation.icosphere(3)
    vertices, faces = np.asarray(sphere.vertices), np.asarray(sphere.faces, np.int64)
    flipped = np.random.default_rng(0).random(len(faces)) < 0.4
    expected = corner_normals(Mesh(vertices, faces))
    expected[flipped] = -expected[flipped][:, ::-1]
    faces = np.where(flipped[:, None], faces[:, ::-1], faces)
    np.testing.assert_allclose(corner_normals(Mesh(vertices, faces)), expected, atol=1e-12)


def test_a_hundred_thousand_faces_at_one_vertex_take_no_time() -> None:
    """Each compared with each other, they would take minutes. A cone, hence smooth at its rim."""
    count = 100_000
    angle = np.arange(count) * 2 * np.pi / count
    rim = np.stack((np.cos(angle), np.zeros(count), np.sin(angle)), -1)
    here = np.arange(1, count + 1)
    mesh = Mesh(np.concatenate((((0.0, 1.0, 0.0),), rim)), np.stack((here * 0, np.roll(here, -1), here), -1))
    began = time.monotonic()
    normals = corner_normals(mesh)
    assert time.monotonic() - began < 20
    expected = np.stack((np.cos(angle), np.ones(count), np.sin(angle)), -1) / np.sqrt(2)
    np.testing.assert_allclose(normals[:, 0], expected, atol=1e-4)
    np.testing.assert_allclose(normals[:, 2], expected, atol=1e-9)


def test_faces_without_area_get_a_direction() -> None:
    mesh = Mesh(np.zeros((3, 3)), np.array([(0, 1, 2)]))
    np.testing.assert_array_equal(corner_normals(mesh), np.broadcast_to((0.0, 1.0, 0.0), (1, 3, 3)))


@pytest.mark.parametrize("category", ["car", "chair"])
def test_normals_of_real_shapes_are_unit_and_near_their_faces(category: str) -> None:
    mesh = make_shape(category, 3)
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    cross = np.cross(b - a, c - a)
    length = np.linalg.norm(cross, axis=1)
    normals = corner_normals(mesh)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0)
    cosines = np.einsum("fci,fi->fc", normals, cross)[length > 1e-12] / length[length > 1e-12, None]
    assert cosines.min() > np.cos(np.radians(35.0))
