"""From files to linear light: closed forms for every kind of picture that people send."""

from collections.abc import Callable

import numpy as np
import pytest
from PIL import Image

from service.errors import ImageError, ImageFormatError, ImageTooLargeError
from service.image import read_picture

Encoded = Callable[..., bytes]
MANY = 10_000_000


def linear(code: float) -> float:
    """IEC 61966-2-1, of an 8-bit code."""
    value = code / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def colour_blocks(mode: str = "RGB") -> Image.Image:
    """8 × 6 pixels: left half red 200, right half blue 100; the top row green 50."""
    pixels = np.zeros((6, 8, 3), np.uint8)
    pixels[:, :4] = (200, 0, 0)
    pixels[:, 4:] = (0, 0, 100)
    pixels[0] = (0, 50, 0)
    return Image.fromarray(pixels).convert(mode)


def expected_blocks() -> np.ndarray:
    picture = np.zeros((3, 6, 8))
    picture[0, 1:, :4] = linear(200)
    picture[2, 1:, 4:] = linear(100)
    picture[1, 0] = linear(50)
    return picture


@pytest.mark.parametrize("file_format", ["PNG", "BMP", "WEBP", "GIF"])
def test_lossless_formats_give_the_exact_pixels(encoded: Encoded, file_format: str) -> None:
    options = {"lossless": True} if file_format == "WEBP" else {}
    picture = read_picture(encoded(colour_blocks(), file_format, **options), 8, 6, MANY)
    assert picture.dtype == np.float32
    np.testing.assert_allclose(picture, expected_blocks(), atol=1e-6)


@pytest.mark.parametrize("mode", ["RGBA", "P", "RGBX"])
def test_every_mode_gives_the_exact_pixels(encoded: Encoded, mode: str) -> None:
    file_format = "BMP" if mode == "RGBX" else "PNG"
    image = colour_blocks().convert("P", palette=Image.Palette.ADAPTIVE) if mode == "P" else colour_blocks(mode)
    image = image.convert("RGB") if mode == "RGBX" else image
    np.testing.assert_allclose(read_picture(encoded(image, file_format), 8, 6, MANY), expected_blocks(), atol=1e-6)


def test_jpeg_and_cmyk_give_nearly_the_pixels(encoded: Encoded) -> None:
    plain = Image.new("RGB", (16, 12), (200, 100, 50))
    expected = np.array([linear(200), linear(100), linear(50)])
    for image in (plain, plain.convert("CMYK")):
        picture = read_picture(encoded(image, "JPEG", quality=98), 16, 12, MANY)
        np.testing.assert_allclose(picture.mean((1, 2)), expected, atol=0.02)


@pytest.mark.parametrize("depth", [1, 8, 16])
def test_grey_pictures_of_any_depth(encoded: Encoded, depth: int) -> None:
    if depth == 16:
        ramp = np.linspace(0, 65535, 48).round().astype(np.uint16).reshape(6, 8)
        values = ramp / 65535
        image = Image.fromarray(ramp)
    else:
        ramp = np.linspace(0, 255, 48).round().astype(np.uint8).reshape(6, 8)
        ramp = np.where(ramp > 127, 255, 0).astype(np.uint8) if depth == 1 else ramp
        values = ramp / 255
        image = Image.fromarray(ramp).convert("1") if depth == 1 else Image.fromarray(ramp)
    expected = np.vectorize(lambda value: linear(255 * value))(values)
    picture = read_picture(encoded(image), 8, 6, MANY)
    np.testing.assert_allclose(picture, np.broadcast_to(expected, (3, 6, 8)), atol=1e-6)


def test_transparent_pixels_are_black_and_hide_their_colour(encoded: Encoded) -> None:
    pixels = np.full((6, 8, 4), 255, np.uint8)
    pixels[..., 3] = np.array([0, 51, 102, 153, 204, 255])[:, None]
    picture = read_picture(encoded(Image.fromarray(pixels, "RGBA")), 8, 6, MANY)
    expected = np.broadcast_to((np.arange(6) / 5)[:, None], (3, 6, 8))
    np.testing.assert_allclose(picture, expected, atol=1e-6)


@pytest.mark.parametrize("mode", ["L", "P", "I;16"])
def test_a_transparent_value_is_black(encoded: Encoded, mode: str) -> None:
    ramp = np.tile(np.arange(8, dtype=np.uint16) * 30, (6, 1))
    image = Image.fromarray(ramp if mode == "I;16" else ramp.astype(np.uint8))
    image = image.convert("P") if mode == "P" else image
    picture = read_picture(encoded(image, transparency=210), 8, 6, MANY)
    scale = 65535 if mode == "I;16" else 255
    assert picture[:, :, 7].max() == 0
    np.testing.assert_allclose(picture[:, :, 6], linear(255 * 180 / scale), atol=1e-6)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_turns_the_picture_upright(encoded: Encoded, orientation: int) -> None:
    upright = np.zeros((6, 6), np.uint8)
    upright[0, :] = 255
    upright[:, 0] = 128
    # What a camera stores for each orientation, from the definition in EXIF 2.32, 4.6.4 A.
    stored = {
        1: upright,
        2: upright[:, ::-1],
        3: upright[::-1, ::-1],
        4: upright[::-1],
        5: upright.T,
        6: np.rot90(upright, 1),
        7: upright[::-1, ::-1].T,
        8: np.rot90(upright, -1),
    }[orientation]
    image = Image.fromarray(np.ascontiguousarray(stored))
    exif = Image.Exif()
    exif[0x0112] = orientation
    picture = read_picture(encoded(image, "PNG", exif=exif), 6, 6, MANY)
    np.testing.assert_allclose(picture[0], np.vectorize(linear)(upright), atol=1e-6)


