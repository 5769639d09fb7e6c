"""A turntable: shapes that turn before the camera, side by side, as one animated picture."""

import io
import math
from dataclasses import replace

import numpy as np
import torch
from jaxtyping import Float, Int64, UInt8
from numpy import ndarray
from PIL import Image
from torch import Tensor

from imaging.srgb import encode
from trainer.config import SceneConfig
from trainer.evaluation.gallery import render

FRAMES = 48
"""Pictures of a whole turn."""
FRAME_MS = 80

# Pixels: the longer side of one shape's picture, and what that of all of them together keeps to.
_LARGEST_TILE, _LARGEST = 256, 1024
_QUALITY = 85


def turntable(
    faces: Int64[Tensor, "F 3"],
    scene: SceneConfig,
    moments: Float[Tensor, "T N V 3"],
    azimuth: float = 0.0,
) -> bytes:
    """An animated WebP of N shapes, a frame for each of T moments, which begins again at its end.

    The shapes begin at `azimuth` radians and turn towards larger ones, once in FRAMES moments; the camera and the
    scene's lights stand still. Rows of shapes fill a picture of the scene's aspect, at most 1024 pixels long.
    """
    count = moments.shape[1]
    columns = math.ceil(math.sqrt(count))
    tile = min(_LARGEST_TILE, _LARGEST // columns) / max(scene.width, scene.height)
    stage = replace(scene, width=max(1, round(tile * scene.width)), height=max(1, round(tile * scene.height)))
    frames = []
    for number, vertices in enumerate(moments):
        turned = torch.full((count,), azimuth + number * 2 * math.pi / FRAMES)
        frames.append(Image.fromarray(_in_rows(render(faces, stage, vertices, turned), columns)))
    buffer = io.BytesIO()
    frames[0].save(buffer, "WEBP", save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0, quality=_QUALITY)
    return buffer.getvalue()


def _in_rows(pictures: Float[Tensor, "N 3 H W"], columns: int) -> UInt8[ndarray, "rows columns 3"]:
    """sRGB codes of linear pictures, from left to right and from top to bottom; places that are left over are black."""
    count, channels, height, width = pictures.shape
    rows = math.ceil(count / columns)
    tiles = np.zeros((rows * columns, channels, height, width), np.float32)
    tiles[:count] = pictures.clamp(0, 1).numpy()
    joined = tiles.reshape(rows, columns, channels, height, width).transpose(0, 3, 1, 4, 2)
    return encode(joined.reshape(rows * height, columns * width, channels))
