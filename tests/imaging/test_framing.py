"""Where objects stand: the rule against renderings of procedural shapes, and pictures brought there."""

import math

import numpy as np
import pytest

from imaging.decoding import Picture
from imaging.framing import Box, Frame, box_around, fitted, frame_of, framed, looks_framed
from tests.imaging.photographs import shape
from trainer.config import CameraConfig, SceneConfig
from trainer.data.picture import draw

FRAME = frame_of(128, 96, 2.0, 30.0)


def picture_of(colour: np.ndarray, factor: int = 1) -> Picture:
    height, width = colour.shape[1:]
    columns, rows = (np.arange(count + 1.0) * factor for count in (width, height))
    return Picture(colour.astype(np.float32), None, columns, rows, factor)


@pytest.mark.parametrize("scene", [SceneConfig(), SceneConfig(64, 64, CameraConfig(distance=3.0))])
def test_renderings_keep_to_the_rule(scene: SceneConfig) -> None:
    """In the mean over shapes and azimuths to a few hundredths, each within what still looks framed."""
    camera = scene.camera
    frame = frame_of(scene.width, scene.height, camera.distance, camera.field_of_view_degrees)
    sizes, drops = [], []
    for seed in range(24):
        for category in ("car", "chair"):
            azimuth = 2 * math.pi * (seed * 0.618 % 1)
            picture = picture_of(draw(shape(category, seed), azimuth, 0.0, scene, 2)[0].transpose(2, 0, 1))
            box = box_around(picture, (picture.colour.max(0) > 0.003).astype(np.float32))
            sizes.append(box.diagonal / frame.diagonal)
            drops.append((box.centre[1] - scene.height / 2 - frame.drop) / frame.diagonal)
            assert looks_framed(picture, frame)
    assert np.exp(np.log(sizes).mean()) == pytest.approx(1.04, abs=0.06)
    assert np.log(sizes).std() < 0.15
    assert np.mean(drops) == pytest.approx(0.01, abs=0.02)


def test_a_box_is_brought_where_the_rule_says() -> None:
    colour = np.zeros((3, 200, 300))
    colour[:, 40:80, 100:180] = 0.5
    frame = Frame(128, 96, 60.0, 3.0)
    placed = framed(picture_of(colour), Box(100, 40, 180, 80), frame)
    assert placed.shape == (3, 96, 128)
    scale = 60 / math.hypot(80, 40)
    rows, columns = np.nonzero(placed[1] > 0.25)
    assert columns.min() == pytest.approx(64 - 40 * scale, abs=1)
    assert columns.max() + 1 == pytest.approx(64 + 40 * scale, abs=1)
    assert (rows.min() + rows.max() + 1) / 2 == pytest.approx(48 + 3, abs=0.5)
    assert placed[0].sum() == pytest.approx(0.5 * 80 * 40 * scale**2, rel=1e-4)


def test_a_box_ends_where_its_last_pixels_do() -> None:
    opacity = np.zeros((6, 8), np.float32)
    opacity[2:4, 2:6] = 1
    opacity[1, 3], opacity[3, 6], opacity[4:, 4] = 0.25, 0.6, (0.75, 0.1)
    opacity[2:4, 2] = 0.8
    picture = picture_of(np.zeros((3, 6, 8)), factor=10)
    assert box_around(picture, opacity) == pytest.approx((22, 17.5, 66, 48.5))


def test_reduced_pictures_are_framed_like_whole_ones() -> None:
    rows, columns = np.mgrid[0:203, 0:305]
    colour = np.stack((rows / 203, columns / 305, (rows + columns) % 2)) * (np.hypot(rows - 100, columns - 160) < 60)
    padded = np.pad(colour, ((0, 0), (0, 1), (0, 3)))
    counts = np.pad(np.ones((203, 305)), ((0, 1), (0, 3)))
    means, shares = (plane.reshape(-1, 51, 4, 77, 4).sum((2, 4)) for plane in (padded, counts))
    edges = np.minimum(np.arange(78) * 4.0, 305), np.minimum(np.arange(52) * 4.0, 203)
    reduced = Picture((means / shares).astype(np.float32), None, *edges, 4)
    box = Box(100, 40, 220, 160)
    difference = np.abs(framed(reduced, box, FRAME) - framed(picture_of(colour), box, FRAME))
    assert difference.mean() < 0.005
    assert np.median(difference[:, 40:60, 55:75]) < 0.01


