"""One object from several pictures, from the command line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
import trimesh
from PIL import Image

from imaging.alignment import aligned
from tests.trainer.new_model import HEIGHT, WIDTH, new_model, save_model
from trainer.commands import reconstruct
from trainer.commands.line import run
from trainer.config import SceneConfig
from trainer.data.images import load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.evaluation.gallery import render
from trainer.evaluation.subject import answer, from_checkpoint
from trainer.evaluation.turntable import FRAMES, turntable
from trainer.model.vae import Model
from trainer.training.checkpoint import load_checkpoint, save_checkpoint


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three views of a car."""
    folder = tmp_path_factory.mktemp("views")
    render_folder(folder, RenderSettings("car", seed=4, supersampling=1), SceneConfig(WIDTH, HEIGHT), 1, 3, 1, False)
    return folder


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Model]:
    """A new model of blocks under varying light, and where it is stored."""
    path = tmp_path_factory.mktemp("run") / "checkpoint.safetensors"
    model = new_model()
    save_model(path, model)
    return path, model


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "glb"])
def test_all_pictures_give_one_mesh_and_a_sheet(
    checkpoint: tuple[Path, Model], pictures: Path, tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, _ = checkpoint
    output = tmp_path / f"car.{kind}"
    options = ["--checkpoint", str(path), "--images", str(pictures), "--output", str(output), "--refine", "0"]
    assert run(["reconstruct", *options]) == 0
    assert "car from 3 pictures" in capsys.readouterr().out
    views = load_image_folder(pictures, WIDTH, HEIGHT).batch(np.arange(3))
    subject = from_checkpoint(load_checkpoint(path))
    together, alone = answer(subject, views, 3), answer(subject, views, 1)
    assert torch.equal(together.azimuths, alone.azimuths)
    # What is made of three codes is none of them.
    assert all(not torch.allclose(together.vertices[0], single, atol=1e-4) for single in alone.vertices)
    found = trimesh.load(output, force="mesh", process=False)
    np.testing.assert_allclose(
        found.bounds, np.stack((together.vertices[0].amin(0), together.vertices[0].amax(0))), atol=1e-5
    )
    assert len(found.faces) == 6 * 44
    with Image.open(output.with_suffix(".png")) as sheet:
        assert sheet.width > 4 * WIDTH


@pytest.mark.parametrize(
    ("own", "steps", "renderings", "brought"),
    [(True, 5, True, 3), (True, 0, True, 0), (False, 5, True, 0), (True, 5, False, 0)],
)
def test_own_pictures_are_brought_to_where_a_model_of_renderings_sees_their_object(
    checkpoint: tuple[Path, Model],
    pictures: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    own: bool,
    steps: int,
    renderings: bool,
    brought: int,
) -> None:
    """A model that learnt from pictures whose objects were cut out sees them where the rule sets them."""
    folder, path, calls = tmp_path / "views", tmp_path / "checkpoint.safetensors", []
    folder.mkdir()
    for file in pictures.rglob("*.png"):
        with Image.open(file) as view:
            seen = np.asarray(view.convert("RGB").resize((4 * WIDTH, 4 * HEIGHT)))
        white = np.where(seen.max(2, keepdims=True) > 8, seen, 255).astype(np.uint8)
        Image.fromarray(np.pad(white, ((40, 40), (60, 60), (0, 0)), constant_values=255)).save(folder / file.name)
    trained = load_checkpoint(checkpoint[0])
    save_checkpoint(path, replace(trained, run=trained.run | {"reframing_steps": steps, "framed": renderings}))

    def spied(picture: np.ndarray, drawing: np.ndarray) -> np.ndarray:
        calls.append(picture.shape)
        return aligned(picture, drawing)

    monkeypatch.setattr(reconstruct, "aligned", spied)
    views = folder if own else pictures
    arguments = ["--checkpoint", str(path), "--images", str(views), "--output", str(tmp_path / "car.ply")]
    assert run(["reconstruct", *arguments, "--refine", "1"]) == 0
    assert calls == brought * [(3, HEIGHT, WIDTH)]


def test_the_blocks_of_a_glb_are_nodes_and_a_turntable_is_asked_for(
    checkpoint: tuple[Path, Model], pictures: Path, tmp_path: Path
) -> None:
    arguments = ["reconstruct", "--checkpoint", str(checkpoint[0]), "--images", str(pictures)]
    assert run([*arguments, "--output", str(tmp_path / "car.glb")]) == 0
    scene = trimesh.load(tmp_path / "car.glb")
    assert set(scene.graph.nodes_geometry) == {f"block-{number}" for number in range(1, 7)}
    assert not (tmp_path / "car.webp").exists()
    assert run([*arguments, "--output", str(tmp_path / "car.glb"), "--turntable"]) == 0
    views = load_image_folder(pictures, WIDTH, HEIGHT).batch(np.arange(3))
    # Unless told otherwise, it looks three times.
    found = answer(replace(from_checkpoint(load_checkpoint(checkpoint[0])), refinement=3), views, 3)
    moments = found.vertices[:1].expand(FRAMES, -1, -1, -1)
    expected = turntable(checkpoint[1].faces, SceneConfig(WIDTH, HEIGHT), moments, found.azimuths[0].item())
    assert (tmp_path / "car.webp").read_bytes() == expected


def test_refined_it_explains_the_pictures_better(
    checkpoint: tuple[Path, Model], pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, model = checkpoint
    options = ["--checkpoint", str(path), "--images", str(pictures), "--output", str(tmp_path / "car.ply")]
    assert run(["reconstruct", *options, "--refine", "4"]) == 0
    capsys.readouterr()
    views = load_image_folder(pictures, WIDTH, HEIGHT).batch(np.arange(3))
    subject = from_checkpoint(load_checkpoint(path))
    misfits = []
    for iterations in (0, 4):
        found = answer(replace(subject, refinement=iterations), views, 3)
        assert torch.equal(found.vertices[0], found.vertices[2])
        assert found.light_azimuths is not None
        drawn = render(model.faces, SceneConfig(WIDTH, HEIGHT), found.vertices, found.azimuths, found.light_azimuths)
        misfits.append(float((drawn - views).square().sum()))
    assert misfits[1] < 0.9 * misfits[0]
    mesh = trimesh.load(tmp_path / "car.ply", force="mesh", process=False)
    np.testing.assert_allclose(mesh.bounds[1], found.vertices[0].amax(0), atol=1e-5)


def test_what_it_cannot_do_is_said(
    checkpoint: tuple[Path, Model], pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["reconstruct", "--checkpoint", str(checkpoint[0]), "--images"]
    assert run([*arguments, str(pictures), "--output", str(tmp_path / "car.dae")]) == 2
    assert "Expected --output to end in .ply, .obj, .stl, .glb" in capsys.readouterr().err
    assert run([*arguments, str(pictures), "--output", str(tmp_path / "car.ply"), "--refine", "101"]) == 2
    assert "Expected --refine from 0 to 100, found 101" in capsys.readouterr().err
    assert run([*arguments, str(tmp_path)]) == 2
    assert "expected pictures" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
