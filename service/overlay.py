"""Pictures for people: the mesh over the picture that it was found in, and objects by themselves, as PNG files."""

import io
import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from imaging.alignment import aligned
from imaging.srgb import encode
from service.inference import Engine, Surface
from service.rendering.picture import Drawing, draw
from service.rendering.projection import project
from service.rendering.shading import shade

_COMFORTABLE_WIDTH: Final = 512
_DIMMED: Final = 0.5
"""What stays of the picture's light beside the mesh."""
_OPACITY: Final = 0.65
"""Of the mesh."""
_SAMPLES: Final = 2

Picture = NDArray[np.floating]


def enlargement(engine: Engine) -> int:
    """How many times larger than the model's picture one for people is."""
    return max(1, round(_COMFORTABLE_WIDTH / engine.manifest.picture.width))


def overlay_png(
    engine: Engine,
    surface: Surface,
    azimuth: float,
    light_azimuth: float,
    picture: NDArray[np.float32],
    by_rule: bool,
) -> bytes:
    """The surface as its camera sees it over a picture [3, H, W], `enlargement` times as large as the model's.

    Where a rule has set the picture's object, that is brought to where the surface is.
    """
    drawn = _drawn(engine, surface, azimuth, light_azimuth, enlargement(engine))
    if by_rule:
        picture = aligned(picture, drawn.colour)
    covered = _OPACITY * drawn.coverage
    return _png(_DIMMED * (1 - covered) * picture + _OPACITY * drawn.colour)


def objects_png(engine: Engine, surfaces: Sequence[Surface], azimuth: float) -> bytes:
    """Surfaces turned by `azimuth` radians on black, each as its camera sees it; several in rows."""
    across = math.ceil(math.sqrt(len(surfaces)))
    scale = max(1, enlargement(engine) // across)
    tiles = [_drawn(engine, surface, azimuth, 0.0, scale).colour for surface in surfaces]
    tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % across)
    rows = [np.concatenate(tiles[start : start + across], 2) for start in range(0, len(tiles), across)]
    return _png(np.concatenate(rows, 1))


def _drawn(engine: Engine, surface: Surface, azimuth: float, light_azimuth: float, scale: int) -> Drawing:
    manifest = engine.manifest
    width, height = scale * manifest.picture.width, scale * manifest.picture.height
    screen = project(surface.vertices, azimuth, manifest.camera, width, height)
    colours = shade(surface.normals, azimuth, light_azimuth, manifest.lights, manifest.ambient)
    return draw(screen, colours, engine.faces, width, height, _SAMPLES)


def _png(linear: Picture) -> bytes:
    buffer = io.BytesIO()
    codes = encode(linear.astype(np.float32)).transpose(1, 2, 0)
    Image.fromarray(np.ascontiguousarray(codes)).save(buffer, "PNG", compress_level=3)
    return buffer.getvalue()
