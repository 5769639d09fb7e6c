"""Between linear light, which everything computes in, and sRGB, which picture files hold (IEC 61966-2-1)."""

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray


@cache
def decode_table(codes: int = 256) -> NDArray[np.float32]:
    """Linear intensity 0..1 of each sRGB code 0 … `codes` - 1; one array for all who ask, not to be written to."""
    return _linear(np.arange(codes) / (codes - 1)).astype(np.float32)


def encode(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """The nearest sRGB code of linear intensities of any shape, which are clipped to 0..1; not-a-number becomes 0."""
    x = np.clip(np.nan_to_num(np.asarray(linear, np.float32)), 0.0, 1.0)
    highest = np.take(HIGHEST_CODE, (x * np.float32(STEPS)).astype(np.intp))
    return highest - (x < np.take(FIRST_INTENSITY, highest))


def _linear(code: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


STEPS: Final = 16384
"""Steps of 0..1 so fine that each holds the border between two codes at the most: a comparison then decides."""
FIRST_INTENSITY: Final = np.append(0.0, _linear((np.arange(1, 256) - 0.5) / 255)).astype(np.float32)
"""The least linear intensity of each code."""
HIGHEST_CODE: Final = (np.searchsorted(FIRST_INTENSITY, (np.arange(STEPS + 1) + 1) / STEPS, "left") - 1).astype(
    np.uint8
)
"""The highest code in each step."""
