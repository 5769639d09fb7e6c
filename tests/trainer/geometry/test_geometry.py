"""Base mesh, normals and rotations, by closed form."""

import math

import numpy as np
import pytest
import torch

from rasteriser.topology import build_topology
from trainer.config import CameraConfig, LossConfig, ModelConfig, SceneConfig
from trainer.geometry.blocks import chamfered_cube, loose_cluster
from trainer.geometry.conventions import euler_rotation, rotation_about_y, wrap_angle
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube, underside, vertex_neighbours
from trainer.model.decoder import SubdivisionDecoder
from trainer.model.vae import Model
from trainer.training.loop import fixed_geometry


@pytest.mark.parametrize("segments", [1, 2, 3, 4, 7])
def test_a_subdivided_cube_is_closed_outward_and_of_the_right_size(segments: int) -> None:
    vertices, faces = subdivided_cube(segments, side=0.4)
    assert len(vertices) == 6 * segments**2 + 2
    assert len(faces) == 12 * segments**2
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(0.4**3)
    topology = build_topology(faces)
    assert (topology.edge_faces >= 0).all()
    assert len(vertices) - len(topology.edges) + len(faces) == 2


@pytest.mark.parametrize("proportions", [(1, 3, 10), (5, 1, 2), (1, 1, 2)])
@pytest.mark.parametrize("segments", [1, 2])
def test_a_cube_s_edges_may_be_cut_unevenly(segments: int, proportions: tuple[int, int, int]) -> None:
    vertices, faces = subdivided_cube(segments, 0.4, proportions)
    x, y, z = (segments * times for times in proportions)
    assert [len(np.unique(places.round(9))) for places in vertices.T] == [x + 1, y + 1, z + 1]
    assert len(vertices) == 2 * (x * y + y * z + z * x) + 2
    assert len(faces) == 4 * (x * y + y * z + z * x)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(0.4**3)
    topology = build_topology(faces)
    assert (topology.edge_faces >= 0).all()
    assert len(vertices) - len(topology.edges) + len(faces) == 2


def test_the_paper_s_cube_has_98_vertices() -> None:
    assert len(subdivided_cube(4).vertices) == 98


@pytest.mark.parametrize(("segments", "proportions"), [(4, (1, 1, 1)), (2, (1, 3, 5))])
def test_a_cube_is_its_own_mirror_image(segments: int, proportions: tuple[int, int, int]) -> None:
    vertices, faces = subdivided_cube(segments, 1, proportions)
    triangles = {tuple(sorted(map(tuple, np.round(vertices[face], 6)))) for face in faces}
    for axis in range(3):
        mirror = np.ones(3)
        mirror[axis] = -1
        mirrored = {tuple(sorted(map(tuple, np.round(vertices[face] * mirror + 0.0, 6)))) for face in faces}
        assert mirrored == triangles


def test_neighbours_average_to_the_mean_of_adjacent_vertices() -> None:
    vertices, faces = subdivided_cube(2)
    weights = vertex_neighbours(faces, len(vertices))
    np.testing.assert_allclose(weights.sum(1), 1)
    around = set(faces[(faces == 5).any(1)].ravel()) - {5}
    np.testing.assert_allclose((weights @ vertices)[5], np.mean([vertices[i] for i in around], axis=0))


def test_normals_of_a_sphere_point_outward_and_have_unit_length() -> None:
    base, faces = subdivided_cube(8)
    sphere = torch.tensor(base / np.linalg.norm(base, axis=1, keepdims=True))
    normals = vertex_normals(sphere, torch.tensor(faces))
    np.testing.assert_allclose(normals.norm(dim=1), 1, atol=1e-9)
    assert (normals * sphere).sum(1).min() > 0.98


def test_normals_turn_with_the_object() -> None:
    base, faces = subdivided_cube(3)
    vertices = torch.tensor(base + np.random.default_rng(0).normal(scale=0.1, size=base.shape))
    turn = rotation_about_y(torch.tensor(0.7, dtype=torch.float64))
    expected = vertex_normals(vertices, torch.tensor(faces)) @ turn.T
    np.testing.assert_allclose(vertex_normals(vertices @ turn.T, torch.tensor(faces)), expected, atol=1e-9)


def test_a_collapsed_mesh_has_finite_normals_and_gradients() -> None:
    vertices = torch.zeros(8, 3, requires_grad=True)
    normals = vertex_normals(vertices, torch.tensor(subdivided_cube(1).faces))
    normals.sum().backward()
    assert torch.isfinite(normals).all()
    assert vertices.grad is not None
    assert torch.isfinite(vertices.grad).all()


