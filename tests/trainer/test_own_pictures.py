"""`trainer train` on people's own pictures: what was done to them is said and shown before the training starts."""

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.imaging.photographs import before, boards, cutout, photographed, plain, transparent
from trainer.__main__ import main
from trainer.config import WHITE_AMBIENT, WHITE_RIG, SceneConfig
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.training.checkpoint import load_checkpoint

CARS = [cutout("car", seed, 0.7 * seed, 0.7) for seed in range(6)]


@pytest.fixture
def settings(tmp_path: Path) -> Path:
    path = tmp_path / "settings.toml"
    path.write_text(
        "width = 32\nheight = 24\n[model]\nsegments = 2\nencoder_channels = [4, 4, 8, 8, 8, 16]\n"
        "[optimiser]\nbatch_size = 2\nsteps = 1\n"
    )
    return path


def trained(
    capsys: pytest.CaptureFixture[str], pictures: Path, run: Path, settings: Path, *more: str
) -> tuple[int, str]:
    """(status, standard error in one line) of a training of one step."""
    options = ["--images", pictures, "--run", run, "--class", "car", "--preset", settings, "--threads", "1", *more]
    status = main(["train", *map(str, options)])
    return status, re.sub(r"\s+", " ", capsys.readouterr().err)


def own_pictures(folder: Path) -> Path:
    """Three photographs, two cutouts, one photograph that has to be refused."""
    folder.mkdir()
    for index, car in enumerate(CARS[:3]):
        (folder / f"{index}.jpg").write_bytes(photographed(before(car, plain(0.9, 0.9, 0.9)), 2, 90))
    for index, car in enumerate(CARS[3:5]):
        (folder / f"{3 + index}.png").write_bytes(transparent(car))
    (folder / "5.jpg").write_bytes(photographed(before(CARS[5], boards()), 2, 90))
    return folder


