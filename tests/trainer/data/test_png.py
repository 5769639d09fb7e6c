"""PNG files of renderings: another reader gets every code back, and they are hardly larger than another writer's."""

import io

import numpy as np
import pytest
from PIL import Image

from imaging.srgb import FIRST_INTENSITY, encode
from trainer.config import SceneConfig
from trainer.data.picture import draw
from trainer.data.png import encode_png, srgb_codes
from trainer.data.shapes.catalogue import make_shape


@pytest.mark.parametrize("size", [(1, 1), (1, 300), (257, 3), (96, 128)])
def test_pillow_reads_every_code(size: tuple[int, int]) -> None:
    codes = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    with Image.open(io.BytesIO(encode_png(codes))) as picture:
        picture.verify()
    with Image.open(io.BytesIO(encode_png(codes))) as picture:
        assert (picture.format, picture.mode, picture.info) == ("PNG", "RGB", {"srgb": 0})
        np.testing.assert_array_equal(np.asarray(picture), codes)


def test_codes_are_those_that_imaging_gives() -> None:
    below, above = (np.nextafter(FIRST_INTENSITY, np.float32(to)) for to in (-1, 2))
    random = np.random.default_rng(0).uniform(-0.2, 1.2, 30_000).astype(np.float32)
    linear = np.concatenate((FIRST_INTENSITY, below, above, random)).reshape(-1, 16, 3)
    np.testing.assert_array_equal(srgb_codes(linear), encode(linear))


@pytest.mark.parametrize("category", ["car", "chair"])
def test_renderings_stay_small(category: str) -> None:
    codes = [encode(draw(make_shape(category, seed), 0.4 * seed, 0.0, SceneConfig())[0]) for seed in range(10)]
    sizes = []
    for picture in codes:
        buffer = io.BytesIO()
        Image.fromarray(picture).save(buffer, "PNG", compress_level=1)
        sizes.append((len(encode_png(picture)), len(buffer.getvalue())))
    ours, theirs = np.sum(sizes, axis=0)
    assert ours < 1.15 * theirs
