"""The background's model: exact for what it can be, blind to an object at the border, and no friend of textures."""

import numpy as np
import pytest

from imaging.backdrop import backdrop_lightness, border_backdrop, lightness_of, linear_of, places, refined_backdrop
from imaging.errors import BackgroundError

HEIGHT, WIDTH = 60, 80
AT = places(HEIGHT, WIDTH)
Y, X = np.meshgrid(*AT, indexing="ij")
SMOOTH = {
    "one colour": np.stack([np.full_like(X, value) for value in (0.9, 0.2, 0.5)]),
    "a gradient": np.stack((0.5 + 0.3 * X, 0.6 - 0.2 * Y, 0.4 + 0.1 * X - 0.2 * Y)),
    "a vignette": np.stack([0.8 - 0.2 * (X**2 + Y**2)] * 3),
}


def test_lightness_and_back() -> None:
    linear = np.linspace(0, 1, 101, dtype=np.float32)
    lightness = lightness_of(linear)
    np.testing.assert_allclose(linear_of(lightness), linear, atol=1e-6)
    assert lightness[0] == 0
    assert lightness[-1] == pytest.approx(1)
    # Near black its slope is bounded: the three lowest sRGB codes are within the noise of each other.
    assert lightness_of(np.float32([3 / 255 / 12.92]))[0] < 0.01


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_backgrounds_are_found_exactly(name: str) -> None:
    rng = np.random.default_rng(0)
    seen = SMOOTH[name] + rng.normal(0, 0.01, (3, HEIGHT, WIDTH))
    backdrop = border_backdrop(seen.astype(np.float32))
    np.testing.assert_allclose(backdrop_lightness(backdrop, AT), SMOOTH[name], atol=0.02)
    np.testing.assert_allclose(backdrop.noise, 0.01, atol=0.002)


@pytest.mark.parametrize("side", ["left", "right", "top", "bottom"])
def test_an_object_at_one_side_is_not_the_background(side: str) -> None:
    seen = SMOOTH["a gradient"].astype(np.float32)
    at = {"left": np.s_[:, 5:55, :30], "right": np.s_[:, 5:55, -30:], "top": np.s_[:, :25, 10:70],
          "bottom": np.s_[:, -25:, 10:70]}  # fmt: skip
    seen[at[side]] = 0.1
    np.testing.assert_allclose(backdrop_lightness(border_backdrop(seen), AT), SMOOTH["a gradient"], atol=0.01)


def test_known_background_refines_the_model() -> None:
    spot = np.stack([0.5 + 0.3 * np.exp(-2 * (X**2 + Y**2))] * 3).astype(np.float32)
    known = X**2 + Y**2 > 0.2
    refined = backdrop_lightness(refined_backdrop(spot, AT, known), AT)
    rough = backdrop_lightness(border_backdrop(spot), AT)
    assert np.abs(refined - spot)[:, known].max() < 0.05
    assert np.abs(refined - spot).mean() < 0.3 * np.abs(rough - spot).mean()


def test_textures_and_many_colours_are_refused() -> None:
    rng = np.random.default_rng(1)
    texture = (0.5 + rng.normal(0, 0.05, (3, HEIGHT, WIDTH))).astype(np.float32)
    crowded = np.ones((3, HEIGHT, WIDTH), np.float32)
    crowded[:, 20:40, :30], crowded[:, 20:40, 50:], crowded[:, :20, 27:54], crowded[:, 40:, 27:54] = 0.1, 0.3, 0.5, 0.7
    # A corner that takes a third of the border, the rest without any noise.
    corner = np.ones((3, HEIGHT, WIDTH), np.float32)
    corner[:, :45, :50] = 0.2
    for seen in (texture, crowded, corner):
        with pytest.raises(BackgroundError, match="expected a plain background, found many colours or a texture"):
            border_backdrop(seen)


def test_no_background_is_none() -> None:
    with pytest.raises(BackgroundError, match="found none that is connected with the border"):
        refined_backdrop(np.zeros((3, HEIGHT, WIDTH), np.float32), AT, np.zeros((HEIGHT, WIDTH), bool))
