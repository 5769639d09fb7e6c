"""Pictures as files in memory."""

import io
from collections.abc import Callable

import pytest
from PIL import Image

Encoded = Callable[..., bytes]


@pytest.fixture(scope="session")
def encoded() -> Encoded:
    """encoded(image, format, **options): an image file in memory."""

    def encode(image: Image.Image, file_format: str = "PNG", **options: object) -> bytes:
        buffer = io.BytesIO()
        image.save(buffer, file_format, **options)
        return buffer.getvalue()

    return encode
