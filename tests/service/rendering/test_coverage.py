"""The z-buffer without loops, against closed forms and against the rasteriser that draws training pictures."""

import numpy as np
import pytest

from rasteriser import supersample
from service.rendering import coverage
from service.rendering.coverage import cover
from service.rendering.picture import draw

WHITE = np.ones((4, 3))
SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def square(left: float, top: float, right: float, bottom: float, nearness: float = 0.5) -> np.ndarray:
    """Four corners on the screen, at one depth."""
    corners = ((left, top), (right, top), (right, bottom), (left, bottom))
    return np.array([(x, y, nearness) for x, y in corners])


def test_a_square_covers_just_its_pixels() -> None:
    drawn = draw(square(2, 1, 7, 4), WHITE, SQUARE, 9, 6, 1)
    expected = np.zeros((6, 9))
    expected[1:4, 2:7] = 1
    np.testing.assert_array_equal(drawn.coverage, expected)
    np.testing.assert_allclose(drawn.colour, np.broadcast_to(expected, (3, 6, 9)))


def test_half_covered_pixels_are_half_as_bright() -> None:
    drawn = draw(square(2.5, 1.25, 7, 4), WHITE, SQUARE, 9, 6, 4)
    assert drawn.coverage[2, 2] == 0.5
    assert drawn.coverage[1, 3] == 0.75
    assert drawn.coverage[1, 2] == 0.375
    assert drawn.coverage.sum() == pytest.approx(4.5 * 2.75)


def test_what_is_outside_of_the_picture_is_cut_off() -> None:
    assert cover(square(-1e6, -1e6, 1e6, 1e6), SQUARE, 5, 4).samples.tolist() == list(range(20))
    assert not len(cover(square(20, 1, 30, 4), SQUARE, 9, 6).samples)
    assert not len(cover(square(2, -9, 7, -1), SQUARE, 9, 6).samples)


def test_the_nearer_face_is_seen() -> None:
    near, far = square(2, 1, 7, 4, 0.8), square(0, 0, 9, 6, 0.4)
    faces = np.concatenate((SQUARE + 4, SQUARE))
    seen = cover(np.concatenate((near, far)), faces, 9, 6)
    shown = np.zeros(54, int)
    shown[seen.samples] = seen.faces
    expected = np.zeros((6, 9), bool)
    expected[1:4, 2:7] = True
    np.testing.assert_array_equal(shown.reshape(6, 9) >= 2, expected)


def test_colours_are_linear_on_the_surface() -> None:
    """Between depths 1 and 3, the share u of the way on the screen is u / (3 − 2u) of that on the surface."""
    screen = np.array([(0, 0, 1.0), (4, 0, 1 / 3), (4, 9, 1 / 3), (0, 9, 1.0)])
    colours = np.array([(0.0, 0, 1), (1, 0, 1), (1, 0, 1), (0, 0, 1)])
    drawn = draw(screen, colours, SQUARE, 4, 9, 1)
    way = (np.arange(4) + 0.5) / 4
    np.testing.assert_allclose(drawn.colour[0], np.tile(way / (3 - 2 * way), (9, 1)))
    np.testing.assert_allclose(drawn.colour[2], 1)


def test_faces_without_area_and_no_faces_draw_nothing() -> None:
    flat = np.array([(1.0, 1, 0.5), (5, 5, 0.5), (3, 3, 0.5)])
    assert not len(cover(flat, np.array([[0, 1, 2]]), 9, 6).samples)
    assert draw(flat, np.ones((3, 3)), np.zeros((0, 3), np.int64), 9, 6, 2).coverage.max() == 0


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("samples", [1, 3])
def test_random_meshes_look_as_training_draws_them(seed: int, samples: int) -> None:
    """Faces of all sizes that cross each other, some beyond the picture's edges, at the same samples."""
    generator = np.random.default_rng(seed)
    width, height, focal = 41, 30, 33.0
    points = generator.uniform((-1.5, -1.2, 1), (1.5, 1.2, 4), (60, 3))
    colours = generator.random((60, 3))
    faces = generator.integers(0, 60, (50, 3))
    expected = supersample.render(points[faces], colours[faces], focal, width, height, samples)
    inverse = 1 / points[:, 2]
    screen = np.stack(
        (width / 2 + focal * points[:, 0] * inverse, height / 2 - focal * points[:, 1] * inverse, inverse), -1
    )
    found = draw(screen, colours, faces, width, height, samples)
    assert 0.3 < found.coverage.mean() < 1
    np.testing.assert_array_equal(found.coverage.astype(np.float32), expected.alpha)
    # The other one compares depths in single precision, so that where faces cross a sample may fall to either.
    differing = (np.abs(found.colour.transpose(1, 2, 0) - expected.colour) > 1e-5).any(-1)
    assert differing.mean() < 0.002


def test_meshes_much_larger_than_their_picture_are_covered_a_portion_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    screen = np.concatenate((rng.normal(8, 60, (30, 2)), rng.uniform(0.2, 0.8, (30, 1))), 1)
    faces = rng.integers(0, 30, (80, 3))
    at_once = cover(screen, faces, 16, 12)
    assert len(at_once.samples) == 16 * 12
    monkeypatch.setattr(coverage, "_MOST_SAMPLES", 10)
    for portioned, whole in zip(cover(screen, faces, 16, 12), at_once, strict=True):
        np.testing.assert_array_equal(portioned, whole)
