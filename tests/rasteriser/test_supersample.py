"""The picture maker against closed forms: it is the truth for everything else."""

import numpy as np
import pytest
from numpy import ndarray

from rasteriser.projection import NEAR
from rasteriser.supersample import render

WHITE = np.ones((1, 3, 3))


def on_screen(points: ndarray, focal_length: float, width: int, height: int, depth: float = 2.0) -> ndarray:
    """Camera coordinates of points (x, y in pixels) at one depth."""
    x, y = points[..., 0] - width / 2, height / 2 - points[..., 1]
    return np.stack((x * depth / focal_length, y * depth / focal_length, np.full(x.shape, depth)), -1)


def quad(left: float, top: float, right: float, bottom: float) -> ndarray:
    return np.array([[(left, top), (left, bottom), (right, bottom)], [(left, top), (right, bottom), (right, top)]])


@pytest.mark.parametrize("supersampling", [1, 2, 4, 5])
def test_a_square_on_pixel_borders_is_exact(supersampling: int) -> None:
    corners = on_screen(quad(3, 2, 9, 5), 16.0, 16, 12)
    colours = np.broadcast_to(np.array([0.25, 0.5, 1.0]), (2, 3, 3))
    picture = render(corners, colours, 16.0, 16, 12, supersampling)
    expected = np.zeros((12, 16), np.float32)
    expected[2:5, 3:9] = 1.0
    np.testing.assert_array_equal(picture.alpha, expected)
    np.testing.assert_allclose(picture.colour, expected[..., None] * (0.25, 0.5, 1.0), atol=1e-6)


def test_partly_covered_pixels_hold_their_covered_share() -> None:
    corners = on_screen(quad(3.25, 2.5, 8.75, 5), 16.0, 16, 12)
    picture = render(corners, np.ones((2, 3, 1)), 16.0, 16, 12, 4)
    columns, rows = np.zeros(16), np.zeros(12)
    columns[3:9], rows[2:5] = (0.75, 1, 1, 1, 1, 0.75), (0.5, 1, 1)
    np.testing.assert_allclose(picture.alpha, np.outer(rows, columns), atol=1e-6)


def test_faces_that_share_edges_share_every_sample_out_exactly() -> None:
    rng = np.random.default_rng(1)
    # A fan around an inner point, whose corners lie exactly on samples: the hardest case of the fill rule.
    rim = np.array([(2, 2), (6.5, 2), (13, 2), (13, 6.5), (13, 10), (7.5, 10), (2, 10), (2, 5.5)], float)
    hubs = np.concatenate((rng.uniform((3, 3), (12, 9), (30, 2)), np.array([(6.5, 5.5), (7.125, 6.875)])))
    for hub in hubs:
        fan = np.stack([np.stack((hub, a, b)) for a, b in zip(rim, np.roll(rim, -1, 0), strict=True)])
        corners = on_screen(fan, 16.0, 16, 12)
        parts = [render(corners[i : i + 1], WHITE, 16.0, 16, 12).alpha for i in range(len(fan))]
        whole = np.zeros((12, 16))
        whole[2:10, 2:13] = 1.0
        np.testing.assert_array_equal(np.sum(parts, axis=0), whole)


def test_coverage_converges_to_the_area() -> None:
    triangle = np.array([[(2.3, 1.7), (13.9, 4.2), (5.1, 10.8)]])
    (a, b, c) = triangle[0]
    area = abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) / 2
    errors = [
        abs(render(on_screen(triangle, 16.0, 16, 12), WHITE, 16.0, 16, 12, k).alpha.sum() - area) for k in (4, 64)
    ]
    assert errors[0] < 0.5
    assert errors[1] < 0.005


def test_colours_are_linear_on_the_surface_not_on_the_screen() -> None:
    # A floor that recedes: colour is the depth itself, so every pixel must show the depth at which its ray meets it.
    floor = np.array([(-9, -1, 1), (9, -1, 1), (9, -1, 12), (-9, -1, 12)], float)[[[0, 1, 2], [0, 2, 3]]]
    width, height, focal = 16, 12, 12.0
    picture = render(floor, floor[..., 2:], focal, width, height, 1)
    rows = np.arange(height) + 0.5
    with np.errstate(divide="ignore"):
        depth = -focal / (height / 2 - rows)
    inside = (depth > 1) & (depth < 12)
    assert inside.sum() >= 4
    np.testing.assert_allclose(picture.colour[inside][:, 4:12, 0], np.repeat(depth[inside][:, None], 8, 1), rtol=1e-5)


