"""scene.json: what is written is read back, and what is wrong is named."""

import json
from pathlib import Path
from typing import Any

import pytest

from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.data.scene import SCENE_FILE, read_scene, write_scene
from trainer.errors import DataError


def test_a_scene_survives_its_file(tmp_path: Path) -> None:
    lights = (DirectionalLight(10.0, -20.0, (0.1, 0.2, 0.3)),)
    scene = SceneConfig(33, 44, CameraConfig(-5.0, 3.5, 12.25), lights, (0.5, 0.0, 0.25))
    for one in (SceneConfig(), scene):
        write_scene(tmp_path, one)
        assert read_scene(tmp_path) == one


def test_absent_files_and_keys_mean_defaults(tmp_path: Path) -> None:
    assert read_scene(tmp_path) is None
    (tmp_path / SCENE_FILE).write_text('{"camera": {"distance": 4}}')
    assert read_scene(tmp_path) == SceneConfig(camera=CameraConfig(distance=4.0))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"hieght": 96}, "'hieght'; did you mean 'height'"),
        ({"camera": {"elevation": 3}}, "camera.*'elevation'; did you mean 'elevation_degrees'"),
        ({"lights": [{"azimuth_degrees": 1.0, "elevation_degrees": 2.0}]}, "lights.*'colour' is missing"),
        ({"width": "128"}, "width: expected a whole number, found '128'"),
        ({"ambient": [0.0, 0.0]}, "ambient: expected a list of 3 values"),
        ({"width": 0}, "width: expected 1 to 8192, found 0"),
        ({"camera": {"distance": 0.4}}, "distance: expected 0.56 to"),
        ({"camera": {"field_of_view_degrees": 180.0}}, "field_of_view_degrees: expected 0.1 to 170"),
        ({"ambient": [0.0, -1.0, 0.0]}, r"ambient\[1\]: expected 0.0 to"),
        ({"camera": {"elevation_degrees": float("nan")}}, "elevation_degrees: expected"),
        ([1, 2], "expected a table of settings"),
    ],
)
def test_wrong_content_is_named(tmp_path: Path, content: Any, message: str) -> None:
    (tmp_path / SCENE_FILE).write_text(json.dumps(content))
    with pytest.raises(DataError, match=message):
        read_scene(tmp_path)


def test_what_is_not_json_is_refused(tmp_path: Path) -> None:
    (tmp_path / SCENE_FILE).write_text("{")
    with pytest.raises(DataError, match="expected a JSON object"):
        read_scene(tmp_path)
