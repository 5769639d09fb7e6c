"""A picture file of any kind, decoded: upright, its first frame, in linear light, reduced to a size to work with.

Colour profiles are ignored: every file is taken as sRGB. Files with 16 bits a channel are read in full where they are
grey, and in their upper 8 bits where they are coloured, as Pillow decodes them.
"""

import io
import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from imaging.errors import DamageError, FormatError, PixelLimitError
from imaging.scaling import block_means
from imaging.srgb import decode_table

FORMATS: Final = ("PNG", "JPEG", "WEBP", "BMP", "GIF")
"""The formats that are read, by Pillow's names; whatever else a file holds is refused before it is decoded."""

_DRAFTED: Final = ("JPEG", "MPO")
"""Formats whose decoder can reduce. In the others the orientation may stand behind the pixels."""

_MOST_WORKING_PIXELS: Final = 2_000_000
_STRIP_PIXELS: Final = 1_000_000

_START_OF_SCAN: Final = b"\xff\xda"
_MOST_SCANS: Final = 100
"""Progressive JPEGs have about ten. Every one goes over the whole picture, and may be a few bytes long."""

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
_LYING: Final = tuple(_UPRIGHT[orientation] for orientation in (5, 6, 7, 8))


class Picture(NamedTuple):
    """A picture, or a part of one, each of its pixels the mean of a square of the file's."""

    colour: NDArray[np.float32]
    """[3, h, w] linear RGB 0..1 multiplied by the opacity, row 0 on top."""
    opacity: NDArray[np.float32] | None
    """[h, w] 0..1; None where nothing is transparent."""
    columns: NDArray[np.float64]
    """[w + 1] where its columns begin and the last one ends, pixels of the upright file."""
    rows: NDArray[np.float64]
    """[h + 1] where its rows begin and the last one ends."""
    factor: int
    """Side of those squares; at the right and lower end of the file they may be cut off."""


def part_of(picture: Picture, rows: slice, columns: slice) -> Picture:
    """Some rows and columns of a picture."""
    return Picture(
        picture.colour[:, rows, columns],
        None if picture.opacity is None else picture.opacity[rows, columns],
        picture.columns[columns.start : columns.stop + 1],
        picture.rows[rows.start : rows.stop + 1],
        picture.factor,
    )


def pixels_in(content: bytes, max_pixels: int) -> int:
    """How many pixels a picture file has, by its head. Raises as `decode` does, but for damage behind the head."""
    file = _open(content, max_pixels)
    return file.width * file.height


def decode(content: bytes, least_width: int, least_height: int, max_pixels: int) -> Picture:
    """The picture in a file, reduced in linear light by the largest whole factor that leaves it the least size.

    It is the first frame of an animation, turned upright by its EXIF orientation. A JPEG is first reduced by 2, 4 or 8
    while it is decoded, which is fast, and means over sRGB codes.

    Raises:
        FormatError: the file is of none of FORMATS.
        PixelLimitError: the picture has more than `max_pixels` pixels; found out before any is decoded.
        DamageError: the file is empty, damaged or cut off.
    """
    return PictureFile(content, max_pixels).reduced(least_width, least_height)


