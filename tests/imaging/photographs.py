"""Photographs with a known truth: renderings of procedural objects before backgrounds, with shadow, noise and JPEG."""

import io
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from imaging.srgb import encode
from trainer.config import DirectionalLight, SceneConfig
from trainer.data.picture import draw
from trainer.data.shapes.car import make_car
from trainer.data.shapes.chair import make_chair
from trainer.data.shapes.solid import Mesh, normalise

WIDTH, HEIGHT = 640, 480
STUDIO = (
    DirectionalLight(azimuth_degrees=-40.0, elevation_degrees=40.0, colour=(0.55, 0.55, 0.55)),
    DirectionalLight(azimuth_degrees=60.0, elevation_degrees=20.0, colour=(0.2, 0.2, 0.2)),
)

Plane = NDArray[np.float64]


class Cutout(NamedTuple):
    """An object as it would be without a background, in a picture of the photograph's size."""

    colour: Plane
    """[H, W, 3] linear, over black."""
    coverage: Plane
    """[H, W]"""


def cutout(
    category: Literal["car", "chair"],
    seed: int,
    azimuth: float,
    size: float = 0.7,
    place: tuple[float, float] = (0.0, 0.0),
    grey: bool = False,
) -> Cutout:
    """An object, `size` times as large as in a rendering of the photograph's size, moved to the right and down by these
    parts of that size; `grey` under white light."""
    width, height = round(WIDTH * size), round(HEIGHT * size)
    scene = SceneConfig(width, height, lights=STUDIO, ambient=(0.12,) * 3) if grey else SceneConfig(width, height)
    drawn = draw(shape(category, seed), azimuth, 0.3, scene, 3)
    left, top = round((WIDTH - width) / 2 + place[0] * WIDTH), round((HEIGHT - height) / 2 + place[1] * HEIGHT)
    placed = []
    for plane in drawn:
        whole = np.zeros((3 * HEIGHT, 3 * WIDTH, *plane.shape[2:]))
        whole[HEIGHT + top : HEIGHT + top + height, WIDTH + left : WIDTH + left + width] = plane
        placed.append(whole[HEIGHT : 2 * HEIGHT, WIDTH : 2 * WIDTH])
    return Cutout(*placed)


def shape(category: Literal["car", "chair"], seed: int) -> Mesh:
    """A procedural object."""
    return normalise((make_car if category == "car" else make_chair)(np.random.default_rng(seed)))


def before(alone: Cutout, background: Plane) -> Plane:
    """[H, W, 3] linear: the object before a background [H, W, 3] or one colour."""
    return alone.colour + (1 - alone.coverage[..., None]) * background


def photographed(linear: Plane, noise: float = 0.0, quality: int | None = None, seed: int = 0) -> bytes:
    """A file: noise of that many sRGB codes, then JPEG of that quality, or PNG."""
    codes = encode(linear.astype(np.float32)).astype(float)
    codes += np.random.default_rng(seed).normal(0.0, noise, codes.shape)
    picture, buffer = Image.fromarray(codes.round().clip(0, 255).astype(np.uint8)), io.BytesIO()
    if quality is None:
        picture.save(buffer, "PNG", compress_level=1)
    else:
        picture.save(buffer, "JPEG", quality=quality)
    return buffer.getvalue()


def blurred(plane: Plane, radius: float) -> Plane:
    """[H, W] smoothed."""
    codes = Image.fromarray((255 * plane.clip(0, 1)).astype(np.uint8))
    return np.asarray(codes.filter(ImageFilter.GaussianBlur(radius))) / 255


def plain(*colour: float) -> Plane:
    return np.broadcast_to(np.array(colour), (HEIGHT, WIDTH, 3))


def gradient(one: tuple[float, float, float], other: tuple[float, float, float]) -> Plane:
    """From one colour at the upper left to another at the lower right."""
    rows, columns = np.mgrid[0 : 1 : HEIGHT * 1j, 0 : 1 : WIDTH * 1j]
    share = ((rows + columns) / 2)[..., None]
    return (1 - share) * one + share * np.array(other)


def vignette(colour: float) -> Plane:
    """Grey that darkens by half towards the corners."""
    rows, columns = np.mgrid[-1 : 1 : HEIGHT * 1j, -1 : 1 : WIDTH * 1j]
    return np.repeat((colour * (1 - 0.25 * (rows**2 + columns**2)))[..., None], 3, -1)


def with_contact_shadow(background: Plane, alone: Cutout, darkness: float = 0.6, softness: float = 14.0) -> Plane:
    """A soft shadow on the ground: the lower part of the object's outline, pressed flat, blurred."""
    rows, columns = np.nonzero(alone.coverage > 0.5)
    if not len(rows):
        return background
    bottom, left, right = rows.max(), columns.min(), columns.max()
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    half = (right - left) / 2
    ellipse = ((x - (left + right) / 2) / (1.05 * half)) ** 2 + ((y - bottom + 0.18 * half) / (0.35 * half)) ** 2 < 1
    return background * (1 - darkness * blurred(ellipse.astype(float), softness))[..., None]


def transparent(alone: Cutout) -> bytes:
    """The object as a PNG with transparency."""
    coverage = alone.coverage[..., None]
    colour = np.divide(alone.colour, coverage, out=np.zeros_like(alone.colour), where=coverage > 0)
    pixels = np.dstack((encode(colour.astype(np.float32)), (255 * alone.coverage).round().astype(np.uint8)))
    buffer = io.BytesIO()
    Image.fromarray(pixels, "RGBA").save(buffer, "PNG", compress_level=1)
    return buffer.getvalue()


def paper(colour: tuple[float, float, float], seed: int = 0) -> Plane:
    """Coloured paper with a fine grain."""
    grain = np.random.default_rng(seed).normal(1.0, 0.05, (HEIGHT, WIDTH, 1))
    return np.array(colour) * grain.clip(0.7, 1.3)


def boards(seed: int = 0) -> Plane:
    """Wooden boards: stripes, grain, joints."""
    rng = np.random.default_rng(seed)
    tones = np.repeat(rng.uniform(0.25, 0.6, 16), HEIGHT // 16)[:, None]
    grain = rng.normal(0, 0.06, (HEIGHT, 1)) + rng.normal(0, 0.04, (HEIGHT, WIDTH))
    return np.clip((tones + grain)[..., None] * (0.9, 0.55, 0.3), 0, 1)


def room(seed: int = 0) -> Plane:
    """A wall, a floor and things of many colours before them."""
    rng = np.random.default_rng(seed)
    picture = np.empty((HEIGHT, WIDTH, 3))
    picture[: HEIGHT * 5 // 9], picture[HEIGHT * 5 // 9 :] = rng.uniform(0.4, 0.9, 3), rng.uniform(0.05, 0.4, 3)
    for _ in range(24):
        width, height = rng.integers(30, 200, 2)
        top, left = rng.integers(-60, HEIGHT), rng.integers(-60, WIDTH)
        picture[max(0, top) : top + height, max(0, left) : left + width] = rng.uniform(0, 1, 3)
    return picture


def foliage(seed: int = 0, radius: float = 6.0) -> Plane:
    """Blobs of green and light, out of focus."""
    rng = np.random.default_rng(seed)
    noise = blurred(rng.uniform(size=(HEIGHT, WIDTH)), radius)
    noise = (noise - noise.min()) / (noise.max() - noise.min())
    return np.clip(noise[..., None] ** 2 * (0.7, 1.2, 0.4), 0, 1)
