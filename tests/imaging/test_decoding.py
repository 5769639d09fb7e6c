"""From files to linear light: closed forms for every kind of picture that people have."""

import struct
import zlib
from collections.abc import Callable

import numpy as np
import pytest
from PIL import Image

from imaging.decoding import Picture, decode
from imaging.errors import DamageError, FormatError, PixelLimitError
from imaging.srgb import encode

Encoded = Callable[..., bytes]
MANY = 10_000_000


def linear(code: float) -> float:
    """IEC 61966-2-1, of an 8-bit code."""
    value = code / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def whole(content: bytes) -> Picture:
    return decode(content, 10_000, 10_000, MANY)


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
    picture = whole(encoded(colour_blocks(), file_format, **options))
    assert picture.colour.dtype == np.float32
    assert picture.opacity is None
    np.testing.assert_allclose(picture.colour, expected_blocks(), atol=1e-6)
    np.testing.assert_array_equal(picture.columns, np.arange(9))
    np.testing.assert_array_equal(picture.rows, np.arange(7))


@pytest.mark.parametrize("mode", ["RGBA", "P", "RGBX"])
def test_every_mode_gives_the_exact_pixels(encoded: Encoded, mode: str) -> None:
    file_format = "BMP" if mode == "RGBX" else "PNG"
    image = colour_blocks().convert("P", palette=Image.Palette.ADAPTIVE) if mode == "P" else colour_blocks(mode)
    image = image.convert("RGB") if mode == "RGBX" else image
    picture = whole(encoded(image, file_format))
    assert picture.opacity is None
    np.testing.assert_allclose(picture.colour, expected_blocks(), atol=1e-6)


def test_jpeg_gives_nearly_the_pixels(encoded: Encoded) -> None:
    picture = whole(encoded(Image.new("RGB", (16, 12), (200, 100, 50)), "JPEG", quality=98))
    np.testing.assert_allclose(picture.colour.mean((1, 2)), [linear(200), linear(100), linear(50)], atol=0.01)


def test_cmyk_is_paper_seen_through_inks(encoded: Encoded) -> None:
    picture = whole(encoded(Image.new("CMYK", (16, 12), (30, 60, 90, 40)), "JPEG", quality=98))
    # Each ink lets its share through, and so does black: (255 - 30) · (255 - 40) / 255 = 190, and so on.
    np.testing.assert_allclose(picture.colour.mean((1, 2)), [linear(190), linear(164), linear(139)], atol=0.01)


@pytest.mark.parametrize("depth", [1, 8, 16])
def test_grey_of_any_depth(encoded: Encoded, depth: int) -> None:
    if depth == 16:
        ramp = np.linspace(0, 65535, 48).round().astype(np.uint16).reshape(6, 8)
        values, image = ramp / 65535, Image.fromarray(ramp)
    else:
        ramp = np.linspace(0, 255, 48).round().astype(np.uint8).reshape(6, 8)
        ramp = np.where(ramp > 127, 255, 0).astype(np.uint8) if depth == 1 else ramp
        values, image = ramp / 255, Image.fromarray(ramp).convert("1" if depth == 1 else "L")
    expected = np.vectorize(lambda value: linear(255 * value))(values)
    np.testing.assert_allclose(whole(encoded(image)).colour, np.broadcast_to(expected, (3, 6, 8)), atol=1e-6)