def test_damaged_exif_does_not_cost_the_picture(encoded: Encoded) -> None:
    content = encoded(colour_blocks(), "PNG", exif=b"Exif\0\0MM\0*\xff\xff\xff\xff" + b"\xff" * 64)
    np.testing.assert_allclose(read_picture(content, 8, 6, MANY), expected_blocks(), atol=1e-6)


def test_reduction_is_by_area_in_linear_light(encoded: Encoded) -> None:
    chequers = np.indices((48, 64)).sum(0) % 2 * 255
    picture = read_picture(encoded(Image.fromarray(chequers.astype(np.uint8))), 8, 6, MANY)
    np.testing.assert_allclose(picture, 0.5, atol=1e-6)


@pytest.mark.parametrize(
    ("size", "rows", "columns"),
    [
        ((60, 60), slice(0, 48), slice(8, 56)),
        ((100, 25), slice(16, 32), slice(0, 64)),
        ((10, 40), slice(0, 48), slice(26, 38)),
        ((128, 96), slice(0, 48), slice(0, 64)),
        ((3, 2), slice(2, 45), slice(0, 64)),
        ((5000, 1), slice(23, 24), slice(0, 64)),
    ],
)
def test_any_aspect_is_fitted_and_centred_on_black(
    encoded: Encoded, size: tuple[int, int], rows: slice, columns: slice
) -> None:
    picture = read_picture(encoded(Image.new("RGB", size, "white")), 64, 48, MANY)
    expected = np.zeros((3, 48, 64))
    expected[:, rows, columns] = 1
    np.testing.assert_allclose(picture, expected, atol=1e-6)


def test_the_first_frame_of_an_animation_is_read(encoded: Encoded) -> None:
    frames = [Image.new("RGB", (8, 6), colour) for colour in ("red", "blue")]
    for file_format in ("GIF", "WEBP", "PNG"):
        content = encoded(frames[0], file_format, save_all=True, append_images=frames[1:])
        picture = read_picture(content, 8, 6, MANY)
        assert picture[0].min() > 0.98
        assert picture[2].max() < 0.02


def test_row_0_is_on_top_and_channels_are_rgb(encoded: Encoded) -> None:
    image = Image.new("RGB", (8, 6), "black")
    image.putpixel((7, 0), (255, 128, 0))
    picture = read_picture(encoded(image), 8, 6, MANY)
    np.testing.assert_allclose(picture[:, 0, 7], [1, linear(128), 0], atol=1e-6)
    assert picture.sum() == pytest.approx(1 + linear(128))


@pytest.mark.parametrize(
    "content",
    [b"%PDF-1.7 ...", b"GIF", b"\0" * 1000, b"<svg xmlns='http://www.w3.org/2000/svg'/>", b"II*\0" + b"\0" * 100],
)
def test_what_is_no_picture_is_named(content: bytes) -> None:
    with pytest.raises(ImageFormatError, match=f"expected a picture, found {len(content)} bytes .*send a PNG, JPEG"):
        read_picture(content, 8, 6, MANY)


def test_an_empty_file_is_named() -> None:
    with pytest.raises(ImageError, match="found an empty file; send a PNG"):
        read_picture(b"", 8, 6, MANY)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "BMP", "GIF"])
def test_every_cut_gives_a_sentence(encoded: Encoded, file_format: str) -> None:
    """Cut off anywhere, a file is refused or, where the pixels are all there, read."""
    noise = np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8)
    content = encoded(Image.fromarray(noise), file_format)
    sentences = []
    for length in range(0, len(content) - 1, max(1, len(content) // 60)):
        try:
            read_picture(content[:length], 8, 6, MANY)
        except ImageError as error:
            sentences.append(str(error))
    assert len(sentences) >= 55
    assert all("expected a" in sentence and "; send " in sentence for sentence in sentences)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "BMP", "GIF"])
def test_every_damaged_byte_gives_a_picture_or_a_sentence(encoded: Encoded, file_format: str) -> None:
    generator = np.random.default_rng(1)
    content = np.frombuffer(encoded(colour_blocks(), file_format), np.uint8)
    for _ in range(200):
        damaged = content.copy()
        places = generator.integers(0, len(content), 3)
        damaged[places] = generator.integers(0, 256, 3)
        try:
            picture = read_picture(damaged.tobytes(), 8, 6, 10_000)
        except ImageError:
            continue
        assert picture.shape == (3, 6, 8)
        assert np.isfinite(picture).all()


def test_too_many_pixels_are_refused_before_they_are_decoded(encoded: Encoded) -> None:
    content = encoded(Image.new("1", (9000, 9000)))
    assert len(content) < 50_000
    with pytest.raises(ImageTooLargeError, match="expected at most 1000000 pixels, found 9000 × 9000 = 81000000"):
        # Only the header is there: whatever decodes it would stumble.
        read_picture(content[:100], 8, 6, 1_000_000)


def test_even_more_pixels_are_refused(encoded: Encoded) -> None:
    content = bytearray(encoded(Image.new("1", (8, 8)), "BMP"))
    content[18:26] = (60_000).to_bytes(4, "little") * 2
    with pytest.raises(ImageTooLargeError, match="expected at most 1000000 pixels, found"):
        read_picture(bytes(content), 8, 6, 1_000_000)
