"""Uploads: prepared as a training's pictures are, or answered with what was expected, what was found and what to do."""

from collections.abc import Callable

import numpy as np
import pytest
from PIL import Image

from imaging.framing import frame_of
from imaging.preparation import fit, prepare
from service.errors import ImageError, ImageFormatError, ImageTooLargeError
from service.image import read_picture
from tests.imaging.photographs import before, boards, cutout, photographed, plain, transparent

Encoded = Callable[..., bytes]
MANY = 10_000_000
FRAME = frame_of(64, 48, 2.0, 30.0)
CAR = cutout("car", 2, 0.9, 0.7)


def red_disc(size: tuple[int, int] = (64, 48)) -> Image.Image:
    """Before white."""
    rows, columns = np.mgrid[-1 : 1 : size[1] * 1j, -1 : 1 : size[0] * 1j]
    inside = rows**2 + columns**2 < 0.4
    return Image.fromarray(np.where(inside[..., None], (200, 30, 20), 255).astype(np.uint8))


@pytest.mark.parametrize(
    "content", [photographed(before(CAR, plain(1, 1, 1)), 2, 85), transparent(CAR)], ids=["white", "transparent"]
)
def test_an_upload_is_prepared_as_in_training(content: bytes) -> None:
    picture = read_picture(content, 64, 48, MANY).picture
    assert (picture.dtype, picture.shape) == (np.float32, (3, 48, 64))
    np.testing.assert_array_equal(picture, prepare(content, FRAME, MANY, keep_framed=False).picture)


def test_a_rendering_is_taken_as_it_is(picture: bytes) -> None:
    found = read_picture(picture, 64, 48, MANY).picture
    np.testing.assert_array_equal(found, fit(picture, FRAME, MANY).picture)
    assert found[:, 24, 32].min() > 0.1


def test_the_models_camera_says_how_large_the_object_is() -> None:
    near, far = (read_picture(transparent(CAR), 64, 48, MANY, distance).picture for distance in (2.0, 4.0))
    assert (far.max(0) > 0.1).sum() == pytest.approx((near.max(0) > 0.1).sum() / 4, rel=0.15)
    wide = read_picture(transparent(CAR), 64, 48, MANY, field_of_view_degrees=56.4).picture
    np.testing.assert_allclose(wide, far, atol=0.05)


def test_a_busy_background_is_refused_with_advice() -> None:
    with pytest.raises(ImageError, match=r"expected a plain background, found many colours .*; send one object before"):
        read_picture(photographed(before(CAR, boards()), 2, 85), 64, 48, MANY)


def test_nothing_but_background_is_refused() -> None:
    with pytest.raises(ImageError, match=r"expected an object .*, found .*; send one object before a plain background"):
        read_picture(photographed(plain(0.8, 0.8, 0.8)), 64, 48, MANY)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "BMP", "GIF"])
def test_every_known_format_is_read(encoded: Encoded, file_format: str) -> None:
    picture = read_picture(encoded(red_disc((320, 240)), file_format), 64, 48, MANY).picture
    np.testing.assert_allclose(picture[:, 20:28, 28:36].mean((1, 2)), (0.578, 0.013, 0.007), atol=0.02)
    assert picture[:, [0, -1]].max() == 0


@pytest.mark.parametrize(
    "content",
    [b"%PDF-1.7 ...", b"GIF", b"\0" * 1000, b"<svg xmlns='http://www.w3.org/2000/svg'/>", b"II*\0" + b"\0" * 100],
)
def test_what_is_no_picture_is_named(content: bytes) -> None:
    with pytest.raises(ImageFormatError, match=f"expected a picture, found {len(content)} bytes .*send a PNG, JPEG"):
        read_picture(content, 64, 48, MANY)


def test_an_empty_file_is_named() -> None:
    with pytest.raises(ImageError, match="found an empty file; send the whole file again"):
        read_picture(b"", 64, 48, MANY)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "BMP", "GIF"])
def test_every_cut_gives_a_sentence(encoded: Encoded, file_format: str) -> None:
    """Cut off anywhere, a file is refused or, where the pixels are all there, read."""
    noise = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)
    content = encoded(Image.fromarray(noise), file_format)
    sentences = []
    for length in range(0, len(content) - 1, max(1, len(content) // 60)):
        try:
            read_picture(content[:length], 64, 48, MANY)
        except ImageError as error:
            sentences.append(str(error))
    assert len(sentences) >= 55
    assert all("expected a" in sentence and "; send " in sentence for sentence in sentences)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "BMP", "GIF"])
def test_every_damaged_byte_gives_a_picture_or_a_sentence(encoded: Encoded, file_format: str) -> None:
    generator = np.random.default_rng(1)
    content = np.frombuffer(encoded(red_disc(), file_format), np.uint8)
    read = 0
    for _ in range(200):
        damaged = content.copy()
        places = generator.integers(0, len(content), 3)
        damaged[places] = generator.integers(0, 256, 3)
        try:
            picture = read_picture(damaged.tobytes(), 64, 48, 100_000).picture
        except ImageError:
            continue
        read += 1
        assert picture.shape == (3, 48, 64)
        assert np.isfinite(picture).all()
    assert read


def test_too_many_pixels_are_refused_before_they_are_decoded(encoded: Encoded) -> None:
    content = encoded(Image.new("1", (9000, 9000)))
    assert len(content) < 50_000
    sentence = "expected at most 1000000 pixels, found 9000 × 9000 = 81000000; send a smaller picture"
    with pytest.raises(ImageTooLargeError, match=sentence):
        # Only the header is there: whatever decodes it would stumble.
        read_picture(content[:100], 64, 48, 1_000_000)


def test_even_more_pixels_are_refused(encoded: Encoded) -> None:
    content = bytearray(encoded(Image.new("1", (8, 8)), "BMP"))
    content[18:26] = (60_000).to_bytes(4, "little") * 2
    with pytest.raises(ImageTooLargeError, match="expected at most 1000000 pixels, found"):
        read_picture(bytes(content), 64, 48, 1_000_000)
