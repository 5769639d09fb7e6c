"""The forms that an answer can have."""

from typing import Final

from service.answer import Form

GLB: Final = "model/gltf-binary"
JSON: Final = "application/json"
PNG: Final = "image/png"
REPRESENTATIONS: Final = (GLB, JSON, PNG)


def form_of(media_type: str) -> Form:
    """The file that such an answer is or, as JSON, holds."""
    return "png" if media_type == PNG else "glb"
