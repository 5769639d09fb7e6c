"""Between linear light, which everything computes in, and sRGB, which picture files hold (IEC 61966-2-1)."""

import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray


def decode_table() -> Float32[ndarray, "256"]:
    """Linear intensity 0..1 of each sRGB code 0..255."""
    code = np.arange(256) / 255
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4).astype(np.float32)


def encode(linear: Float32[ndarray, "*N"]) -> UInt8[ndarray, "*N"]:
    """The nearest sRGB code of linear intensities, which are clipped to 0..1; not-a-number becomes 0."""
    x = np.clip(np.nan_to_num(np.asarray(linear, np.float32)), 0.0, 1.0)
    code = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** np.float32(1 / 2.4) - 0.055)
    return (code * 255 + 0.5).astype(np.uint8)
