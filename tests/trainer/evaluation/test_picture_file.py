"""A picture on its own is prepared as it is in its folder."""

from pathlib import Path

import numpy as np
import pytest
import torch

from tests.imaging.photographs import before, boards, cutout, photographed, plain, transparent
from trainer.config import CameraConfig, SceneConfig
from trainer.data.images import load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.errors import DataError
from trainer.evaluation.picture_file import read_picture

WIDTH, HEIGHT = 32, 24
CAR = cutout("car", 1, 0.7, 0.7)


@pytest.mark.parametrize("size", [(WIDTH, HEIGHT), (64, 48)])
def test_renderings_are_taken_as_they_are(tmp_path: Path, size: tuple[int, int]) -> None:
    scene = SceneConfig(*size, camera=CameraConfig(distance=3.0))
    render_folder(tmp_path, RenderSettings("car", supersampling=1), scene, 2, 1, 1, show_progress=False)
    for zoom in (1.0, 1.4):
        images = load_image_folder(tmp_path, WIDTH, HEIGHT, zoom=zoom)
        for number, name in enumerate(images.names):
            assert torch.equal(read_picture(tmp_path / name, images.scene), images.batch(np.array([number]))[0])


@pytest.mark.parametrize("name", ["car.png", "car.jpg"])
def test_one_s_own_pictures_are_cut_out(tmp_path: Path, name: str) -> None:
    content = transparent(CAR) if name == "car.png" else photographed(before(CAR, plain(0.9, 0.9, 0.9)), 2, 90)
    (tmp_path / name).write_bytes(content)
    images = load_image_folder(tmp_path, WIDTH, HEIGHT)
    picture = read_picture(tmp_path / name, images.scene)
    assert torch.equal(picture, images.batch(np.array([0]))[0])
    assert picture[:, [0, -1]].max() == 0
    assert picture.max() > 0.3


def test_what_cannot_be_cut_out_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "car.jpg"
    path.write_bytes(photographed(before(CAR, boards()), 2, 90))
    with pytest.raises(DataError, match=r"car\.jpg: expected a plain background.*Name a PNG, JPEG or WebP file"):
        read_picture(path, SceneConfig(WIDTH, HEIGHT))