def test_the_nearer_of_two_planes_that_cross_is_seen() -> None:
    width, height, focal = 24, 18, 20.0
    rng = np.random.default_rng(2)
    corners = np.array([
        [(-9, -9, 2), (9, -9, 6), (0, 18, 4)],
        [(-9, -9, 6), (9, -9, 2), (0, 18, 4)],
    ], float)  # fmt: skip
    colours = np.repeat(np.eye(2)[:, None], 3, axis=1)
    picture = render(corners, colours, focal, width, height, 1)
    # Both hold 2 .. 6 linearly in x and meet at x = 0: the first is nearer on the left.
    np.testing.assert_array_equal(picture.colour[..., 0], picture.alpha * (np.arange(width) < width / 2))
    order = rng.permutation(2)
    np.testing.assert_array_equal(
        picture.colour, render(corners[order], colours[order], focal, width, height, 1).colour
    )


def test_orientation_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    corners = rng.uniform((-1, -1, 2), (1, 1, 3), (20, 3, 3))
    colours = rng.uniform(size=(20, 3, 3))
    there, back = render(corners, colours, 12.0, 16, 12), render(corners[:, ::-1], colours[:, ::-1], 12.0, 16, 12)
    np.testing.assert_array_equal(there.alpha, back.alpha)
    np.testing.assert_allclose(there.colour, back.colour, atol=1e-5)


@pytest.mark.parametrize("turn", [0, 1, 2])
def test_faces_are_cut_at_the_near_plane(turn: int) -> None:
    """The part of a face in front of the camera is drawn as if the rest were not there."""
    face = np.roll(np.array([(0.0, -1.0, 6.0), (4.0, -1.0, -1.0), (-4.0, -1.0, -1.0)]), turn, axis=0)[None]
    picture = render(face, face[..., 2:], 12.0, 16, 12, 2)
    behind = face[0, :, 2] < 0
    tip = face[0][~behind][0]
    ends = [tip + (NEAR - 6.0) / (-1.0 - 6.0) * (point - tip) for point in face[0][behind]]
    cut = np.stack((tip, *ends))[None]
    expected = render(cut, cut[..., 2:], 12.0, 16, 12, 2)
    assert expected.alpha.sum() > 5
    np.testing.assert_array_equal(picture.alpha, expected.alpha)
    np.testing.assert_allclose(picture.colour, expected.colour, rtol=1e-4, atol=1e-5)


def test_what_cannot_be_seen_draws_nothing() -> None:
    triangle = np.array([(-1.0, -1.0, 2.0), (1.0, -1.0, 2.0), (0.0, 1.0, 2.0)])
    collapsed, hidden = triangle.copy(), triangle * (1, 1, -1)
    collapsed[2] = (collapsed[0] + collapsed[1]) / 2
    broken, aside = triangle.copy(), np.add(triangle, (50, 0, 0))
    broken[1, 0] = np.nan
    for face in (collapsed, hidden, broken, aside, np.repeat(triangle[:1], 3, 0), np.add(triangle, (np.inf, 0, 0))):
        picture = render(face[None], WHITE, 12.0, 16, 12)
        assert not picture.alpha.any()
        assert not picture.colour.any()
    assert render(np.empty((0, 3, 3)), np.empty((0, 3, 3)), 12.0, 16, 12).colour.shape == (12, 16, 3)


def test_coordinates_far_outside_do_no_harm() -> None:
    huge = np.array([[(-1e9, -1e9, 2.0), (1e9, -1e9, 2.0), (0.0, 1e9, 2.0)]])
    np.testing.assert_array_equal(render(huge, WHITE, 12.0, 16, 12).alpha, np.ones((12, 16)))


@pytest.mark.parametrize(
    ("corners", "colours", "focal", "width"),
    [
        (np.ones((2, 3, 2)), np.ones((2, 3, 3)), 10.0, 8),
        (np.ones((2, 3, 3)), np.ones((3, 3, 3)), 10.0, 8),
        (np.ones((2, 3, 3)), np.ones((2, 3, 3)), 0.0, 8),
        (np.ones((2, 3, 3)), np.ones((2, 3, 3)), 10.0, 0),
    ],
)
def test_senseless_input_is_refused(corners: ndarray, colours: ndarray, focal: float, width: int) -> None:
    with pytest.raises(ValueError, match="expected"):
        render(corners, colours, focal, width, 8)


def test_backs_of_closed_meshes_are_spared_and_those_of_others_are_drawn() -> None:
    # Row 0 is on top: these corners go round counter-clockwise, as seen.
    front = on_screen(quad(3, 2, 9, 5), 16.0, 16, 12)
    back = front[:, ::-1]
    colours = np.ones((2, 3, 3))
    whole = render(front, colours, 16.0, 16, 12)
    for corners, closed in ((back, False), (front, True)):
        np.testing.assert_array_equal(render(corners, colours, 16.0, 16, 12, closed=closed).colour, whole.colour)
    assert render(back, colours, 16.0, 16, 12, closed=True).alpha.max() == 0
