"""Occupancy of meshes as they are found, on solids of known volume that are damaged in the ways real models are."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.trainer.evaluation.test_voxels import sphere, torus
from trainer.data.meshes import load_mesh
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, joined, moved, turned
from trainer.evaluation.fill import fill
from trainer.evaluation.metrics import iou
from trainer.evaluation.voxels import occupy, voxelise

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
    np.testing.assert_array_equal(fill(*mesh).full, voxelise(*BOX))


def test_a_sphere_neither_grows_nor_shrinks() -> None:
    ball = sphere(0.4)
    grid = fill(*ball).full
    assert grid.sum() / 32**3 == pytest.approx(4 / 3 * np.pi * 0.4**3, rel=0.006)
    assert iou(grid, voxelise(*ball)) > 0.99


def test_a_torus_keeps_its_hole() -> None:
    ring, distance = torus(0.3, 0.125)
    grid = fill(*ring).full
    assert grid[distance < 0.125 * 0.999].all()
    assert not grid[distance >= 0.125].any()


@pytest.mark.parametrize("axis", [0, 2, 1])
def test_a_shell_that_opens_sideways_or_upwards_is_hollow_and_one_voxel_thick(axis: int) -> None:
    grid = fill(*without(BOX, axis, 1)).full
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
    grid = fill(*joined(open_outer, open_inner, _rim(0.25, 0.1875, rim_y))).full
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
    grid = fill(*table).full
    assert not grid[16, 18, 16]
    assert iou(grid, voxelise(*table)) > 0.98


def test_a_single_sheet_becomes_one_layer() -> None:
    sheet = Mesh(
        np.array([(-0.25, 0.01, -0.25), (0.25, 0.01, -0.25), (0.25, 0.01, 0.25), (-0.25, 0.01, 0.25)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    grid = fill(*sheet).full
    assert grid.sum() == 16 * 16
    assert grid.any((0, 2)).sum() == 1


@pytest.mark.parametrize("tilt_degrees", [0.0, 20.0, 40.0])
@pytest.mark.parametrize("thickness", [0.0, 0.0005, 0.002, 0.004, 0.01, 0.02])
def test_a_shell_of_any_thinness_is_one_layer(thickness: float, tilt_degrees: float) -> None:
    """As many voxels as the shell's area has, however thin it is and however it lies."""
    rng = np.random.default_rng(0)
    counts = []
    for _ in range(8):
        plate = moved(box((0.6, max(thickness, 1e-12), 0.5)), rng.uniform(-0.02, 0.02, 3))
        plate = turned(turned(plate, 0, np.radians(tilt_degrees)), 1, rng.uniform(0, 1.5))
        counts.append(fill(*plate).full.sum())
    assert np.mean(counts) == pytest.approx(0.6 * 0.5 * 32**2, rel=0.25)


def test_a_hollow_that_nobody_can_see_is_solid() -> None:
    """Nested shells, the inner one looking inwards as a lining does, outwards as rubbish does, or missing a side."""
    outer, inner = sphere(0.4), sphere(0.25)
    expected = voxelise(*outer)
    for lining in (Mesh(inner.vertices, inner.faces[:, ::-1]), inner, Mesh(inner.vertices, inner.faces[::2])):
        assert iou(fill(*joined(outer, lining)).full, expected) > 0.995


def test_parts_that_overlap_are_one_whichever_way_they_look() -> None:
    first, second = box((0.5, 0.3, 0.3), (-0.1, 0.0, 0.0)), box((0.5, 0.2, 0.4), (0.1, 0.05, 0.0))
    expected = voxelise(*first) | voxelise(*second)
    backwards = Mesh(second.vertices, second.faces[:, ::-1])
    assert iou(fill(*joined(first, second)).full, expected) == 1
    assert iou(fill(*joined(first, backwards)).full, expected) > 0.98


def test_a_small_hole_lets_in_no_more_than_the_rays_that_pass_through_it() -> None:
    faces = trimesh.creation.icosphere(4, 0.4).faces
    ball = sphere(0.4, subdivisions=4)
    holed = Mesh(ball.vertices, np.delete(faces, np.arange(40, 44), axis=0))
    assert iou(fill(*holed).full, voxelise(*ball)) > 0.95


