"""A rendered folder: what it holds, that it continues where it stopped, and that it refuses to be mixed."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from imaging.srgb import encode
from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.data import writing
from trainer.data.metadata import read_metadata
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings, load_instance, read_settings, shape_seed
from trainer.data.render import render_folder
from trainer.data.scene import read_scene
from trainer.data.shapenet import SYNSETS
from trainer.data.shapes.catalogue import make_shape
from trainer.errors import ConfigError, DataError, StorageError

SCENE = SceneConfig(width=40, height=30)
CARS = RenderSettings("car", seed=3, supersampling=2)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def run(
    out: Path, settings: RenderSettings = CARS, instances: int | None = 3, views: int = 2, workers: int = 1
) -> object:
    return render_folder(out, settings, SCENE, instances, views, workers, show_progress=False)


def test_each_picture_is_what_its_row_says(tmp_path: Path) -> None:
    settings = RenderSettings("chair", seed=2, rotate_lights=True)
    report = render_folder(tmp_path, settings, SCENE, 3, 2, 1, show_progress=False)
    assert (report.written, report.kept, report.skipped) == (6, 0, ())
    rows = read_metadata(tmp_path)
    assert rows is not None
    assert len(rows) == 6
    assert len({row.instance for row in rows.values()}) == 3
    assert len({row.azimuth_degrees for row in rows.values()}) == 6
    assert len({row.light_azimuth_degrees for row in rows.values()}) == 6
    for name, row in rows.items():
        assert row.azimuth_degrees is not None
        assert row.light_azimuth_degrees is not None
        angles = math.radians(row.azimuth_degrees), math.radians(row.light_azimuth_degrees)
        colour, _ = draw(load_instance(settings, row.instance), *angles, SCENE, settings.supersampling)
        np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / name)), encode(colour))
    assert read_scene(tmp_path) == SCENE
    assert read_settings(tmp_path) == settings
    assert {path.name for path in tmp_path.iterdir()} == {"chair", "metadata.csv", "scene.json", "render.json"}


def test_an_instance_names_its_shape() -> None:
    assert shape_seed(3, 17) == 3_000_017
    np.testing.assert_array_equal(load_instance(CARS, "car-3000017").vertices, make_shape("car", 3_000_017).vertices)
    with pytest.raises(DataError, match="found 'car'"):
        load_instance(CARS, "car")


def test_azimuths_are_uniform_and_lights_fixed_unless_turned(tmp_path: Path) -> None:
    render_folder(tmp_path, RenderSettings("chair", supersampling=1), SceneConfig(2, 2), 40, 10, 1, show_progress=False)
    rows = (read_metadata(tmp_path) or {}).values()
    assert {row.light_azimuth_degrees for row in rows} == {0.0}
    azimuths = np.sort([row.azimuth_degrees or 0.0 for row in rows])
    assert azimuths.min() >= -180
    assert azimuths.max() < 180
    # Kolmogorov and Smirnov: a deviation of 1.63/√n happens once in a hundred samples.
    deviation = np.abs((azimuths + 180) / 360 - (np.arange(400) + 0.5) / 400).max()
    assert deviation < 1.63 / math.sqrt(400)


def test_an_interrupted_run_continues_to_the_same_folder(tmp_path: Path) -> None:
    run(tmp_path / "whole")
    run(tmp_path / "part")
    whole = contents(tmp_path / "whole")
    for name in sorted(name for name in whole if name.endswith(".png"))[2:]:
        (tmp_path / "part" / name).unlink()
    kept = {
        name: (tmp_path / "part" / name).stat().st_mtime_ns for name in contents(tmp_path / "part") if ".png" in name
    }
    report = render_folder(tmp_path / "part", CARS, SCENE, 3, 2, 1, show_progress=False)
    assert (report.written, report.kept) == (4, 2)
    assert contents(tmp_path / "part") == whole
    assert all((tmp_path / "part" / name).stat().st_mtime_ns == time for name, time in kept.items())


def test_more_instances_and_views_extend_a_folder(tmp_path: Path) -> None:
    run(tmp_path / "small", instances=2, views=1)
    small = contents(tmp_path / "small")
    run(tmp_path / "small", instances=4, views=2)
    run(tmp_path / "large", instances=4, views=2)
    large = contents(tmp_path / "large")
    grown = contents(tmp_path / "small")
    assert sorted(grown.pop("metadata.csv").splitlines()) == sorted(large.pop("metadata.csv").splitlines())
    assert grown == large
    assert all(large[name] == content for name, content in small.items() if name.endswith(".png"))
    run(tmp_path / "small", instances=1, views=1)
    assert len(read_metadata(tmp_path / "small") or {}) == 8


def test_several_processes_give_the_same_folder(tmp_path: Path) -> None:
    run(tmp_path / "one", instances=40, workers=1)
    run(tmp_path / "two", instances=40, workers=2)
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


@pytest.mark.parametrize(
    ("settings", "scene", "file"),
    [
        (RenderSettings("car", seed=4, supersampling=2), SCENE, "render.json"),
        (RenderSettings("car", seed=3, supersampling=4), SCENE, "render.json"),
        (CARS, SceneConfig(40, 30, CameraConfig(elevation_degrees=20.0)), "scene.json"),
    ],
)
def test_a_folder_of_other_settings_is_left_alone(
    tmp_path: Path, settings: RenderSettings, scene: SceneConfig, file: str
) -> None:
    run(tmp_path)
    before = contents(tmp_path)
    with pytest.raises(DataError, match=f"{file} holds other settings"):
        render_folder(tmp_path, settings, scene, 3, 2, 1, show_progress=False)
    assert contents(tmp_path) == before


def test_shapenet_is_rendered_by_its_split_and_what_it_lacks_is_counted(tmp_path: Path) -> None:
    root = tmp_path / "ShapeNetCore.v1"
    for number in range(6):
        (root / SYNSETS["chair"] / f"model{number}").mkdir(parents=True)
        if number != 3:
            text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"
            (root / SYNSETS["chair"] / f"model{number}" / "model.obj").write_text(text)
    lines = [f"0,{SYNSETS['chair']},,model{number},{'test' if number < 2 else 'train'}\n" for number in range(6)]
    (root / "all.csv").write_text("id,synsetId,subSynsetId,modelId,split\n" + "".join(lines))
    settings = RenderSettings(str(root), synset=SYNSETS["chair"], split="train")
    report = render_folder(tmp_path / "out", settings, SCENE, None, 2, 1, show_progress=False)
    assert (report.written, len(report.skipped)) == (6, 1)
    assert "model3: expected model.obj" in report.skipped[0]
    rows = read_metadata(tmp_path / "out") or {}
    assert sorted({row.instance for row in rows.values()}) == ["model2", "model4", "model5"]
    assert all((tmp_path / "out" / name).is_file() and name.startswith("chair/model") for name in rows)
    assert read_settings(tmp_path / "out") == settings
    other = replace(settings, split="test")
    with pytest.raises(DataError, match=r"render\.json holds other settings .*: split: expected test, found train;"):
        render_folder(tmp_path / "out", other, SCENE, None, 2, 1, show_progress=False)


def test_a_folder_from_before_there_was_a_choice_is_continued(tmp_path: Path) -> None:
    run(tmp_path)
    (tmp_path / "render.json").write_text('{"source": "car", "seed": 3, "rotate_lights": false, "supersampling": 2}')
    assert render_folder(tmp_path, CARS, SCENE, 3, 2, 1, show_progress=False).kept == 6


def test_lights_may_turn_with_each_picture(tmp_path: Path) -> None:
    lights = (DirectionalLight(0.0, 0.0, (1.0, 1.0, 1.0)),)
    scene = SceneConfig(2, 2, lights=lights)
    settings = RenderSettings("chair", supersampling=1, rotate_lights=True)
    render_folder(tmp_path, settings, scene, 40, 10, 1, show_progress=False)
    angles = np.sort([row.light_azimuth_degrees or 0.0 for row in (read_metadata(tmp_path) or {}).values()])
    assert angles.min() >= 0
    assert angles.max() < 180
    assert np.abs(angles / 180 - (np.arange(400) + 0.5) / 400).max() < 1.63 / math.sqrt(400)


def test_a_full_disk_is_one_sentence_and_nothing_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, calls = writing.os.replace, []

    def full_after_five(source: Path, target: Path) -> None:
        calls.append(target)
        if len(calls) > 5:
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(writing.os, "replace", full_after_five)
    with pytest.raises(StorageError, match=r"No space left on device\. Make room"):
        run(tmp_path)
    monkeypatch.undo()
    assert sum(name.endswith(".png") for name in contents(tmp_path)) == 2
    assert not [name for name in contents(tmp_path) if "part" in name]
    run(tmp_path)
    assert sum(name.endswith(".png") for name in contents(tmp_path)) == 6


@pytest.mark.parametrize(
    ("settings", "instances", "views", "message"),
    [
        (RenderSettings("cra"), 3, 1, "did you mean 'car'"),
        (RenderSettings("car", seed=-1), 3, 1, "seed of 0 or more"),
        (RenderSettings("car"), None, 1, "instances of a procedural class, found None"),
        (RenderSettings("car"), 0, 1, "at least one instance"),
        (RenderSettings("car"), 3, 0, "at least one instance, view"),
    ],
)
def test_senseless_settings_are_refused_before_anything_is_written(
    tmp_path: Path, settings: RenderSettings, instances: int | None, views: int, message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        render_folder(tmp_path / "out", settings, SCENE, instances, views, 1, show_progress=False)
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("x")
    with pytest.raises(DataError, match="found a file"):
        run(tmp_path / "out")


def test_meshes_of_files_may_look_inward(tmp_path: Path) -> None:
    mesh = make_shape("chair", 5)
    for name, faces in (("outward", mesh.faces), ("inward", mesh.faces[:, ::-1])):
        (tmp_path / name).mkdir()
        trimesh.Trimesh(mesh.vertices, faces, process=False).export(tmp_path / name / "it.ply")
        run(tmp_path / f"{name} pictures", RenderSettings(str(tmp_path / name)), None, 1)
    pictures = [np.asarray(Image.open(tmp_path / f"{name} pictures" / name / "it.ply-00.png"), int)
                for name in ("outward", "inward")]  # fmt: skip
    assert pictures[0].max() > 50
    assert np.abs(pictures[0] - pictures[1]).mean() < 0.1