class PictureFile:
    """A picture file from which the picture is wanted in several sizes: those that come out alike are made once."""

    def __init__(self, content: bytes, max_pixels: int) -> None:
        """Raises as `decode` does."""
        self._content, self._max_pixels = content, max_pixels
        self._file = _open(content, max_pixels)
        self._turn = _turn(self._file)
        # By how much a decoder reduces, and by how much the picture is reduced after it.
        self._reduced: dict[tuple[int, int], Picture] = {}

    def reduced(self, least_width: int, least_height: int) -> Picture:
        """As `decode`."""
        lying = self._turn in _LYING
        width, height = self._file.size
        file = self._file
        if file.format in _DRAFTED:
            # What a decoder has reduced stays so.
            file = _open(self._content, self._max_pixels)
        drafted = file.draft(None, (least_height, least_width) if lying else (least_width, least_height))
        draft = 1 if drafted is None else round(width / drafted[1][2])
        if lying:
            width, height = height, width
        working_width, working_height = math.ceil(width / draft), math.ceil(height / draft)
        fitting = min(working_width // max(1, least_width), working_height // max(1, least_height))
        bounded = math.ceil(math.sqrt(working_width * working_height / _MOST_WORKING_PIXELS))
        factor = max(1, fitting, bounded)
        if (draft, factor) not in self._reduced:
            upright = _loaded(file) if self._turn is None else _loaded(file).transpose(self._turn)
            self._reduced[draft, factor] = _picture(upright, (width, height), draft, factor)
        return self._reduced[draft, factor]


def _picture(upright: Image.Image, size: tuple[int, int], draft: int, factor: int) -> Picture:
    """What a decoder gave of a file of this `size`, reduced by `draft`, reduced by `factor` more."""
    codes, count, opacity = _codes(upright)
    colour = _linear_means(codes, decode_table(count), opacity, factor)
    if len(colour) == 1:
        colour = colour.repeat(3, 0)
    squares = draft * factor
    columns, rows = (
        np.minimum(np.arange(number + 1) * squares, pixels).astype(np.float64)
        for number, pixels in zip((colour.shape[2], colour.shape[1]), size, strict=True)
    )
    return Picture(colour, None if opacity is None else block_means(opacity, factor), columns, rows, squares)


def _open(content: bytes, max_pixels: int) -> Image.Image:
    if not content:
        raise DamageError("expected a picture, found an empty file")
    # What comes here is anybody's bytes, and Pillow's decoders answer damage with whatever they stumble over (OSError,
    # ValueError, SyntaxError, struct.error, …): any of it means that the file is at fault.
    try:
        file = Image.open(io.BytesIO(content), formats=FORMATS)
    except UnidentifiedImageError:
        raise FormatError(f"expected a picture, found {_described(content)}") from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise PixelLimitError(
            f"expected at most {max_pixels} pixels, found more than {Image.MAX_IMAGE_PIXELS}"
        ) from None
    except Exception as error:
        raise DamageError(f"expected a whole picture, found a damaged one ({str(error)[:200]})") from error
    if file.width * file.height > max_pixels:
        raise PixelLimitError(
            f"expected at most {max_pixels} pixels, found {file.width} × {file.height} = {file.width * file.height}"
        )
    if file.format in _DRAFTED and content.count(_START_OF_SCAN) > _MOST_SCANS:
        raise DamageError(
            f"expected a JPEG of at most {_MOST_SCANS} scans, found {content.count(_START_OF_SCAN)}: each takes as "
            "long as a picture"
        )
    return file


def _turn(file: Image.Image) -> Image.Transpose | None:
    """How the picture is turned upright."""
    try:
        if file.format not in _DRAFTED:
            _loaded(file)
        orientation = file.getexif().get(_EXIF_ORIENTATION)
    except DamageError:
        raise
    except Exception:  # damaged metadata, from the same decoders; the pixels are whole, so they are shown as they are
        return None
    return _UPRIGHT.get(orientation) if isinstance(orientation, int) else None


def _loaded(file: Image.Image) -> Image.Image:
    try:
        file.load()
    except Exception as error:
        raise DamageError(
            f"expected a whole {file.format} picture, found one that is damaged or cut off ({str(error)[:200]})"
        ) from error
    return file


def _codes(picture: Image.Image) -> tuple[NDArray[np.integer], int, NDArray[np.float32] | None]:
    """The codes [1, h, w] of grey or [3, h, w] of colour; how many codes there are; and the opacity where any is
    transparent."""
    if picture.mode.startswith("I"):
        # 16 bits of grey, which Pillow would clip on the way to 8.
        grey = np.asarray(picture).clip(0, 65535).astype(np.uint16)
        transparent = picture.info.get("transparency")
        opacity = (grey != transparent).astype(np.float32) if isinstance(transparent, int) else None
        return grey[None], 65536, opacity
    if picture.has_transparency_data:
        pixels = np.asarray(picture.convert("RGBA")).transpose(2, 0, 1)
        opacity = pixels[3].astype(np.float32) / np.float32(255)
        return pixels[:3], 256, None if opacity.min() == 1 else opacity
    return np.asarray(picture.convert("RGB")).transpose(2, 0, 1), 256, None


def _linear_means(
    codes: NDArray[np.integer], table: NDArray[np.float32], opacity: NDArray[np.float32] | None, factor: int
) -> NDArray[np.float32]:
    """Linear intensity times opacity, averaged; in strips, so that a large picture does not grow fourfold at once."""
    channels, height, width = codes.shape
    rows = factor * max(1, _STRIP_PIXELS // (factor * channels * width))
    strips = []
    for start in range(0, height, rows):
        # Plane by plane in memory, as all that follows goes through them.
        linear = np.take(table, np.ascontiguousarray(codes[:, start : start + rows]))
        if opacity is not None:
            linear *= opacity[start : start + rows]
        strips.append(block_means(linear, factor))
    return np.concatenate(strips, 1)


def _described(content: bytes) -> str:
    start = content[:8]
    text = start.decode("ascii", "replace")
    shown = text if text.isprintable() and "\ufffd" not in text else start.hex(" ")
    return f"{len(content)} bytes that begin with “{shown}”"