def test_own_pictures_are_said_and_shown(
    tmp_path: Path, settings: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    pictures, run = own_pictures(tmp_path / "mine"), tmp_path / "run"
    status, errors = trained(capsys, pictures, run, settings)
    assert status == 0
    assert "5 pictures of 5 objects, car" in errors
    assert "2 pictures cut out by their transparency, and framed" in errors
    assert "3 pictures with a plain background, which was found and removed, and framed" in errors
    assert "1 pictures refused:" in errors
    assert "this is what is trained on" in errors
    (warning,) = caplog.messages
    sentence = "refused 1 of 6 pictures whose object cannot be told from its background; first: "
    assert warning.startswith(f"{sentence}{pictures / '5.jpg'}: expected a plain background")
    assert (run / "refused.txt").read_text().startswith(f"{pictures / '5.jpg'}: expected a plain background, found")
    sheet = np.asarray(Image.open(run / "prepared.png").convert("RGB")).astype(int)
    # A title of 16 pixels, then pairs of 32 × 24: an original before light grey, and what was made of it on black.
    original, prepared = sheet[18:42, 2:34], sheet[18:42, 36:68]
    assert original[2, 2].min() > 200
    assert prepared[[0, -1]].max() == 0
    assert prepared[8:18, 10:24].max() > 100
    # Four pairs in a row, and the fifth in the next.
    assert sheet.shape == (16 + 2 * 26 + 2, 8 * 34 + 2, 3)
    assert (run / "checkpoint.safetensors").exists()
    assert trained(capsys, pictures, run, settings, "--resume")[0] == 0


def test_of_rendered_pictures_nothing_is_said(
    tmp_path: Path, settings: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    render_folder(tmp_path / "cars", RenderSettings("car"), SceneConfig(32, 24), 6, 1, 1, show_progress=False)
    status, errors = trained(capsys, tmp_path / "cars", tmp_path / "run", settings)
    assert status == 0
    assert "6 pictures of 6 objects, car" in errors
    assert "background" not in errors
    assert not caplog.messages
    assert not (tmp_path / "run/prepared.png").exists()


def test_training_does_not_start_where_most_pictures_are_refused(
    tmp_path: Path, settings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pictures = tmp_path / "mine"
    pictures.mkdir()
    for index, car in enumerate(CARS[:5]):
        busy = boards(index) if index > 1 else plain(1, 1, 1)
        (pictures / f"{index}.jpg").write_bytes(photographed(before(car, busy), 2, 90))
    status, errors = trained(capsys, pictures, tmp_path / "run", settings)
    assert status == 2
    assert f"3 of the 5 pictures in {pictures} show an object that cannot be told from its background" in errors
    assert "cut the objects out with a picture editor, or leave the other pictures away" in errors
    assert not (tmp_path / "run").exists()


def test_own_pictures_are_lit_and_taken_as_the_user_says_and_a_resume_remembers(
    tmp_path: Path, settings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pictures, run = own_pictures(tmp_path / "mine"), tmp_path / "run"
    told = ("--rig", "white", "--camera.elevation-degrees", "20")
    assert trained(capsys, pictures, run, settings, *told)[0] == 0
    scene = load_checkpoint(run).scene
    assert (scene.lights, scene.ambient) == (WHITE_RIG, WHITE_AMBIENT)
    assert scene.camera.elevation_degrees == 20
    for again in ((), told):
        assert trained(capsys, pictures, run, settings, "--resume", *again)[0] == 0
    status, errors = trained(capsys, pictures, run, settings, "--resume", "--rig", "colour", *told[2:])
    assert status == 2
    assert "another camera or other lights than these" in errors


@pytest.mark.parametrize(
    ("rendered", "options", "sentence"),
    [
        (False, ["--rotate-lights"], "Expected --rotate-lights only for views that are drawn, found it beside"),
        (False, ["--instances", "7"], "Expected --instances only for views that are drawn"),
        (True, ["--rig", "white"], "Expected --rig only for pictures whose scene is not known, but"),
        (True, ["--camera.distance", "3"], "Expected --camera only for pictures whose scene is not known, but"),
    ],
)
def test_options_of_drawn_views_are_refused_beside_pictures(
    tmp_path: Path,
    settings: Path,
    capsys: pytest.CaptureFixture[str],
    rendered: bool,
    options: list[str],
    sentence: str,
) -> None:
    if rendered:
        render_folder(tmp_path / "mine", RenderSettings("car"), SceneConfig(32, 24), 3, 1, 1, show_progress=False)
    else:
        own_pictures(tmp_path / "mine")
    status, errors = trained(capsys, tmp_path / "mine", tmp_path / "run", settings, *options)
    assert status == 2
    assert sentence in errors
    assert not (tmp_path / "run").exists()


def test_a_row_of_a_table_is_trained_in_its_own_light(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    render_folder(tmp_path / "cars", RenderSettings("car"), SceneConfig(64, 48), 3, 1, 1, show_progress=False)
    row = ["train", "--preset", "table-3/white/car", "--run", str(tmp_path / "run"), "--optimiser.steps", "1"]
    assert main([*row, "--images", str(tmp_path / "cars")]) == 2
    errors = re.sub(r"\s+", " ", capsys.readouterr().err)
    assert "Expected pictures lit by the rig white, as table-3/white/car has it, found others in" in errors
    small = ["--optimiser.batch-size", "2", "--instances", "4", "--threads", "1"]
    assert main([*row, "--class", "car", *small]) == 0
    assert load_checkpoint(tmp_path / "run").scene.lights == WHITE_RIG
    varying = ["--preset", "table-4/varying-colour/car", "--run", str(tmp_path / "varying")]
    assert main([*row[:1], *varying, *row[5:], "--class", "car", *small]) == 0
    assert load_checkpoint(tmp_path / "varying").run["fresh"]["rotate_lights"]


def test_own_pictures_are_looked_at_as_closely_as_they_allow_and_a_resume_remembers(
    tmp_path: Path, settings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pictures, run = own_pictures(tmp_path / "mine"), tmp_path / "run"
    status, errors = trained(capsys, pictures, run, settings, "--zoom", "0")
    assert status == 0
    zoom = load_checkpoint(run).scene.zoom
    assert 1.05 < zoom < 2
    assert f"the middle of each picture is looked at, {zoom:g} times as large" in errors
    assert trained(capsys, pictures, run, settings, "--resume", "--optimiser.steps", "2")[0] == 0
    assert load_checkpoint(run).scene.zoom == zoom
    status, errors = trained(capsys, pictures, tmp_path / "other", settings, "--zoom", "0.5")
    assert status == 2
    assert "Expected zoom from 1 to 8, found 0.5" in errors
