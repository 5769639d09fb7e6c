"""One picture file, decoded, composited over black and scaled to fit."""

from functools import lru_cache
from pathlib import Path

import numpy as np
from jaxtyping import Float32, UInt8
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
    """Scaled, in aspect, to the largest size that fits, each pixel the mean over its area; centred on black."""
    rows, columns, _ = linear.shape
    scale = min(width / columns, height / rows)
    inner_width, inner_height = max(1, round(columns * scale)), max(1, round(rows * scale))
    across, down = _area_weights(columns, inner_width), _area_weights(rows, inner_height)
    reduced = np.einsum("Hh,hwc->Hwc", down, linear, optimize=True)
    reduced = np.einsum("Ww,Hwc->HWc", across, reduced, optimize=True)
    canvas = np.zeros((height, width, 3), np.float32)
    top, left = (height - inner_height) // 2, (width - inner_width) // 2
    canvas[top : top + inner_height, left : left + inner_width] = reduced
    return canvas


@lru_cache(maxsize=64)
def _area_weights(size: int, target: int) -> Float32[ndarray, "target size"]:
    """How much of each source pixel lies under each target pixel; rows sum to one."""
    edges = np.linspace(0, size, target + 1)[:, None]
    pixels = np.arange(size)[None]
    overlap = np.minimum(edges[1:], pixels + 1) - np.maximum(edges[:-1], pixels)
    weights: Float32[ndarray, "target size"] = (np.maximum(overlap, 0.0) * target / size).astype(np.float32)
    return weights
