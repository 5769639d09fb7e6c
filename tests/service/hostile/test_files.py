"""Files that are bombs, programs, lies and halves: each is refused with a sentence, or read as what it shows."""

import struct
import zlib
from collections.abc import Callable

import pytest
from PIL import Image

from tests.service.asking import post, problem
from tests.service.hostile.target import Target

Encoded = Callable[..., bytes]


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png(width: int, height: int, *chunks: bytes, pixels: bytes | None = None) -> bytes:
    """A PNG of grey pixels, with chunks before them."""
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    data = zlib.compress(bytes(height * (width + 1)) if pixels is None else pixels, 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + b"".join(chunks) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def inflating(mebibytes: int) -> bytes:
    """What zlib makes that many zeros of."""
    packer = zlib.compressobj(9)
    return b"".join(packer.compress(bytes(2**20)) for _ in range(mebibytes)) + packer.flush()


BOMB = inflating(200)
SVG = b'<svg xmlns="http://www.w3.org/2000/svg"><image href="file:///etc/passwd"/></svg>'
POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n(/etc/passwd) (r) file\n"

FILES: dict[str, tuple[bytes, int, str]] = {
    "pixel bomb": (png(50000, 50000, pixels=b"\0"), 413, "image-too-large"),
    "pixel bomb beyond Pillow's own limit": (png(2**31 - 1, 2**31 - 1, pixels=b"\0"), 413, "image-too-large"),
    "no pixels": (png(0, 0, pixels=b"\0"), 415, "unsupported-image"),
    "text bomb": (png(64, 48, chunk(b"zTXt", b"a\0\0" + BOMB)), 422, "broken-image"),
    "international text bomb": (png(64, 48, chunk(b"iTXt", b"a\0\1\0\0\0" + BOMB)), 422, "broken-image"),
    "colour profile bomb": (png(64, 48, chunk(b"iCCP", b"a\0\0" + BOMB)), 422, "broken-image"),
    "damaged check sum": (png(64, 48)[:-16] + bytes(4) + png(64, 48)[-12:], 422, "broken-image"),
    "script in a GIF's clothes": (b"GIF89a/*" + SVG + b"*/=1;<script>alert(1)</script>", 415, "unsupported-image"),
    "GIF that ends in its head": (b"GIF89a\xff\xff\xff\xff\x00\x00\x00", 415, "unsupported-image"),
    "BMP of negative size": (
        b"BM" + struct.pack("<IHHI", 54, 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, -9, -9, 1, 24, 0, 0, 0, 0, 0, 0),
        413,
        "image-too-large",
    ),
    "WebP of a huge canvas": (
        b"RIFF" + struct.pack("<I", 22) + b"WEBPVP8X" + struct.pack("<I", 10) + b"\x02\0\0\0" + b"\xff" * 6,
        413,
        "image-too-large",
    ),
    "JPEG of a thousand scans": (
        b"\xff\xd8\xff\xe0\0\x10JFIF\0\1\1\0\0\1\0\1\0\0"
        b"\xff\xc2\0\x0b\x08\0\x30\0\x40\1\1\x11\0" + 1000 * b"\xff\xda\0\x08\1\1\0\0\0\0" + b"\xff\xd9",
        422,
        "broken-image",
    ),
    "zip before a picture": (b"PK\x03\x04" + png(64, 48), 415, "unsupported-image"),
    "SVG that reads files": (SVG, 415, "unsupported-image"),
    "PostScript program": (POSTSCRIPT, 415, "unsupported-image"),
    "TIFF": (b"II*\0\x08\0\0\0\xff\xff" + bytes(1000), 415, "unsupported-image"),
    "pickle": (b"\x80\x04\x95\x1d\0\0\0\0\0\0\0\x8c\x05posix\x94\x8c\x06system\x94\x93\x94.", 415, "unsupported-image"),
    "zeros": (bytes(100000), 415, "unsupported-image"),
    "nothing": (b"", 422, "broken-image"),
}


@pytest.mark.parametrize("name", FILES)
def test_a_hostile_file_is_refused(target: Target, name: str) -> None:
    content, status, kind = FILES[name]
    assert "expected" in problem(post(target.client, content), status, kind)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "WEBP", "GIF", "BMP"])
def test_half_a_picture_of_any_kind_is_refused(target: Target, encoded: Encoded, file_format: str) -> None:
    image = Image.effect_mandelbrot((160, 120), (-2, -1.2, 1, 1.2), 50).convert("RGB")
    content = encoded(image, file_format)
    assert "damaged" in problem(post(target.client, content[: len(content) // 2]), 422, "broken-image")


@pytest.mark.parametrize(
    "chunks",
    [
        b"".join(chunk(b"tEXt", b"a\0b") for _ in range(20000)),
        chunk(b"eXIf", b"MM\0*\0\0\0\x08\xff\xff" + bytes(60000)),
        chunk(b"acTL", struct.pack(">II", 2**31 - 1, 0)),
        chunk(b"gAMA", bytes(4)),
    ],
    ids=["many texts", "wrong EXIF", "endless animation", "no brightness"],
)
def test_strange_metadata_changes_nothing(target: Target, picture: bytes, chunks: bytes) -> None:
    head = len(b"\x89PNG\r\n\x1a\n") + 25
    response = post(target.client, picture[:head] + chunks + picture[head:])
    assert response.content == post(target.client, picture).content


def test_what_follows_the_pixels_is_never_inflated(target: Target) -> None:
    """128 MiB behind 48 rows: answered like the picture without them, and the process stays as small as it was."""
    usual, bomb = (post(target.client, png(64, 48, pixels=bytes(48 * 65 + more))) for more in (0, 2**27))
    assert problem(bomb, 422, "broken-image") == problem(usual, 422, "broken-image")