@pytest.mark.parametrize("category", ["car", "chair"])
def test_sound_shapes_are_what_the_rule_for_closed_meshes_says(category: str) -> None:
    """So that a perfect reconstruction of a sound mesh from a file has an IoU of 1."""
    shapes = [make_shape(category, seed) for seed in range(12)]
    overlaps = [iou(fill(*mesh).full, occupy(*mesh).full) for mesh in shapes]
    assert np.median(overlaps) == 1
    assert np.mean(overlaps) > 0.99


def binvox(mesh: Mesh, resolution: int = 32) -> np.ndarray:
    """What binvox does unless told otherwise, on the centres of voxels: what can be seen from outside along an axis is
    carved away, and the rest is put to the vote of the three axes' parities. Slow and obvious."""
    centres = (np.arange(resolution) + 0.5) / resolution - 0.5
    votes, carved = np.zeros((2, resolution, resolution, resolution), np.int64)
    for axis in range(3):
        order = (axis + 1) % 3, (axis + 2) % 3, axis
        a, b, c = mesh.vertices[mesh.faces][..., order].transpose(1, 0, 2)
        area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        a, b, c, area = (values[area != 0] for values in (a, b, c, area))
        for i, x in enumerate(centres):
            for j, y in enumerate(centres):
                v = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])) / area
                w = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])) / area
                hit = (v >= 0) & (w >= 0) & (v + w <= 1)
                heights = (a + v[:, None] * (b - a) + w[:, None] * (c - a))[hit, 2]
                below = (heights[:, None] < centres).sum(0)
                votes.transpose(order)[i, j] += below % 2
                carved.transpose(order)[i, j] += (below == 0) | (below == len(heights))
    return (votes >= 2) & (carved == 0)


# Off the centres of voxels: an oracle this simple counts an edge twice.
OFF = (0.0031, 0.0043, 0.0057)


@pytest.mark.parametrize(
    "mesh",
    [
        moved(BOX, OFF),
        moved(Mesh(BOX.vertices, BOX.faces[:, ::-1]), OFF),
        moved(Mesh(BOX.vertices, np.where(np.arange(len(BOX.faces))[:, None] % 2, BOX.faces[:, ::-1], BOX.faces)), OFF),
        moved(turned(turned(BOX, 0, 0.3), 1, 0.7), OFF),
        moved(sphere(0.35, subdivisions=3), OFF),
        moved(joined(box((0.3, 0.3, 0.3), (-0.2, 0.0, 0.0)), box((0.2, 0.4, 0.3), (0.2, 0.0, 0.0))), OFF),
    ],
    ids=["sound", "inward", "mixed orientation", "turned", "sphere", "two parts"],
)
def test_solids_are_what_binvox_would_fill(mesh: Mesh) -> None:
    """But for the tip of a corner, which is thin."""
    ours, theirs = fill(*mesh).full, binvox(mesh)
    assert theirs.sum() > 1000
    assert not (theirs & ~ours).any()
    assert (ours & ~theirs).sum() <= 2


@pytest.mark.parametrize(("axis", "side"), [(1, 1), (0, 1), (2, -1), (1, -1)])
def test_half_open_boxes_differ_from_binvox_by_their_walls_alone(axis: int, side: int) -> None:
    """An open box has no inside for either; its walls, which have no volume, are a layer here. But an underside that is
    missing is taken for one that nobody drew: binvox looks in from below, and finds it hollow."""
    mesh = moved(without(BOX, axis, side), OFF)
    walls = voxelise(*moved(box((0.5625, 0.8125, 0.3125)), OFF)) & ~voxelise(*moved(box((0.4375, 0.6875, 0.1875)), OFF))
    ours, theirs = fill(*mesh).full, binvox(mesh)
    if (axis, side) == (1, -1):
        np.testing.assert_array_equal(ours, voxelise(*moved(BOX, OFF)))
        assert not theirs.any()
    else:
        np.testing.assert_array_equal(ours & ~walls, theirs & ~walls)


def test_air_is_what_is_outside() -> None:
    air = fill(*BOX).air
    within = voxelise(*BOX, resolution=len(air))
    assert not (air & within).any()
    # What is neither is where the surface passes.
    assert (~air & ~within).sum() < 0.02 * air.size


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="expected finite vertices"):
        fill(BOX.vertices + np.inf, BOX.faces)


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
    share = fill(*mesh).full.sum() / 32**3 / np.ptp(mesh.vertices, axis=0).prod()
    assert least < share < most
