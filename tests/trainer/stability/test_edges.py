"""Errors of the rasteriser: known scenes, and the comparison notices what is not antialiased."""

import math
from typing import Any

import numpy as np
import pytest

from rasteriser.pictures import Gradients
from trainer.stability import edges
from trainer.stability.edges import CREASES, Kind, edge_figures, gradient_errors, make_scene, truth


def test_a_plate_seen_from_the_front_covers_its_area() -> None:
    scene = make_scene("grazing", 0, np.random.default_rng(0))
    front = 60**2 * 0.9 * 0.6 / (2.5 - 0.02) ** 2
    assert truth(scene).alpha.sum() == pytest.approx(front, rel=0.03)
    side = make_scene("grazing", 90, np.random.default_rng(0))
    edge_on = 60**2 * 0.9 * 0.04 / (2.5 - 0.3) ** 2
    assert truth(side).alpha.sum() == pytest.approx(edge_on, rel=0.03)


def test_boxes_share_their_centre_and_differ_by_the_angle() -> None:
    scene = make_scene("interpenetration", 20, np.random.default_rng(1))
    depth = 1 / scene.screen[:, 2]
    x, y = (scene.screen[:, 0] - 24) * depth / 60, (18 - scene.screen[:, 1]) * depth / 60
    points = np.stack((x, y, 2.5 - depth), 1)
    first, second = points[:8] - points[:8].mean(0), points[8:] - points[8:].mean(0)
    assert points[:8].mean(0) == pytest.approx(points[8:].mean(0), abs=1e-5)
    turn = np.linalg.lstsq(first, second, rcond=None)[0]
    assert math.degrees(math.acos((np.trace(turn) - 1) / 2)) == pytest.approx(20, abs=0.1)


def test_all_borders_are_truer_than_contours_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    angles: dict[Kind, tuple[float, ...]] = {"grazing": (75,), "interpenetration": (20,)}
    monkeypatch.setattr(edges, "ANGLES_DEGREES", angles)
    monkeypatch.setattr(edges, "_SUPERSAMPLING", 24)
    found = edge_figures(1)
    for kind, (angle,) in angles.items():
        (point,) = found[kind]["points"]
        assert (point["angle_degrees"], point["scenes"]) == (angle, 1)
        assert point["picture_error_exact"] < 0.6 * point["picture_error_contours"]
        assert point["gradient_error_exact"] < min(0.1, point["gradient_error_contours"])


def test_the_error_of_a_gradient_is_relative(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edges, "_SUPERSAMPLING", 16)
    scene, drawn = make_scene("grazing", 45, np.random.default_rng(0)), edges.pictures.draw_gradient

    def doubled(*arguments: Any) -> Gradients:
        found = drawn(*arguments)
        return found._replace(screen=2 * found.screen)

    monkeypatch.setattr(edges.pictures, "draw_gradient", doubled)
    errors = gradient_errors(scene, 0, 0)
    assert list(errors) == list(CREASES)
    assert errors["exact"] == pytest.approx(1, abs=0.1)
