"""Each damage does what it says, and as much of it."""

import numpy as np
import pytest

from imaging.srgb import decode_table
from trainer.stability import damages
from trainer.stability.damages import GREY, Damage, box_of

# A square of one colour, large enough to be measured.
HEIGHT, WIDTH = 60, 80
COLOUR = (200, 120, 60)
TOP, BOTTOM, LEFT, RIGHT = 20, 40, 30, 50


@pytest.fixture
def codes() -> np.ndarray:
    pictures = np.zeros((16, 3, HEIGHT, WIDTH), np.uint8)
    pictures[:, :, TOP:BOTTOM, LEFT:RIGHT] = np.array(COLOUR)[:, None, None]
    return pictures


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.mark.parametrize(
    ("damage", "none"),
    [
        (damages.noise, 0.0),
        (damages.blur, 0.0),
        (damages.cut, 0.0),
        (damages.shift, 0.0),
        (damages.scale, 1.0),
        (damages.occlusion, 0.0),
        (damages.brightness, 1.0),
        (damages.white_balance, 1.0),
    ],
)
def test_no_damage_changes_nothing(codes: np.ndarray, damage: Damage, none: float) -> None:
    before = codes.copy()
    assert np.array_equal(damage(codes, none, rng()), codes)
    damage(codes, none + 0.3, rng())
    assert np.array_equal(codes, before)


def test_noise_has_its_deviation(codes: np.ndarray) -> None:
    middle = np.full_like(codes, 128)
    assert damages.noise(middle, 16, rng()).astype(float).std() == pytest.approx(16, rel=0.01)


def test_blur_keeps_the_light_and_widens_by_its_deviation(codes: np.ndarray) -> None:
    table = decode_table()
    blurred = table[damages.blur(codes, 0.05, rng())[0, 0]]
    sharp = table[codes[0, 0]]
    assert blurred.sum() == pytest.approx(sharp.sum(), rel=0.01)
    rows = np.arange(HEIGHT)

    def variance(picture: np.ndarray) -> float:
        profile = picture.sum(1) / picture.sum()
        return float((profile * rows**2).sum() - (profile * rows).sum() ** 2)

    assert variance(blurred) - variance(sharp) == pytest.approx((0.05 * HEIGHT) ** 2, rel=0.05)


def test_jpeg_is_worse_the_lower_its_quality(codes: np.ndarray) -> None:
    errors = [np.abs(damages.jpeg(codes, quality, rng())[0] - codes[0].astype(float)).mean() for quality in (95, 20, 2)]
    assert 0 < errors[0] < errors[1] < errors[2]


def test_a_cut_takes_its_part_of_the_object_from_all_sides_in_turn(codes: np.ndarray) -> None:
    cut = damages.cut(codes, 0.25, rng())
    assert all((picture > 0).sum() == 0.75 * (codes[0] > 0).sum() for picture in cut)
    boxes = {box_of(picture) for picture in cut}
    assert boxes == {
        (TOP + 5, BOTTOM, LEFT, RIGHT),
        (TOP, BOTTOM - 5, LEFT, RIGHT),
        (TOP, BOTTOM, LEFT + 5, RIGHT),
        (TOP, BOTTOM, LEFT, RIGHT - 5),
    }


def test_a_bar_hides_its_part_of_the_object(codes: np.ndarray) -> None:
    hidden = damages.occlusion(codes, 0.25, rng())
    assert all((picture == GREY).all(0).sum() == 5 * HEIGHT for picture in hidden)
    assert all(picture[0, TOP:BOTTOM, LEFT:RIGHT].tolist().count(GREY) == 0 for picture in codes)
    assert all((picture[0] == COLOUR[0]).sum() == 15 * (BOTTOM - TOP) for picture in hidden)


@pytest.mark.parametrize("severity", [0.05, 0.1])
def test_a_shift_moves_by_its_part_of_the_height(codes: np.ndarray, severity: float) -> None:
    light = decode_table()[damages.shift(codes, severity, rng())][:, 0]
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    centres = np.stack([(light * axis).sum((1, 2)) / light.sum((1, 2)) for axis in (x, y)], 1)
    away = centres - ((LEFT + RIGHT) / 2, (TOP + BOTTOM) / 2)
    assert np.linalg.norm(away, axis=1) == pytest.approx(severity * HEIGHT, abs=0.05)
    assert np.linalg.norm(away.mean(0)) < 0.5 * severity * HEIGHT


@pytest.mark.parametrize("factor", [0.5, 1.5])
def test_a_scale_changes_the_area_by_its_square(codes: np.ndarray, factor: float) -> None:
    table = decode_table()
    before, after = (table[part].sum() for part in (codes[:, 0], damages.scale(codes, factor, rng())[:, 0]))
    assert after / before == pytest.approx(factor**2, rel=0.02)


def test_light_is_scaled_where_it_is_linear(codes: np.ndarray) -> None:
    table = decode_table()
    inside = (0, slice(None), 30, 40)
    darker = table[damages.brightness(codes, 0.5, rng())[inside]]
    assert darker == pytest.approx(0.5 * table[list(COLOUR)], rel=0.03)
    warmer = table[damages.white_balance(codes, 1.25, rng())[inside]]
    assert warmer == pytest.approx(table[list(COLOUR)] * (1.25, 1, 0.8), rel=0.03)


def test_an_empty_picture_has_the_whole_as_its_box() -> None:
    assert box_of(np.zeros((3, 4, 5), np.uint8)) == (0, 4, 0, 5)