def png(pixels: np.ndarray, colour_type: int) -> bytes:
    """A PNG with 16 bits a channel, which Pillow does not write (PNG specification, sections 5 and 11.2)."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    height, width = pixels.shape[:2]
    lines = b"".join(b"\0" + row.astype(">u2").tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 16, colour_type, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")


def test_sixteen_bits_of_colour_keep_their_upper_eight() -> None:
    pixels = np.array([[[0x0000, 0x7FFF, 0xFFFF], [0x80FF, 0x1234, 0x00FF]]])
    expected = [[0x00, 0x80], [0x7F, 0x12], [0xFF, 0x00]]
    np.testing.assert_allclose(whole(png(pixels, 2)).colour[:, 0], np.vectorize(linear)(expected), atol=1e-6)


def test_sixteen_bits_with_transparency() -> None:
    picture = whole(png(np.array([[[0xFFFF, 0xFFFF, 0xFFFF, 0x3333], [0x80FF, 0, 0, 0xFFFF]]]), 6))
    np.testing.assert_allclose(picture.opacity, [[0x33 / 255, 1]], atol=1e-6)
    np.testing.assert_allclose(picture.colour[0, 0], [0x33 / 255, linear(0x80)], atol=1e-6)


def test_transparent_pixels_are_black_and_hide_their_colour(encoded: Encoded) -> None:
    pixels = np.full((6, 8, 4), 255, np.uint8)
    pixels[..., 3] = np.array([0, 51, 102, 153, 204, 255])[:, None]
    picture = whole(encoded(Image.fromarray(pixels, "RGBA")))
    expected = np.broadcast_to((np.arange(6) / 5)[:, None], (3, 6, 8))
    np.testing.assert_allclose(picture.colour, expected, atol=1e-6)
    np.testing.assert_allclose(picture.opacity, expected[0], atol=1e-6)


def test_grey_with_transparency(encoded: Encoded) -> None:
    pixels = np.zeros((1, 2, 2), np.uint8)
    pixels[0] = (100, 51), (200, 255)
    picture = whole(encoded(Image.fromarray(pixels, "LA")))
    np.testing.assert_allclose(picture.colour[1], [[linear(100) / 5, linear(200)]], atol=1e-6)
    np.testing.assert_allclose(picture.opacity, [[0.2, 1]], atol=1e-6)


@pytest.mark.parametrize("mode", ["L", "P", "I;16"])
def test_one_transparent_value(encoded: Encoded, mode: str) -> None:
    ramp = np.tile(np.arange(8, dtype=np.uint16) * 30, (6, 1))
    image = Image.fromarray(ramp if mode == "I;16" else ramp.astype(np.uint8))
    picture = whole(encoded(image.convert("P") if mode == "P" else image, transparency=210))
    np.testing.assert_array_equal(picture.opacity, np.broadcast_to(np.arange(8) != 7, (6, 8)))
    assert picture.colour[:, :, 7].max() == 0
    scale = 65535 if mode == "I;16" else 255
    np.testing.assert_allclose(picture.colour[:, :, 6], linear(255 * 180 / scale), atol=1e-6)


def test_a_palette_with_opacities(encoded: Encoded) -> None:
    image = Image.fromarray(np.array([[0, 1, 2]], np.uint8), "P")
    image.putpalette([255, 255, 255, 200, 0, 0, 0, 0, 100])
    picture = whole(encoded(image, transparency=bytes((0, 51, 255))))
    np.testing.assert_allclose(picture.opacity, [[0, 0.2, 1]], atol=1e-6)
    expected = [[0, linear(200) / 5, 0], [0, 0, 0], [0, 0, linear(100)]]
    np.testing.assert_allclose(picture.colour[:, 0], expected, atol=1e-6)


@pytest.mark.parametrize("file_format", ["GIF", "WEBP", "PNG"])
def test_the_first_frame_of_an_animation(encoded: Encoded, file_format: str) -> None:
    frames = [Image.new("RGB", (8, 6), colour) for colour in ("red", "blue")]
    options = {"lossless": True} if file_format == "WEBP" else {}
    picture = whole(encoded(frames[0], file_format, save_all=True, append_images=frames[1:], **options))
    np.testing.assert_array_equal(picture.colour[:, 3, 4], (1, 0, 0))


def test_a_telephones_picture_with_a_second_one_behind_it(encoded: Encoded) -> None:
    frames = [Image.new("RGB", (8, 6), colour) for colour in ("red", "blue")]
    picture = whole(encoded(frames[0], "MPO", save_all=True, append_images=frames[1:]))
    np.testing.assert_allclose(picture.colour.mean((1, 2)), (1, 0, 0), atol=0.01)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_turns_the_picture_upright(encoded: Encoded, orientation: int, file_format: str) -> None:
    upright = np.zeros((48, 64), np.uint8)
    upright[:24] = 128
    upright[:, :16] = 255
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
    exif = Image.Exif()
    exif[0x0112] = orientation
    content = encoded(Image.fromarray(np.ascontiguousarray(stored)), file_format, exif=exif)
    expected = np.vectorize(linear)(upright)
    np.testing.assert_allclose(whole(content).colour[0], expected, atol=1e-6 if file_format == "PNG" else 0.05)
    reduced = decode(content, 16, 12, MANY)
    assert reduced.factor == 4
    assert (reduced.columns[-1], reduced.rows[-1]) == (64, 48)
    np.testing.assert_allclose(reduced.colour[0], expected[::4, ::4], atol=1e-6 if file_format == "PNG" else 0.05)


def test_damaged_exif_does_not_cost_the_picture(encoded: Encoded) -> None:
    for file_format in ("PNG", "WEBP"):
        options = {"lossless": True} if file_format == "WEBP" else {}
        exif = b"Exif\0\0MM\0*\xff\xff\xff\xff" + b"\xff" * 64
        picture = whole(encoded(colour_blocks(), file_format, exif=exif, **options))
        np.testing.assert_allclose(picture.colour, expected_blocks(), atol=1e-6)


def test_a_colour_profile_is_ignored(encoded: Encoded) -> None:
    content = encoded(colour_blocks(), icc_profile=b"a profile of another colour space")
    np.testing.assert_allclose(whole(content).colour, expected_blocks(), atol=1e-6)


def test_reduction_is_by_area_in_linear_light(encoded: Encoded) -> None:
    chequers = Image.fromarray((np.indices((48, 64)).sum(0) % 2 * 255).astype(np.uint8))
    picture = decode(encoded(chequers), 9, 6, MANY)
    assert (picture.factor, picture.colour.shape) == (7, (3, 7, 10))
    # Half of the light is the code 188, not 128. A square of 7 × 7 has one bright pixel more or less than half.
    assert np.abs(picture.colour[:, :6, :9] - 0.5).max() < 0.011
    np.testing.assert_array_equal(picture.columns, [*range(0, 64, 7), 64])
    np.testing.assert_array_equal(picture.rows, [*range(0, 48, 7), 48])


def test_a_large_jpeg_is_reduced_while_it_is_decoded(encoded: Encoded) -> None:
    rows, columns = np.mgrid[0:480, 0:640] / 640
    smooth = Image.fromarray((np.stack((rows, columns, 1 - columns), -1) * 255).astype(np.uint8))
    content = encoded(smooth, "JPEG", quality=95)
    reduced, exact = decode(content, 160, 120, MANY), whole(content)
    assert (reduced.factor, reduced.colour.shape) == (4, (3, 120, 160))
    means = exact.colour.reshape(3, 120, 4, 160, 4).mean((2, 4)).astype(np.float32)
    assert np.abs(encode(reduced.colour).astype(int) - encode(means)).max() <= 2


def test_a_strip_is_reduced_until_it_is_small(encoded: Encoded) -> None:
    picture = decode(encoded(Image.new("1", (40_000, 200))), 64, 48, MANY)
    assert picture.colour[0].size <= 2_000_000
    assert (picture.columns[-1], picture.rows[-1]) == (40_000, 200)


def test_row_0_is_on_top_and_channels_are_rgb(encoded: Encoded) -> None:
    image = Image.new("RGB", (8, 6), "black")
    image.putpixel((7, 0), (255, 128, 0))
    picture = whole(encoded(image)).colour
    np.testing.assert_allclose(picture[:, 0, 7], [1, linear(128), 0], atol=1e-6)
    assert picture.sum() == pytest.approx(1 + linear(128))


@pytest.mark.parametrize(
    "content",
    [b"%PDF-1.7 ...", b"GIF", b"\0" * 1000, b"<svg xmlns='http://www.w3.org/2000/svg'/>", b"II*\0" + b"\0" * 100],
)
def test_what_is_no_picture_is_named(content: bytes) -> None:
    with pytest.raises(FormatError, match=f"expected a picture, found {len(content)} bytes that begin with "):
        whole(content)


def test_an_empty_file_is_named() -> None:
    with pytest.raises(DamageError, match="expected a picture, found an empty file"):
        whole(b"")


def test_too_many_pixels_are_refused_before_they_are_decoded(encoded: Encoded) -> None:
    content = encoded(Image.new("1", (9000, 9000)))
    assert len(content) < 50_000
    with pytest.raises(PixelLimitError, match="expected at most 1000000 pixels, found 9000 × 9000 = 81000000"):
        # Only the header is there: whatever decodes it would stumble.
        decode(content[:100], 64, 48, 1_000_000)


def test_even_more_pixels_are_refused(encoded: Encoded) -> None:
    content = bytearray(encoded(Image.new("1", (8, 8)), "BMP"))
    content[18:26] = (60_000).to_bytes(4, "little") * 2
    with pytest.raises(PixelLimitError, match="expected at most 1000000 pixels, found"):
        decode(bytes(content), 64, 48, 1_000_000)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "BMP", "GIF"])
def test_a_file_that_ends_early_is_damaged(encoded: Encoded, file_format: str) -> None:
    noise = Image.fromarray(np.random.default_rng(0).integers(0, 256, (24, 32, 3), np.uint8))
    content = encoded(noise, file_format)
    with pytest.raises(DamageError, match="expected a whole"):
        whole(content[: len(content) // 2])
