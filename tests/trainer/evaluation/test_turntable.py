"""Turntables: each frame shows what it should, and the whole stays small."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from PIL import Image

from imaging.srgb import encode
from tests.trainer.evaluation.conftest import SCENE
from trainer.evaluation.gallery import render
from trainer.evaluation.turntable import FRAME_MS, FRAMES, turntable
from trainer.geometry.topology import subdivided_cube

# A wedge: no two sides are alike.
CUBE = subdivided_cube(3, 0.6)
FACES = torch.tensor(CUBE.faces)
VERTICES = torch.tensor(CUBE.vertices * (0.6 + CUBE.vertices[:, 2:]) * (1.0, 0.6, 1.2), dtype=torch.float32)


def frames_of(content: bytes) -> list[np.ndarray]:
    found = []
    with Image.open(io.BytesIO(content)) as animation:
        for number in range(getattr(animation, "n_frames", 1)):
            animation.seek(number)
            found.append(np.asarray(animation.convert("RGB")).astype(int))
    return found


def test_each_frame_is_a_step_of_a_turn_that_begins_at_the_azimuth() -> None:
    moments = torch.stack([VERTICES * scale for scale in (1.0, 0.8, 0.6)])[:, None]
    found = frames_of(turntable(FACES, SCENE, moments, azimuth=0.5))
    assert len(found) == len(moments)
    stage = replace(SCENE, width=256, height=192)
    for number in range(len(moments)):
        azimuth = torch.tensor([0.5 + number * 2 * math.pi / FRAMES])
        expected = encode(render(FACES, stage, moments[number], azimuth)[0].permute(1, 2, 0).numpy())
        # Lossy, but nearer to its own moment than to any other.
        errors = [np.abs(other - expected).mean() for other in found]
        assert errors[number] < 3
        assert np.argmin(errors) == number


def test_it_repeats_for_ever_at_an_even_pace() -> None:
    moments = VERTICES.expand(FRAMES, 1, -1, -1)
    content = turntable(FACES, SCENE, moments, azimuth=1.0)
    with Image.open(io.BytesIO(content)) as animation:
        assert (animation.format, animation.info["loop"], getattr(animation, "n_frames", 1)) == ("WEBP", 0, FRAMES)
        ends = []
        for number in range(FRAMES):
            animation.seek(number)
            animation.load()
            ends.append(animation.info["timestamp"] + animation.info["duration"])
    np.testing.assert_array_equal(np.diff(ends), FRAME_MS)
    # The step from the last frame to the first is no larger than the others.
    found = frames_of(content)
    steps = [np.abs(found[number] - found[number - 1]).mean() for number in range(FRAMES)]
    assert 0 < steps[0] < max(steps[1:])


def test_shapes_stand_in_rows_and_what_is_left_over_is_black() -> None:
    shapes = torch.stack([VERTICES * scale for scale in (1.0, 0.7, 0.4)])
    (frame,) = frames_of(turntable(FACES, SCENE, shapes[None]))
    assert frame.shape == (2 * 192, 2 * 256, 3)
    stage = replace(SCENE, width=256, height=192)
    expected = encode(render(FACES, stage, shapes, torch.zeros(3)).permute(0, 2, 3, 1).numpy())
    tiles = [frame[row : row + 192, column : column + 256] for row in (0, 192) for column in (0, 256)]
    for tile, picture in zip(tiles[:3], expected, strict=True):
        assert np.abs(tile - picture).mean() < 3
    assert tiles[3].max() < 8


@pytest.mark.parametrize(
    ("count", "width", "height", "size"),
    [(100, 128, 96, (1020, 760)), (1, 2048, 16, (256, 2)), (1, 16, 2048, (2, 256)), (5, 64, 48, (768, 384))],
)
def test_the_picture_stays_within_1024_pixels(count: int, width: int, height: int, size: tuple[int, int]) -> None:
    moments = VERTICES.expand(1, count, -1, -1)
    content = turntable(FACES, replace(SCENE, width=width, height=height), moments)
    with Image.open(io.BytesIO(content)) as animation:
        assert animation.size == size
