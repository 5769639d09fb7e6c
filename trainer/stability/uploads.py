"""Pictures as somebody would send them: stored in a file, and prepared as the service and a training prepare files."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int, UInt8
from numpy import ndarray

from imaging.errors import BackgroundError
from imaging.framing import frame_of
from imaging.preparation import prepare
from imaging.srgb import encode
from trainer.config import SceneConfig
from trainer.data.decoding import MOST_PIXELS
from trainer.data.png import encode_png

_ENLARGED = 4
"""Pixels of a file in the side of one that the model sees: whoever sends a picture has more of them."""


class Upload(NamedTuple):
    """What is left of N pictures once they are prepared."""

    codes: UInt8[ndarray, "M 3 H W"]
    """As the model sees them."""
    numbers: Int[ndarray, "M"]
    """Which of the N they are; of the others the object cannot be told from what is around it."""
    fitted: Bool[ndarray, "M"]
    """Whether the object was cut out and brought into the frame; else the picture looked like a rendering in it."""


def upload(codes: UInt8[ndarray, "N 3 H W"], scene: SceneConfig, keep_framed: bool = True) -> Upload:
    """Pictures stored as PNG and prepared for a model of that scene.

    Those on black that look as if they were in its frame already are left as they are, if `keep_framed`.
    """
    frame = frame_of(scene.width, scene.height, scene.camera.distance, scene.camera.field_of_view_degrees)
    prepared, numbers, fitted = [], [], []
    for number, picture in enumerate(codes):
        try:
            found = prepare(_file(picture), frame, MOST_PIXELS, keep_framed)
        except BackgroundError:
            continue
        prepared.append(encode(found.picture))
        numbers.append(number)
        fitted.append(found.method != "framed")
    kept = np.stack(prepared) if prepared else codes[:0]
    return Upload(kept, np.array(numbers, np.int64), np.array(fitted, np.bool_))


def _file(picture: UInt8[ndarray, "3 H W"]) -> bytes:
    return encode_png(picture.repeat(_ENLARGED, 1).repeat(_ENLARGED, 2).transpose(1, 2, 0))
