"""`scene.json`: camera, lights and size of a folder of pictures, beside them."""

import json
from pathlib import Path

from trainer.config import SceneConfig
from trainer.data.lens import MOST_ZOOM
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError, DataError
from trainer.mapping import from_mapping, to_mapping

SCENE_FILE = "scene.json"


def write_scene(folder: Path, scene: SceneConfig) -> None:
    """Writes `scene.json` into the folder. Raises StorageError where that is impossible."""
    write_bytes(folder / SCENE_FILE, (json.dumps(to_mapping(scene), indent=2) + "\n").encode())


def read_scene(folder: Path) -> SceneConfig | None:
    """The scene of a folder, or None where it has no `scene.json`. Absent keys take their defaults.

    Raises DataError, naming the key, for unknown keys, values of a wrong type, and values out of range.
    """
    path = folder / SCENE_FILE
    if not path.exists():
        return None
    try:
        scene = from_mapping(SceneConfig, json.loads(path.read_text(encoding="utf-8")), "the scene")
        check_scene(scene)
    except ConfigError as error:
        raise DataError(f"{path}: {error}") from error
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: expected a JSON object, found {error}; mend it or delete it") from error
    return scene


def check_scene(scene: SceneConfig) -> None:
    """Raises ConfigError, naming the setting, for what cannot be drawn; NaN is out of every range."""
    camera = scene.camera
    ranges = [
        ("width", scene.width, 1, 8192),
        ("height", scene.height, 1, 8192),
        ("camera: elevation_degrees", camera.elevation_degrees, -89.9, 89.9),
        # Every object then lies beyond the depth from which on the renderers draw things as they are.
        ("camera: distance", camera.distance, 0.56, 1e4),
        ("camera: field_of_view_degrees", camera.field_of_view_degrees, 0.1, 170.0),
        ("zoom", scene.zoom, 1.0, MOST_ZOOM),
        *((f"ambient[{channel}]", value, 0.0, 1e3) for channel, value in enumerate(scene.ambient)),
    ]
    for index, light in enumerate(scene.lights):
        ranges += [
            (f"lights[{index}]: azimuth_degrees", light.azimuth_degrees, -360.0, 360.0),
            (f"lights[{index}]: elevation_degrees", light.elevation_degrees, -90.0, 90.0),
            *((f"lights[{index}]: colour[{channel}]", value, 0.0, 1e3) for channel, value in enumerate(light.colour)),
        ]
    for key, value, low, high in ranges:
        if not low <= value <= high:
            raise ConfigError(f"{key}: expected {low} to {high}, found {value}; correct it")