def test_a_chamfered_cube_is_closed_outward_and_almost_a_cube() -> None:
    chamfer = 0.1
    vertices, faces = chamfered_cube(chamfer)
    assert (len(vertices), len(faces)) == (24, 44)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    assert (np.einsum("fi,fi->f", a, np.cross(b, c)) > 0).all()
    # A cube less twelve prisms along its edges, which share six pyramid-like corners each of chamfer³/6 · 4.
    expected = 1 - 12 * chamfer**2 / 2 * (1 - 2 * chamfer) - 8 * chamfer**3 * (1 - 1 / 6)
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(expected)
    topology = build_topology(faces)
    assert (topology.edge_faces >= 0).all()
    assert len(vertices) - len(topology.edges) + len(faces) == 2


def test_a_chamfered_cube_is_shaded_as_flat_sides() -> None:
    vertices, faces = chamfered_cube()
    normals = vertex_normals(torch.tensor(vertices), torch.tensor(faces)).numpy()
    sides = np.where(np.abs(vertices) == 0.5, 2 * vertices, 0)
    assert (np.abs(sides).sum(1) == 1).all()
    assert np.degrees(np.arccos((normals * sides).sum(1))).max() < 12


@pytest.mark.parametrize("count", [1, 6, 12, 40])
def test_a_cluster_of_blocks_fills_the_cube_and_no_two_start_alike(count: int) -> None:
    centres, side = loose_cluster(count, 0.4)
    assert np.abs(centres).max() + side / 2 < 0.32
    assert count * side**3 == pytest.approx(1.2**3 * 0.4**3)
    assert all(len(np.unique(np.round(centres[:, axis], 9))) == count for axis in range(3))


def test_euler_angles_turn_about_the_three_axes_in_their_order() -> None:
    angles = torch.tensor([0.4, -1.1, 2.3], dtype=torch.float64)
    (ca, cb, cc), (sa, sb, sc) = angles.cos().tolist(), angles.sin().tolist()
    about_y = np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]])
    about_x = np.array([[1, 0, 0], [0, cb, -sb], [0, sb, cb]])
    about_z = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
    np.testing.assert_allclose(euler_rotation(angles), about_y @ about_x @ about_z, atol=1e-12)


def test_a_positive_rotation_about_y_turns_front_towards_the_right() -> None:
    turned = rotation_about_y(torch.tensor(math.pi / 2)) @ torch.tensor([0.0, 0.0, 1.0])
    np.testing.assert_allclose(turned, [1, 0, 0], atol=1e-6)


def test_angles_wrap_into_half_open_minus_pi_to_pi() -> None:
    angles = torch.tensor([math.pi, -math.pi, 3.5 * math.pi, 0.0], dtype=torch.float64)
    np.testing.assert_allclose(wrap_angle(angles), [-math.pi, -math.pi, -0.5 * math.pi, 0.0], atol=1e-12)


def test_a_new_decoder_starts_at_the_base_mesh() -> None:
    base = subdivided_cube(4, 0.4)
    vertices = SubdivisionDecoder(12, 32, base)(torch.randn(5, 12)).detach().numpy()
    assert np.abs(vertices - base.vertices).max() < 0.05


@pytest.mark.parametrize("segments", [1, 2, 4])
def test_the_underside_is_the_bottom_without_its_rim(segments: int) -> None:
    vertices, faces = subdivided_cube(segments)
    found = vertices[underside(vertices, faces)]
    assert len(found) == (segments - 1) ** 2
    np.testing.assert_allclose(found[:, 1], -0.5)
    assert (np.abs(found[:, [0, 2]]) < 0.49).all()


def test_the_underside_weighs_more_in_the_laplacian_where_no_camera_sees_it() -> None:
    model = Model(ModelConfig(segments=4), 32, 24)
    above, below = SceneConfig(), SceneConfig(camera=CameraConfig(elevation_degrees=-10.0))
    plain = fixed_geometry(model, above, LossConfig(laplacian_underside=1.0)).laplacian
    heavy = fixed_geometry(model, above, LossConfig(laplacian_underside=9.0)).laplacian
    seen = fixed_geometry(model, below, LossConfig(laplacian_underside=9.0)).laplacian
    assert plain is not None
    assert heavy is not None
    assert seen is not None
    ratio = heavy.square().sum(1) / plain.square().sum(1)
    np.testing.assert_allclose(sorted(ratio.tolist()), [1.0] * 89 + [9.0] * 9, rtol=1e-5)
    assert torch.equal(seen, plain)
