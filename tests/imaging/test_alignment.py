"""Pictures are brought to where drawings have their light."""

import numpy as np
import pytest

from imaging.alignment import aligned
from imaging.scaling import block_means


def blob(width: int, height: int, x: float, y: float, size: float) -> np.ndarray:
    """Three colours of a lopsided bright spot; place and size in picture heights."""
    across, down = (np.arange(width) + 0.5) / height - x, (np.arange(height) + 0.5)[:, None] / height - y
    light = np.exp(-0.5 * ((across / size) ** 2 + (down / size) ** 2)) * (1 + 0.5 * np.tanh(across / size))
    return (light * np.array([1.0, 0.5, 0.25])[:, None, None]).astype(np.float32)


@pytest.mark.parametrize(("x", "y", "size"), [(0.6, 0.5, 0.1), (0.75, 0.4, 0.12), (0.6, 0.55, 0.08), (0.7, 0.5, 0.1)])
def test_a_picture_comes_to_lie_where_the_drawing_is(x: float, y: float, size: float) -> None:
    drawing, picture = blob(64, 48, 0.66, 0.5, 0.1), blob(64, 48, x, y, size)
    left = np.square(aligned(picture, drawing) - drawing).sum() / np.square(drawing).sum()
    apart = np.square(picture - drawing).sum() / np.square(drawing).sum()
    assert left < 0.003
    assert left < 0.1 * apart


def test_a_drawing_may_have_larger_pixels() -> None:
    drawing, picture = blob(64, 48, 0.66, 0.5, 0.1), blob(64, 48, 0.75, 0.4, 0.12)
    fine, coarse = aligned(picture, drawing), aligned(picture, block_means(drawing, 4))
    assert np.abs(fine - coarse).max() < 0.02


def test_what_lies_there_already_stays() -> None:
    picture = blob(64, 48, 0.66, 0.5, 0.1)
    np.testing.assert_allclose(aligned(picture, picture), picture, atol=1e-5)


def test_nothing_is_scaled_beyond_reason_nor_to_nothing() -> None:
    picture, black = blob(64, 48, 0.66, 0.5, 0.05), np.zeros((3, 48, 64), np.float32)
    large = aligned(picture, blob(64, 48, 0.66, 0.5, 0.3))
    assert large.sum() == pytest.approx(4 * picture.sum(), rel=0.01)
    assert aligned(picture, black) is picture
    assert not aligned(black, picture).any()
