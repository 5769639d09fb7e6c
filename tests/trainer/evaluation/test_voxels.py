"""Occupancy of closed meshes against inside tests in closed form, centre by centre."""

import numpy as np
import pytest
import trimesh

from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, joined, moved, turned
from trainer.evaluation.voxels import voxelise

CENTRES = (np.stack(np.meshgrid(*[np.arange(32)] * 3, indexing="ij"), -1) + 0.5) / 32 - 0.5


def sphere(radius: float, centre: tuple[float, float, float] = (0.0, 0.0, 0.0), subdivisions: int = 5) -> Mesh:
    ball = trimesh.creation.icosphere(subdivisions, radius)
    return Mesh(np.asarray(ball.vertices) + centre, np.asarray(ball.faces, np.int64))


def test_boxes_hold_exactly_the_centres_within() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        size, centre = rng.uniform(0.05, 0.6, 3), rng.uniform(-0.3, 0.3, 3)
        expected = (np.abs(CENTRES - centre) < size / 2).all(-1)
        np.testing.assert_array_equal(voxelise(*box(tuple(size), tuple(centre))), expected)


def test_axes_are_not_confused() -> None:
    grid = voxelise(*box((0.25, 0.5, 0.75), (0.125, -0.25, 0.0)))
    assert grid.sum() == 8 * 16 * 24
    assert grid[16:24, 0:16, 4:28].all()


def test_faces_through_centres_are_half_open() -> None:
    """Columns run exactly through edges, vertices and faces: each solid has its volume, and two that touch fill up."""
    shift = 0.5 / 32
    left, right = (
        box((0.25, 0.5, 0.5), (-0.125 + shift, shift, shift)),
        box((0.25, 0.5, 0.5), (0.125 + shift, shift, shift)),
    )
    assert voxelise(*left).sum() == voxelise(*right).sum() == 8 * 16 * 16
    assert not (voxelise(*left) & voxelise(*right)).any()
    octahedron = Mesh(
        np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]) * 0.25 + shift,
        np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]),
    )
    grid = voxelise(*octahedron)
    distance = np.abs((CENTRES - shift) * 32).sum(-1).round(9)
    assert grid[distance < 8].all()
    assert not grid[distance > 8].any()


def test_a_sphere_holds_exactly_the_centres_within() -> None:
    ball = sphere(0.4)
    distance = np.linalg.norm(CENTRES, axis=-1)
    grid = voxelise(*ball)
    assert grid[distance < 0.4 * 0.999].all()
    assert not grid[distance >= 0.4].any()


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_the_generalised_winding_number_of_a_crumpled_surface(seed: int) -> None:
    """An oracle that shares no code: the sum of solid angles. The surface intersects itself many times."""
    rng = np.random.default_rng(seed)
    ball = sphere(0.3, subdivisions=2)
    crumpled = ball.vertices + rng.normal(scale=0.06, size=ball.vertices.shape)
    expected = np.abs(solid_angles(crumpled[ball.faces], CENTRES[::3, ::3, ::3].reshape(-1, 3))).round() != 0
    np.testing.assert_array_equal(voxelise(crumpled, ball.faces)[::3, ::3, ::3].reshape(-1), expected)


def solid_angles(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    a, b, c = (triangles[:, corner] - points[:, None] for corner in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=-1) for side in (a, b, c))
    dots = (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
    return np.arctan2((a * np.cross(b, c)).sum(-1), la * lb * lc + dots).sum(1) / (2 * np.pi)


def test_orientation_overlap_and_the_order_of_faces_do_not_matter() -> None:
    first, second = sphere(0.2, (0.1, 0.0, 0.0), 3), sphere(0.2, (-0.1, 0.05, 0.0), 3)
    union = voxelise(*first) | voxelise(*second)
    both = joined(first, second)
    np.testing.assert_array_equal(voxelise(*both), union)
    np.testing.assert_array_equal(voxelise(both.vertices, both.faces[:, ::-1]), union)
    order = np.random.default_rng(0).permutation(len(both.faces))
    np.testing.assert_array_equal(voxelise(both.vertices, both.faces[order]), union)


def test_volume_is_unbiased() -> None:
    rng = np.random.default_rng(1)
    counts = []
    for _ in range(60):
        mesh = turned(box((0.3, 0.05, 0.2)), int(rng.integers(3)), rng.uniform(0, 3))
        counts.append(voxelise(*moved(mesh, rng.uniform(-0.2, 0.2, 3))).sum() / 32**3)
    assert np.mean(counts) == pytest.approx(0.3 * 0.05 * 0.2, rel=0.02)


def test_resolution_is_a_choice_and_what_lies_outside_the_cube_is_cut_off() -> None:
    assert voxelise(*box((0.5, 0.5, 0.5)), resolution=64).sum() == 32**3
    assert voxelise(*box((3.0, 3.0, 3.0))).all()
    assert not voxelise(*box((0.1, 0.1, 0.1), (2.0, 0.0, 0.0))).any()
    assert not voxelise(np.empty((0, 3)), np.empty((0, 3), np.int64)).any()


def test_numbers_that_are_not_finite_are_refused() -> None:
    mesh = make_shape("car", 0)
    vertices = mesh.vertices.copy()
    vertices[5, 1] = np.nan
    with pytest.raises(ValueError, match="expected finite vertices"):
        voxelise(vertices, mesh.faces)
