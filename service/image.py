"""From an uploaded file to the picture that the encoder expects: decode, turn upright, linear light, black, fit."""

import io
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from service.errors import ImageError, ImageFormatError, ImageTooLargeError

FORMATS: Final = ("PNG", "JPEG", "WEBP", "BMP", "GIF")
_ADVICE: Final = "send a PNG, JPEG, WebP, BMP or GIF file"

_EXIF_ORIENTATION: Final = 0x0112
_UPRIGHT: Final = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}


def _srgb_to_linear(encoded: NDArray[np.float64]) -> NDArray[np.float32]:
    """Linear light in 0..1 from sRGB in 0..1 (IEC 61966-2-1)."""
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


_LINEAR_8: Final = _srgb_to_linear(np.arange(256) / 255)
_LINEAR_16: Final = _srgb_to_linear(np.arange(65536) / 65535)


def read_picture(content: bytes, width: int, height: int, max_pixels: int) -> NDArray[np.float32]:
    """The picture [3, height, width] in a file, linear RGB in 0..1, row 0 on top.

    The first frame is turned upright by its EXIF orientation and set on black where it is transparent. It keeps its
    aspect: it is fitted into the given size, centred, with black beside it. It is reduced by area, in linear light.

    Raises:
        ImageFormatError: the file is of none of FORMATS.
        ImageTooLargeError: the picture has more than `max_pixels` pixels; found out before any is decoded.
        ImageError: the file is empty, damaged or cut off.
    """
    decoded = _upright(_decode(content, max_pixels))
    scale = min(width / decoded.width, height / decoded.height)
    size = (
        min(width, max(1, round(decoded.width * scale))),
        min(height, max(1, round(decoded.height * scale))),
    )
    left, top = (width - size[0]) // 2, (height - size[1]) // 2
    kernel = Image.Resampling.BOX if scale < 1 else Image.Resampling.BILINEAR
    picture = np.zeros((3, height, width), np.float32)
    for channel, plane in enumerate(_linear_planes(decoded)):
        fitted = np.asarray(Image.fromarray(plane).resize(size, kernel))
        picture[channel, top : top + size[1], left : left + size[0]] = fitted
    return picture.clip(0, 1)


def _decode(content: bytes, max_pixels: int) -> Image.Image:
    if not content:
        raise ImageError(f"expected a picture, found an empty file; {_ADVICE}")
    # What comes here is anybody's bytes, and Pillow's decoders answer damage with whatever they stumble over (OSError,
    # ValueError, SyntaxError, struct.error, …): any of it means that the file is at fault.
    try:
        picture = Image.open(io.BytesIO(content), formats=FORMATS)
    except UnidentifiedImageError:
        raise ImageFormatError(f"expected a picture, found {_describe(content)}; {_ADVICE}") from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ImageTooLargeError(
            f"expected at most {max_pixels} pixels, found more than {Image.MAX_IMAGE_PIXELS}; send a smaller picture"
        ) from None
    except Exception as error:
        raise ImageError(f"expected a whole picture, found a damaged one ({str(error)[:200]}); {_ADVICE}") from error
    if picture.width * picture.height > max_pixels:
        raise ImageTooLargeError(
            f"expected at most {max_pixels} pixels, found {picture.width} × {picture.height} = "
            f"{picture.width * picture.height}; send a smaller picture"
        )
    try:
        picture.load()
    except Exception as error:
        raise ImageError(
            f"expected a whole {picture.format} picture, found one that is damaged or cut off ({str(error)[:200]}); "
            "send the file again"
        ) from error
    return picture


def _upright(picture: Image.Image) -> Image.Image:
    try:
        orientation = picture.getexif().get(_EXIF_ORIENTATION)
    except Exception:  # damaged metadata, from the same decoders; the pixels are whole, so they are shown as they are
        return picture
    turn = _UPRIGHT.get(orientation) if isinstance(orientation, int) else None
    return picture if turn is None else picture.transpose(turn)


def _linear_planes(picture: Image.Image) -> list[NDArray[np.float32]]:
    """Red, green and blue [H, W] in linear light, multiplied by the opacity."""
    if picture.mode.startswith("I"):
        # 16-bit grey, which Pillow would clip on the way to 8 bits.
        grey = np.asarray(picture)
        plane = _LINEAR_16[grey.clip(0, 65535).astype(np.uint16)]
        transparent = picture.info.get("transparency")
        if isinstance(transparent, int):
            plane *= grey != transparent
        return [plane, plane, plane]
    if picture.has_transparency_data:
        *colours, opacity = picture.convert("RGBA").split()
        weight = np.asarray(opacity).astype(np.float32) / 255
        return [_LINEAR_8[np.asarray(colour)] * weight for colour in colours]
    return [_LINEAR_8[np.asarray(colour)] for colour in picture.convert("RGB").split()]


def _describe(content: bytes) -> str:
    start = content[:8]
    text = start.decode("ascii", "replace")
    shown = text if text.isprintable() and "\ufffd" not in text else start.hex(" ")
    return f"{len(content)} bytes that begin with “{shown}”"