@pytest.mark.parametrize(
    ("size", "target"), [((7, 5), (3, 2)), ((9, 12), (4, 4)), ((3, 2), (8, 6)), ((10, 10), (128, 96))]
)
def test_fitting_keeps_the_light_and_where_it_comes_from(size: tuple[int, int], target: tuple[int, int]) -> None:
    source = np.random.default_rng(1).uniform(size=(3, size[1], size[0]))
    frame = Frame(*target, 1.0, 0.0)
    scale = min(target[0] / size[0], target[1] / size[1])
    placed = fitted(picture_of(source), frame)
    turned = fitted(picture_of(source[:, ::-1, ::-1]), frame)
    np.testing.assert_allclose(turned, placed[:, ::-1, ::-1], atol=1e-6)
    assert placed.mean() <= source.mean()
    if scale < 1:
        np.testing.assert_allclose(placed.sum((1, 2)), source.sum((1, 2)) * scale**2, rtol=1e-4)


def test_another_aspect_is_padded_evenly_with_black() -> None:
    expected = np.zeros((8, 8))
    expected[:, 2:6] = 1
    np.testing.assert_allclose(fitted(picture_of(np.ones((3, 16, 8))), Frame(8, 8, 1.0, 0.0))[0], expected, atol=1e-6)
    np.testing.assert_allclose(fitted(picture_of(np.ones((3, 8, 16))), Frame(8, 8, 1.0, 0.0))[2], expected.T, atol=1e-6)


def test_what_cannot_be_a_rendering_does_not_look_framed() -> None:
    rendering = np.zeros((3, 96, 128))
    rendering[:, 30:72, 30:98] = 0.5
    assert looks_framed(picture_of(rendering), FRAME)
    assert looks_framed(picture_of(rendering, factor=4), FRAME)
    others = {
        "another aspect": rendering[:, :, 8:-8],
        "light at the border": np.maximum(rendering, np.indices((96, 128))[1] < 1),
        "nothing": np.zeros_like(rendering),
        "a small object": rendering * (np.abs(np.indices((96, 128)) - 50).max(0) < 15),
        "an object at the side": np.roll(rendering, 25, axis=2),
    }
    assert not {name for name, colour in others.items() if looks_framed(picture_of(colour), FRAME)}


def test_a_frame_that_zooms_in_shows_the_middle_of_what_is_framed_already() -> None:
    rendering = np.random.default_rng(0).random((3, 96, 128))
    middle = fitted(picture_of(rendering), frame_of(64, 48, 2.0, 15.3, zoom=2.0))
    np.testing.assert_allclose(middle, rendering[:, 24:72, 32:96], atol=1e-6)
    # Half as large as that: each pixel is the mean of four.
    small = fitted(picture_of(rendering), frame_of(32, 24, 2.0, 15.3, zoom=2.0))
    np.testing.assert_allclose(small, middle.reshape(3, 24, 2, 32, 2).mean((2, 4)), atol=1e-6)


def test_what_looks_framed_is_what_a_frame_zooms_into() -> None:
    half_as_wide = math.degrees(2 * math.atan(math.tan(math.radians(15)) / 2))
    frame = frame_of(128, 96, 2.0, half_as_wide, zoom=2.0)
    assert frame.diagonal == pytest.approx(2 * FRAME.diagonal)
    rendering = np.zeros((3, 96, 128))
    rendering[:, 30:72, 30:98] = 0.5
    assert looks_framed(picture_of(rendering), frame)
    assert not looks_framed(picture_of(rendering), frame._replace(zoom=1.0))
