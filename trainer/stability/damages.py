"""What may befall a picture on its way to the model, in degrees of severity.

Everything acts on a picture as the model sees it, in its own frame and size. Lengths are in parts of the picture's
height or of the object's bounding box, so that they mean the same at any size. What is drawn at random depends on the
generator alone and not on the severity: a picture is damaged from the same side, only more.
"""

import io
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, UInt8
from numpy import ndarray
from numpy.random import Generator
from PIL import Image
from scipy.ndimage import gaussian_filter

from imaging.scaling import area_weights
from imaging.srgb import decode_table, encode

Codes = UInt8[ndarray, "N 3 H W"]
Damage = Callable[[UInt8[ndarray, "N 3 H W"], float, Generator], UInt8[ndarray, "N 3 H W"]]
"""(sRGB codes of pictures, severity, randomness) to their codes afterwards."""

GREY = 128
"""sRGB code of the bar that hides."""


class Box(NamedTuple):
    """What an object covers of a picture: pixels from (top, left) up to, and without, (bottom, right)."""

    top: int
    bottom: int
    left: int
    right: int


def noise(codes: Codes, severity: float, rng: Generator) -> Codes:
    """Gaussian noise of so many codes' standard deviation, independent in each pixel and channel."""
    noisy = codes + severity * rng.standard_normal(codes.shape, np.float32)
    return np.asarray(np.rint(noisy).clip(0, 255), np.uint8)


def blur(codes: Codes, severity: float, rng: Generator) -> Codes:
    """A Gaussian whose standard deviation is that part of the picture's height, in linear light."""
    sigma = severity * codes.shape[2]
    blurred: Float32[ndarray, "N 3 H W"] = gaussian_filter(_linear(codes), (0, 0, sigma, sigma), mode="constant")
    return encode(blurred)


def jpeg(codes: Codes, severity: float, rng: Generator) -> Codes:
    """Stored as JPEG of that quality, 1 to 95, and read again."""

    def stored(picture: UInt8[ndarray, "3 H W"]) -> UInt8[ndarray, "3 H W"]:
        file = io.BytesIO()
        Image.fromarray(np.ascontiguousarray(picture.transpose(1, 2, 0))).save(file, "JPEG", quality=round(severity))
        with Image.open(file) as image:
            return np.array(image).transpose(2, 0, 1)

    return np.stack([stored(picture) for picture in codes])


def cut(codes: Codes, severity: float, rng: Generator) -> Codes:
    """The picture ends within the object: that part of its box, at one of four sides, is beyond the edge, and black."""
    cut_off = codes.copy()
    for picture, side in zip(cut_off, rng.integers(4, size=len(codes)), strict=True):
        box = box_of(picture)
        rows, columns = round(severity * (box.bottom - box.top)), round(severity * (box.right - box.left))
        match side:
            case 0:
                picture[:, : box.top + rows] = 0
            case 1:
                picture[:, box.bottom - rows :] = 0
            case 2:
                picture[:, :, : box.left + columns] = 0
            case _:
                picture[:, :, box.right - columns :] = 0
    return cut_off


def shift(codes: Codes, severity: float, rng: Generator) -> Codes:
    """Moved by that part of the picture's height in any direction; what leaves the picture is lost."""
    directions = rng.uniform(0, 2 * np.pi, len(codes))
    offsets = severity * codes.shape[2] * np.stack((np.cos(directions), np.sin(directions)), 1)
    return np.stack([_placed(picture, 1.0, *offset) for picture, offset in zip(codes, offsets, strict=True)])


def scale(codes: Codes, severity: float, rng: Generator) -> Codes:
    """Shown so many times as large about the picture's middle; what leaves the picture is lost."""
    return np.stack([_placed(picture, severity, 0.0, 0.0) for picture in codes])


def occlusion(codes: Codes, severity: float, rng: Generator) -> Codes:
    """An upright grey bar as high as the picture before the object, as wide as that part of the object's box."""
    hidden = codes.copy()
    for picture, place in zip(hidden, rng.uniform(size=len(codes)), strict=True):
        box = box_of(picture)
        width = round(severity * (box.right - box.left))
        left = box.left + round(place * (box.right - box.left - width))
        picture[:, :, left : left + width] = GREY
    return hidden


def brightness(codes: Codes, severity: float, rng: Generator) -> Codes:
    """So many times the light, cut off where a camera's would be."""
    return encode(_linear(codes) * np.float32(severity))


def white_balance(codes: Codes, severity: float, rng: Generator) -> Codes:
    """So many times the red light and as many times less blue: a camera set for another lamp."""
    gains = np.array([severity, 1.0, 1 / severity], np.float32)
    return encode(_linear(codes) * gains[:, None, None])


def box_of(picture: UInt8[ndarray, "3 H W"]) -> Box:
    """Around all that is not black; the whole picture where nothing is."""
    seen = np.asarray(picture.any(axis=0))
    if not seen.any():
        return Box(0, seen.shape[0], 0, seen.shape[1])
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    return Box(int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1)


def _linear(codes: Codes) -> Float32[ndarray, "N 3 H W"]:
    return np.asarray(decode_table()[codes])


def _placed(picture: UInt8[ndarray, "3 H W"], factor: float, right: float, down: float) -> UInt8[ndarray, "3 H W"]:
    """Scaled about its middle by area means in linear light, then moved by pixels."""
    _, height, width = picture.shape
    placed = np.zeros(picture.shape, np.float32)
    columns, x = area_weights(_edges(width), width / 2 - (width / 2 + right) / factor, factor, width)
    rows, y = area_weights(_edges(height), height / 2 - (height / 2 + down) / factor, factor, height)
    placed[:, y, x] = rows @ decode_table()[picture] @ columns.T
    return encode(placed)


def _edges(size: int) -> Float[ndarray, "S"]:
    return np.arange(size + 1, dtype=np.float64)
