"""Every building block is closed and looks outward, and has the volume that geometry gives it."""

import numpy as np
import pytest

from trainer.data.shapes.solid import (
    Mesh,
    both_sides,
    box,
    cushion,
    cylinder,
    joined,
    lathe,
    loft,
    mirrored,
    moved,
    normalise,
    prism,
    ring,
    signed_volume,
    tube,
    turned,
)


def assert_closed(mesh: Mesh) -> None:
    """Each directed edge occurs once, and once the other way round: closed, oriented, no edge shared by more."""
    edges = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert len(np.unique(edges, axis=0)) == len(edges)
    np.testing.assert_array_equal(np.unique(edges, axis=0), np.unique(edges[:, ::-1], axis=0))


POLYGON_16 = 16 / 2 * np.sin(2 * np.pi / 16)
BLOCKS = {
    "box": (box((1.0, 2.0, 3.0), (0.3, 0.2, 0.1)), 6.0),
    "pyramid stump": (box((1.0, 1.0, 1.0), taper=(0.5, 0.5)), (1 + 0.25 + 0.5) / 3),
    "cylinder": (cylinder((0.0, 0.0, 0.0), (0.0, 3.0, 4.0), 0.5), POLYGON_16 * 0.25 * 5),
    "lathe": (lathe([(1.0, 0.0), (0.5, 3.0)], 16), POLYGON_16 * 3 * (1 + 0.25 + 0.5) / 3),
    "falling lathe": (lathe([(0.5, 3.0), (1.0, 0.0)], 16), POLYGON_16 * 3 * (1 + 0.25 + 0.5) / 3),
    "prism": (prism(np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)]), -1.0, 2.0), 6.0),
    "square bar": (tube([(0.0, 0.0, 0.0), (0.0, 2.0, 0.0)], 0.25, square=True), 0.5),
    "mirror": (mirrored(box((1.0, 2.0, 3.0), (4.0, 0.0, 0.0), (0.5, 1.0))), 6.0 * 0.75),
    "pair": (both_sides(box((1.0, 1.0, 1.0), (2.0, 0.0, 0.0))), 2.0),
    "backward loft": (loft(np.stack([ring(1.0, 1.0, y, 4)[::-1] for y in (1.0, 0.0)])), 2.0),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_blocks_are_closed_and_have_their_volume(name: str) -> None:
    mesh, volume = BLOCKS[name]
    assert_closed(mesh)
    assert signed_volume(mesh) == pytest.approx(volume, rel=1e-12)


def test_bent_tubes_and_cushions_are_closed() -> None:
    for mesh in (
        tube([(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0)], (0.1, 0.05), 8),
        cushion((1.0, 0.2, 1.0), bevel=0.05),
        cushion((0.01, 0.01, 0.01), bevel=5.0),
    ):
        assert_closed(mesh)
        assert signed_volume(mesh) > 0


def test_a_bar_around_a_right_angle_does_not_twist() -> None:
    bar = tube([(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 1.0)], 0.1, square=True)
    assert np.ptp(bar.vertices[:, 0]) == pytest.approx(0.2)


def test_a_turn_is_right_handed() -> None:
    z_axis = Mesh(np.array([(0.0, 0.0, 1.0)] * 3), np.array([(0, 1, 2)]))
    np.testing.assert_allclose(turned(z_axis, 1, np.pi / 2).vertices[0], (1.0, 0.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(turned(z_axis, 0, np.pi / 2).vertices[0], (0.0, -1.0, 0.0), atol=1e-15)
    about_itself = turned(z_axis, 2, 1.0, (0.0, 0.0, 1.0))
    np.testing.assert_allclose(about_itself.vertices, z_axis.vertices, atol=1e-15)


def test_normalising_centres_the_box_and_makes_its_diagonal_one() -> None:
    mesh = joined(box((3.0, 4.0, 12.0), (7.0, -2.0, 1.0)), moved(box((1.0, 1.0, 1.0)), (7.0, -2.0, 1.0)))
    unused = Mesh(np.concatenate((mesh.vertices, [(1e6, 0.0, 0.0)])), mesh.faces)
    for given in (mesh, unused):
        result = normalise(given)
        used = result.vertices[result.faces.reshape(-1)]
        np.testing.assert_allclose(used.max(0), np.array([3.0, 4.0, 12.0]) / 26, rtol=1e-12)
        np.testing.assert_allclose(used.min(0), -used.max(0), rtol=1e-12)
