"""One picture file, decoded, composited over black and scaled to fit."""

from pathlib import Path

import numpy as np
from jaxtyping import Float32, UInt8
from numba import njit
from numpy import ndarray
from PIL import Image, ImageOps, UnidentifiedImageError

from trainer.data.srgb import decode_table, encode

_MOST_PIXELS = 50_000_000


def decode_picture(path: Path, width: int, height: int) -> UInt8[ndarray, "3 {height} {width}"] | str:
    """The picture as sRGB codes, or a sentence on why it cannot be read."""
    try:
        with Image.open(path) as picture:
            if picture.width * picture.height > _MOST_PIXELS:
                return f"{path}: expected at most {_MOST_PIXELS:,} pixels, found {picture.width} x {picture.height}"
            if picture.mode == "RGB" and picture.size == (width, height) and "transparency" not in picture.info:
                codes = np.asarray(ImageOps.exif_transpose(picture))
                if codes.shape == (height, width, 3):
                    return np.ascontiguousarray(codes.transpose(2, 0, 1))
            linear = _linear(ImageOps.exif_transpose(picture))
    except (OSError, ValueError, SyntaxError, UnidentifiedImageError, Image.DecompressionBombError) as error:
        return f"{path} cannot be read as a picture ({error})"
    return np.ascontiguousarray(encode(scaled_to_fit(linear, width, height)).transpose(2, 0, 1))


def _linear(picture: Image.Image) -> Float32[ndarray, "H W 3"]:
    """Linear colour over black."""
    if picture.mode.startswith("I;16") or picture.mode == "I":
        # Sixteen bits of grey, which Pillow's own conversion would clip.
        grey = np.clip(np.asarray(picture, np.float32) / 257, 0, 255)
        return np.repeat(np.interp(grey, np.arange(256), decode_table()).astype(np.float32)[..., None], 3, -1)
    if picture.has_transparency_data:
        rgba = np.asarray(picture.convert("RGBA"))
        alpha = rgba[..., 3:].astype(np.float32) / 255
        premultiplied: Float32[ndarray, "H W 3"] = decode_table()[rgba[..., :3]] * alpha
        return premultiplied
    return np.take(decode_table(), np.asarray(picture.convert("RGB")))


def scaled_to_fit(linear: Float32[ndarray, "h w 3"], width: int, height: int) -> Float32[ndarray, "H W 3"]:
    """Scaled, in aspect, to the largest size that fits, and centred on black: each pixel is the mean over its area.

    Centring is exact, so that the outermost pixels of the picture may be mixed with the black around it.
    """
    scale = min(width / linear.shape[1], height / linear.shape[0])
    scaled: Float32[ndarray, "H W 3"] = _area_means(linear, width, height, scale)
    return scaled


@njit(nogil=True, cache=True)
def _area_means(linear, width, height, scale):
    scaled = np.zeros((height, width, 3), np.float32)
    total = np.empty(3)
    for row in range(height):
        low_y = max((row - height / 2) / scale + linear.shape[0] / 2, 0.0)
        high_y = min((row + 1 - height / 2) / scale + linear.shape[0] / 2, float(linear.shape[0]))
        for column in range(width):
            low_x = max((column - width / 2) / scale + linear.shape[1] / 2, 0.0)
            high_x = min((column + 1 - width / 2) / scale + linear.shape[1] / 2, float(linear.shape[1]))
            total[:] = 0.0
            for y in range(int(low_y), int(np.ceil(high_y))):
                weight_y = min(high_y, y + 1.0) - max(low_y, float(y))
                for x in range(int(low_x), int(np.ceil(high_x))):
                    weight = weight_y * (min(high_x, x + 1.0) - max(low_x, float(x)))
                    for channel in range(3):
                        total[channel] += weight * linear[y, x, channel]
            for channel in range(3):
                scaled[row, column, channel] = total[channel] * scale * scale
    return scaled
