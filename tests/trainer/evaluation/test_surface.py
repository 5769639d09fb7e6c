"""Distances between surfaces in closed form: concentric spheres, parallel plates, and what cannot be seen."""

import numpy as np
import pytest

from tests.trainer.evaluation.test_voxels import sphere
from trainer.data.shapes.solid import Mesh, box, joined, moved, turned
from trainer.evaluation.fill import fill
from trainer.evaluation.surface import POINTS, Agreement, Surface, agreement, visible_surface
from trainer.evaluation.voxels import occupy


def seen(mesh: Mesh, start: float = 0.5, count: int = POINTS) -> Surface:
    return visible_surface(*mesh, occupy(*mesh).air, count, start)


def test_points_lie_on_the_surface_with_its_normals() -> None:
    surface = seen(sphere(0.4))
    assert surface.points.shape == surface.normals.shape == (2048, 3)
    np.testing.assert_allclose(np.linalg.norm(surface.points, axis=1), 0.4, rtol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0)
    assert (surface.normals * surface.points).sum(1).min() > 0.399


def test_points_are_spread_evenly() -> None:
    """Each side of a cube, and each quarter of a side, has its share, far more exactly than by chance."""
    surface = seen(box((0.4, 0.4, 0.4)), count=6 * 4 * 100)
    for axis in range(3):
        for side in (-1, 1):
            here = surface.points[surface.normals[:, axis] * side > 0.9]
            assert len(here) == pytest.approx(400, abs=6)
            others = here[:, [other for other in range(3) if other != axis]] > 0
            quarters = np.bincount(others @ (1, 2), minlength=4)
            assert quarters == pytest.approx(100, abs=12)


@pytest.mark.parametrize("gap", [0.01, 0.03, 0.1])
def test_concentric_spheres_are_as_far_apart_as_their_radii(gap: float) -> None:
    """A point's nearest one is a little aside, as it is on one and the same sphere."""
    floor = agreement(seen(sphere(0.4)), seen(sphere(0.4), 0.25))
    spacing = np.sqrt(4 * np.pi * 0.4**2 / POINTS)
    assert floor.chamfer_distance == pytest.approx(spacing / 2, rel=0.1)
    found = agreement(seen(sphere(0.4)), seen(sphere(0.4 - gap), 0.25))
    assert found.chamfer_distance == pytest.approx(np.hypot(gap, floor.chamfer_distance), rel=0.05)
    assert found.normal_consistency > 0.998


def test_normals_tell_directions_and_not_sides() -> None:
    ball = sphere(0.4)
    inward = visible_surface(ball.vertices, ball.faces[:, ::-1], occupy(*ball).air, start=0.25)
    assert agreement(seen(ball), inward).normal_consistency > 0.998
    plate = box((0.5, 0.004, 0.5))
    beside = seen(turned(plate, 0, np.pi / 2), 0.25)
    assert agreement(seen(plate), beside).normal_consistency < 0.05
    slanted = seen(turned(plate, 0, np.pi / 3), 0.25)
    assert agreement(seen(plate), slanted).normal_consistency == pytest.approx(0.5, abs=0.05)


def test_what_lies_inside_is_not_seen() -> None:
    outer = box((0.5, 0.4, 0.5))
    with_rubbish = joined(outer, sphere(0.15), box((0.2, 0.1, 0.2)))
    for solid in (occupy(*with_rubbish), fill(*with_rubbish)):
        points = visible_surface(*with_rubbish, solid.air).points
        assert len(points) == 2048
        assert (np.abs(points) / (0.25, 0.2, 0.25)).max(1).min() > 0.999
    # Where a leg enters a seat, neither is seen.
    seat, leg = box((0.5, 0.2, 0.5)), box((0.1, 0.5, 0.1), (0.0, -0.15, 0.0))
    points = seen(joined(seat, leg)).points
    buried = (np.abs(points[:, [0, 2]]) < 0.06).all(1) & (np.abs(points[:, 1]) < 0.0999)
    assert not buried.any()
    assert (np.abs(points[:, [0, 2]]) < 0.06).all(1).sum() > 100


def test_both_sides_of_an_open_sheet_are_seen() -> None:
    sheet = Mesh(
        np.array([(-0.3, 0, -0.3), (0.3, 0, -0.3), (0.3, 0, 0.3), (-0.3, 0, 0.3)]), np.array([(0, 1, 2), (0, 2, 3)])
    )
    assert len(visible_surface(*sheet, fill(*sheet).air).points) == 2048


def test_nothing_to_see_is_as_far_away_as_can_be() -> None:
    flat = Mesh(np.zeros((3, 3)), np.array([(0, 1, 2)]))
    empty = visible_surface(*flat, np.ones((20, 20, 20), bool))
    assert len(empty.points) == 0
    assert agreement(empty, seen(sphere(0.3))) == Agreement(1.0, 0.0)
    buried = visible_surface(*box((0.1, 0.1, 0.1)), np.zeros((160, 160, 160), bool))
    assert len(buried.points) == 0


def test_what_lies_outside_of_the_cube_is_seen() -> None:
    far = moved(sphere(0.2), (2.0, 0.0, 0.0))
    assert len(seen(far).points) == 2048
