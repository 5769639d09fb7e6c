"""From an uploaded file to the picture that the encoder expects, prepared as the pictures of a training are."""

from collections.abc import Sequence
from typing import Final

from imaging.decoding import pixels_in
from imaging.errors import BackgroundError, DamageError, FormatError, PictureError, PixelLimitError
from imaging.framing import Frame, frame_of
from imaging.preparation import Prepared, prepare_all
from service.errors import ImageError, ImageFormatError, ImageTooLargeError

_KNOWN_FORMATS: Final = "send a PNG, JPEG, WebP, BMP or GIF file"


def read_picture(
    content: bytes,
    width: int,
    height: int,
    max_pixels: int,
    distance: float = 2.0,
    field_of_view_degrees: float = 30.0,
    keep_framed: bool = True,
    zoom: float = 1.0,
) -> Prepared:
    """The picture [3, height, width] in a file, linear RGB in 0..1, row 0 on top, and how it was prepared.

    The first frame is turned upright by its EXIF orientation. Its object is told by transparency, or else by a plain
    background, and set on black where and as large as the model's camera, at `distance` with that field of view, shows
    objects. A picture on black that looks like a rendering is taken as it is, if `keep_framed`: the middle 1 / `zoom`
    of it, of which the field of view is.

    Raises:
        ImageFormatError: the file is of none of the known formats.
        ImageTooLargeError: the picture has more than `max_pixels` pixels; found out before any is decoded.
        ImageError: the file is empty, damaged or cut off, or its object cannot be told from its background.
    """
    frame = frame_of(width, height, distance, field_of_view_degrees, zoom)
    (prepared,) = read_pictures(content, (frame,), max_pixels, keep_framed)
    return prepared


def read_pictures(content: bytes, frames: Sequence[Frame], max_pixels: int, keep_framed: bool = True) -> list[Prepared]:
    """The picture in a file as several models see it: decoded and cut out once where they need the same detail.

    Raises as `read_picture` does.
    """
    try:
        return prepare_all(content, frames, max_pixels, keep_framed)
    except PictureError as error:
        raise _answered(error) from error


def check_pixels(contents: Sequence[bytes], max_pixels: int) -> None:
    """Raises ImageTooLargeError where pictures have more than `max_pixels` pixels together, before any is decoded; and
    as `read_picture` does where one is no picture."""
    try:
        total = sum(pixels_in(content, max_pixels) for content in contents)
    except PictureError as error:
        raise _answered(error) from error
    if total > max_pixels:
        raise ImageTooLargeError(
            f"expected at most {max_pixels} pixels in all pictures together, found {total}; send smaller ones"
        )


def _answered(error: PictureError) -> ImageError:
    match error:
        case FormatError():
            return ImageFormatError(f"{error}; {_KNOWN_FORMATS}")
        case PixelLimitError():
            return ImageTooLargeError(f"{error}; send a smaller picture")
        case BackgroundError():
            return ImageError(f"{error}; send one object before a plain background, or cut out with a transparent one")
        case DamageError():
            return ImageError(f"{error}; send the whole file again")
        case _:
            return ImageError(str(error))
