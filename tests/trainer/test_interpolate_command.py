"""One object becomes another, from the command line; and samples turn."""

from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh
from PIL import Image

from imaging.srgb import encode
from tests.trainer.new_model import HEIGHT, WIDTH, new_model, save_model
from trainer.commands.line import run
from trainer.config import SceneConfig
from trainer.data.images import load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.evaluation.gallery import as_pictures, render
from trainer.evaluation.subject import answer, from_checkpoint
from trainer.evaluation.turntable import FRAMES
from trainer.model.vae import Model
from trainer.training.checkpoint import load_checkpoint


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture of each of two cars."""
    folder = tmp_path_factory.mktemp("pictures")
    render_folder(folder, RenderSettings("car", seed=4, supersampling=1), SceneConfig(WIDTH, HEIGHT), 2, 1, 1, False)
    return folder


@pytest.fixture(scope="module")
def checkpoint(pictures: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Model]:
    """A model to which the two pictures are as far apart as typical shapes are, and where it is stored."""
    path, model = tmp_path_factory.mktemp("run") / "checkpoint.safetensors", new_model()
    head = model.heads.shape_mean
    with torch.no_grad():
        codes = model.encode(load_image_folder(pictures, WIDTH, HEIGHT).batch(np.arange(2))).shape_mean
        head.bias.sub_(codes.mean(0))
        for parameter in (head.weight, head.bias):
            parameter.mul_(3 / (codes[1] - codes[0]).norm())
    save_model(path, model)
    return path, model


def test_shapes_go_evenly_from_one_reconstruction_to_the_other(
    checkpoint: tuple[Path, Model], pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, model = checkpoint
    first, last = sorted(pictures.rglob("*.png"))
    options = ["--checkpoint", str(path), "--output", str(tmp_path), "--steps", "3"]
    assert run(["interpolate", str(first), str(last), *options]) == 0
    assert "3 shapes of car" in capsys.readouterr().out
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "01.glb", "02.glb", "03.glb", "strip.png", "turntable.webp",
    ]  # fmt: skip

    images = load_image_folder(pictures, WIDTH, HEIGHT).batch(np.arange(2))
    with torch.no_grad():
        ends = answer(from_checkpoint(load_checkpoint(path)), images, 1)
        middle = model.decode(model.encode(images).shape_mean.mean(0, keepdim=True))
        shapes = torch.cat((ends.vertices[:1], middle, ends.vertices[1:]))
        assert ends.light_azimuths is not None
        sides = [angles[0].expand(3) for angles in (ends.azimuths, ends.light_azimuths)]
        drawn = render(model.faces, SceneConfig(WIDTH, HEIGHT), shapes, *sides)
    assert not torch.allclose(ends.vertices[0], ends.vertices[1], atol=1e-2)
    for number, vertices in enumerate(shapes, 1):
        scene = trimesh.load(tmp_path / f"{number:02d}.glb")
        assert set(scene.graph.nodes_geometry) == {f"block-{block}" for block in range(1, 7)}
        np.testing.assert_allclose(scene.bounds, np.stack((vertices.amin(0), vertices.amax(0))), atol=1e-5)

    strip = np.asarray(Image.open(tmp_path / "strip.png"))
    tiles = [*as_pictures(images[:1]), *as_pictures(drawn), *as_pictures(images[1:])]
    height, width, _ = tiles[0].shape
    assert strip.shape[1] == 2 + 5 * (width + 2)
    for column, tile in enumerate(tiles):
        left = 2 + column * (width + 2)
        np.testing.assert_allclose(strip[-2 - height : -2, left : left + width], encode(tile), atol=1)


def test_the_turntable_turns_twice_there_and_back(
    checkpoint: tuple[Path, Model], pictures: Path, tmp_path: Path
) -> None:
    first, last = sorted(map(str, pictures.rglob("*.png")))
    assert run(["interpolate", first, last, "--checkpoint", str(checkpoint[0]), "--output", str(tmp_path)]) == 0
    frames = []
    with Image.open(tmp_path / "turntable.webp") as animation:
        assert getattr(animation, "n_frames", 1) == 2 * FRAMES
        for number in (0, FRAMES // 2, FRAMES, 3 * FRAMES // 2):
            animation.seek(number)
            frames.append(np.asarray(animation.convert("RGB")).astype(int))
    start, there, end, back = frames
    # Half way it is the same shape in the same pose, whichever way it goes; the ends differ.
    assert np.abs(there - back).mean() < 2
    assert np.abs(start - end).mean() > 4 * np.abs(there - back).mean()


def test_samples_turn_where_that_is_asked_for(
    checkpoint: tuple[Path, Model], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["sample", "--checkpoint", str(checkpoint[0]), "--count", "2", "--output"]
    assert run([*arguments, str(tmp_path / "two.png")]) == 0
    assert [file.name for file in tmp_path.iterdir()] == ["two.png"]
    assert run([*arguments, str(tmp_path / "two.png"), "--turntable"]) == 0
    with Image.open(tmp_path / "two.webp") as animation:
        assert (getattr(animation, "n_frames", 1), animation.size) == (FRAMES, (512, 192))
    assert run([*arguments, str(tmp_path / "two.webp"), "--turntable"]) == 2
    assert "--output to end in .png beside --turntable" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "sentence"),
    [(None, "mine.png cannot be read as a picture"), (b"no picture", "mine.png cannot be read as a picture")],
)
def test_a_picture_that_cannot_be_used_is_named_and_nothing_is_written(
    checkpoint: tuple[Path, Model],
    pictures: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    content: bytes | None,
    sentence: str,
) -> None:
    if content is not None:
        (tmp_path / "mine.png").write_bytes(content)
    good = next(pictures.rglob("*.png"))
    options = ["--checkpoint", str(checkpoint[0]), "--output", str(tmp_path / "out")]
    assert run(["interpolate", str(good), str(tmp_path / "mine.png"), *options]) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
