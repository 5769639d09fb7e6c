"""sRGB codes and linear light: the standard's formulas, written out."""

import numpy as np
import pytest

from imaging.srgb import decode_table, encode


def linear(value: float) -> float:
    """IEC 61966-2-1."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def nonlinear(value: float) -> float:
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


@pytest.mark.parametrize("codes", [256, 65536])
def test_codes_are_decoded_by_the_standard(codes: int) -> None:
    expected = [linear(code / (codes - 1)) for code in range(0, codes, codes // 256)]
    np.testing.assert_allclose(decode_table(codes)[:: codes // 256], expected, rtol=1e-6)


def test_codes_survive_the_way_to_linear_and_back() -> None:
    np.testing.assert_array_equal(encode(decode_table()), np.arange(256))


def test_intensities_get_the_nearest_code() -> None:
    intensities = np.concatenate((np.linspace(0, 1, 4001), np.linspace(0, 0.02, 4001))).astype(np.float32)
    exact = np.array([255 * nonlinear(float(value)) for value in intensities])
    # Between two codes either is as near, to the last bit of a float32.
    assert np.abs(encode(intensities) - exact).max() <= 0.5 + 1e-4


def test_what_is_out_of_range_is_clipped() -> None:
    strange = np.array([[-1.0, 0.0, 1.0], [7.0, np.nan, np.inf]], np.float32)
    np.testing.assert_array_equal(encode(strange), [[0, 0, 255], [255, 0, 255]])
