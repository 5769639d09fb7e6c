"""Occupancy of closed meshes against inside tests in closed form, centre by centre, and thin parts by their volume."""

import numpy as np
import pytest
import trimesh

from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, joined, moved, turned
from trainer.evaluation.voxels import FINENESS, blocks, inside_out, occupy, thin_layers, voxelise, winding_numbers

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


def torus(radius: float, tube: float) -> tuple[Mesh, np.ndarray]:
    """A ring about +Y, fine enough to be one, and how far each centre is from the circle in its middle."""
    ring = trimesh.creation.torus(radius, tube, major_sections=512, minor_sections=256)
    upright = np.asarray(ring.vertices)[:, [0, 2, 1]]
    across = np.linalg.norm(CENTRES[..., [0, 2]], axis=-1) - radius
    return Mesh(upright, np.asarray(ring.faces, np.int64)[:, ::-1]), np.hypot(across, CENTRES[..., 1])


def test_a_torus_holds_exactly_the_centres_within_and_its_hole_stays_open() -> None:
    ring, distance = torus(0.3, 0.125)
    grid = voxelise(*ring)
    assert grid[distance < 0.125 * 0.999].all()
    assert not grid[distance >= 0.125].any()
    assert not grid[15:17, :, 15:17].any()


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


def test_thick_shapes_fill_the_voxels_whose_centres_they_hold() -> None:
    for mesh in (sphere(0.4), box((0.5, 0.3, 0.4), (0.01, 0.02, 0.03)), turned(box((0.4, 0.3, 0.5)), 1, 0.5)):
        np.testing.assert_array_equal(occupy(*mesh).full, voxelise(*mesh))


@pytest.mark.parametrize("thickness", [0.008, 0.015, 0.025, 0.031])
def test_a_plate_thinner_than_a_voxel_is_one_layer_wherever_it_lies(thickness: float) -> None:
    """By centres alone it is a layer or nothing at all."""
    found = set()
    for height in np.linspace(-0.02, 0.02, 17):
        plate = box((0.5, thickness, 0.25), (0.0, height, 0.0))
        grid = occupy(*plate).full
        assert grid.sum() == 16 * 8
        assert grid.any((0, 2)).sum() == 1
        found.add(int(voxelise(*plate).sum()))
    assert found == {0, 16 * 8}


@pytest.mark.parametrize("width", [0.014, 0.02, 0.03])
@pytest.mark.parametrize("tilt_degrees", [0.0, 5.0, 30.0])
def test_a_bar_thinner_than_a_voxel_is_as_long_as_it_is_and_one_voxel_thick(width: float, tilt_degrees: float) -> None:
    rng = np.random.default_rng(0)
    counts = []
    for _ in range(40):
        bar = turned(box((width, 0.7, width)), 0, np.radians(tilt_degrees))
        counts.append(occupy(*moved(turned(bar, 1, rng.uniform(0, 1.5)), rng.uniform(-0.05, 0.05, 3))).full.sum())
    assert np.mean(counts) == pytest.approx(0.7 * 32, rel=0.2)


def test_corners_and_edges_of_thick_shapes_do_not_grow() -> None:
    rng = np.random.default_rng(1)
    grown = []
    for _ in range(20):
        mesh = turned(turned(box(tuple(rng.uniform(0.15, 0.5, 3))), int(rng.integers(3)), rng.uniform(0, 3)), 0, 1.0)
        grown.append(occupy(*mesh).full.sum() / voxelise(*mesh).sum() - 1)
    assert np.mean(grown) < 0.002


def test_tables_keep_their_tops_and_legs() -> None:
    """Hardly anything is missing from their shadows along the axes; by centres alone, many a table has no top."""
    rng = np.random.default_rng(0)
    lost: list[tuple[float, float]] = []
    for _ in range(20):
        x, y, z, top, leg = *rng.uniform(0.15, 0.3, 3), *rng.uniform(0.012, 0.03, 2)
        legs = [box((leg, y, leg), (sx * (x - leg), -y / 2, sz * (z - leg))) for sx in (-1, 1) for sz in (-1, 1)]
        mesh = moved(joined(box((2 * x, top, 2 * z)), *legs), (0.0, rng.uniform(0.0, 0.05), 0.0))
        shadows = voxelise(*mesh, resolution=32 * FINENESS)
        for axis in range(3):
            shadow = shadows.any(axis).sum() / FINENESS**2
            kept, by_centres = (grid.any(axis).sum() for grid in (occupy(*mesh).full, voxelise(*mesh)))
            lost.append((max(0.0, 1 - kept / shadow), max(0.0, 1 - by_centres / shadow)))
    ours, of_centres = np.array(lost).T
    assert ours.mean() < 0.02
    assert ours.max() < 0.15
    assert of_centres.mean() > 0.15
    assert of_centres.max() > 0.9


def test_blocks_are_counted() -> None:
    fine = np.random.default_rng(0).random((20, 20, 20)) < 0.3
    counted = blocks(fine)
    for corner in np.ndindex(4, 4, 4):
        x, y, z = (FINENESS * place for place in corner)
        assert counted[corner] == fine[x : x + FINENESS, y : y + FINENESS, z : z + FINENESS].sum()
    assert not thin_layers(np.zeros((20, 20, 20), bool)).any()


def test_air_is_what_is_outside() -> None:
    solid = occupy(*box((0.5, 0.25, 0.75)))
    assert (~solid.air).sum() == 80 * 40 * 120
    with pytest.raises(ValueError, match="expected finite vertices"):
        occupy(np.full((3, 3), np.inf), np.array([(0, 1, 2)]))


def test_what_lies_inside_is_wound_around_once_or_once_the_other_way() -> None:
    outward = box((0.5, 0.25, 0.75))
    inward = Mesh(outward.vertices, outward.faces[:, ::-1])
    twice = joined(outward, box((0.25, 0.25, 0.25)))
    assert np.unique(winding_numbers(*outward, 32)).tolist() == [0, 1]
    assert np.unique(winding_numbers(*inward, 32)).tolist() == [-1, 0]
    assert np.unique(winding_numbers(*twice, 32)).tolist() == [0, 1, 2]


def test_the_part_that_is_inside_out_is_told() -> None:
    large, small = box((0.5, 0.25, 0.5), (0.0, 0.25, 0.0)), box((0.5, 0.25, 0.25), (0.0, -0.25, 0.0))
    turned_over = Mesh(small.vertices, small.faces[:, ::-1])
    assert inside_out(*joined(large, small)) == 0
    assert inside_out(*joined(large, turned_over)) == pytest.approx(1 / 3)
    assert inside_out(*turned_over) == 1
    assert inside_out(*box((0.5, 1e-6, 0.5), (0.0, 0.001, 0.0))) == 0


def test_a_slab_whose_underside_has_passed_its_top_is_inside_out() -> None:
    slab = box((0.5, 0.05, 0.5))
    crossed = slab.vertices * (1, -1, 1)
    assert inside_out(slab.vertices, slab.faces) == 0
    assert inside_out(crossed, slab.faces) == 1
