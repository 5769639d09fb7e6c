"""Occupancy of meshes as they are found, on solids of known volume that are damaged in the ways real models are."""

from pathlib import Path

import numpy as np
import pytest

from tests.trainer.evaluation.test_voxels import sphere
from trainer.data.meshes import load_mesh
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, joined, turned
from trainer.evaluation.fill import voxelise_solid
from trainer.evaluation.metrics import iou
from trainer.evaluation.voxels import voxelise

REAL_MESHES = Path(__file__).parents[4] / "shared" / "meshes"
BOX = box((0.5, 0.75, 0.25))


def without(mesh: Mesh, axis: int, side: int) -> Mesh:
    """A box without one of its faces."""
    centres = mesh.vertices[mesh.faces].mean(1)[:, axis] * side
    return Mesh(mesh.vertices, mesh.faces[centres < centres.max() - 1e-9])


@pytest.mark.parametrize(
    "mesh",
    [
        BOX,
        Mesh(BOX.vertices, BOX.faces[:, ::-1]),
        Mesh(BOX.vertices, np.where(np.arange(len(BOX.faces))[:, None] % 2, BOX.faces[:, ::-1], BOX.faces)),
        joined(BOX, BOX),
        joined(BOX, box((0.3, 0.3, 0.1))),
        Mesh(BOX.vertices[BOX.faces].reshape(-1, 3), np.arange(3 * len(BOX.faces)).reshape(-1, 3)),
        without(BOX, 1, -1),
    ],
    ids=["sound", "inward", "mixed orientation", "doubled", "rubbish inside", "faces apart", "no underside"],
)
def test_a_box_is_found_however_it_is_damaged(mesh: Mesh) -> None:
    np.testing.assert_array_equal(voxelise_solid(*mesh), voxelise(*BOX))


def test_a_sphere_neither_grows_nor_shrinks() -> None:
    ball = sphere(0.4)
    grid = voxelise_solid(*ball)
    assert grid.sum() / 32**3 == pytest.approx(4 / 3 * np.pi * 0.4**3, rel=0.006)
    assert iou(grid, voxelise(*ball)) > 0.99


@pytest.mark.parametrize("axis", [0, 2, 1])
def test_a_shell_that_opens_sideways_or_upwards_is_hollow_and_one_voxel_thick(axis: int) -> None:
    grid = voxelise_solid(*without(BOX, axis, 1))
    sizes = [16, 24, 8]
    walls = [sizes[other] * sizes[axis] for other in range(3) if other != axis for _ in range(2)]
    bottom = int(np.prod(sizes) / sizes[axis])
    assert not grid[16, 16, 16]
    assert grid.sum() == pytest.approx(bottom + sum(walls), rel=0.12)
    assert grid.sum() < 0.5 * np.prod(sizes)


def test_a_vessel_of_two_walls_is_hollow_and_its_wall_is_solid() -> None:
    outer, inner = box((0.5, 0.5, 0.5)), box((0.375, 0.5, 0.375), (0.0, 0.0625, 0.0))
    rim_y = 0.25
    inner = Mesh(np.minimum(inner.vertices, (9.0, rim_y, 9.0)), inner.faces[:, ::-1])
    open_outer, open_inner = without(outer, 1, 1), without(inner, 1, 1)
    grid = voxelise_solid(*joined(open_outer, open_inner, _rim(0.25, 0.1875, rim_y)))
    expected = 16 * 16 * 16 - 12 * 12 * 14
    assert grid.sum() == expected
    assert not grid[16, 16, 16]


def _rim(outer: float, inner: float, y: float) -> Mesh:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    points = np.concatenate((square * outer, square * inner))
    here = np.arange(4)
    there = (here + 1) % 4
    faces = np.concatenate((np.stack((here, there, there + 4), -1), np.stack((here, there + 4, here + 4), -1)))
    return Mesh(np.insert(points, 1, y, axis=1), faces)


def test_space_under_a_closed_surface_is_not_filled() -> None:
    """A table with an apron: the recess below its top is reached only by rising, but belongs to nobody."""
    top = box((0.75, 0.0625, 0.75), (0.0, 0.25, 0.0))
    sides = [turned(box((0.75, 0.25, 0.0625), (0.0, 0.125, 0.34375)), 1, turn * np.pi / 2) for turn in range(4)]
    table = joined(top, *sides)
    grid = voxelise_solid(*table)
    assert not grid[16, 18, 16]
    assert iou(grid, voxelise(*table)) > 0.98


def test_a_single_sheet_becomes_one_layer() -> None:
    sheet = Mesh(
        np.array([(-0.25, 0.01, -0.25), (0.25, 0.01, -0.25), (0.25, 0.01, 0.25), (-0.25, 0.01, 0.25)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    grid = voxelise_solid(*sheet)
    assert grid.sum() == 16 * 16
    assert grid.any((0, 2)).sum() == 1


@pytest.mark.parametrize("category", ["car", "chair"])
def test_agrees_with_the_winding_number_on_sound_shapes(category: str) -> None:
    overlaps = [
        iou(voxelise_solid(*mesh), voxelise(*mesh)) for mesh in (make_shape(category, seed) for seed in range(12))
    ]
    assert np.median(overlaps) > 0.9


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="expected finite vertices"):
        voxelise_solid(BOX.vertices + np.inf, BOX.faces)


@pytest.mark.skipif(not REAL_MESHES.is_dir(), reason="no ../shared/meshes beside the project")
@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("car/gazebo_hatchback.glb", 0.45, 0.65),
        ("car/pmndrs_sedan.glb", 0.4, 0.6),
        ("bathtub/kenney_furn_bathtub.glb", 0.3, 0.6),
    ],
)
def test_real_objects_fill_a_plausible_share_of_their_box(name: str, least: float, most: float) -> None:
    mesh = load_mesh(REAL_MESHES / name)
    share = voxelise_solid(*mesh).sum() / 32**3 / np.ptp(mesh.vertices, axis=0).prod()
    assert least < share < most
