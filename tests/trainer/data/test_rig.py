"""Lights by name and from a file: what is written is meant, and what is wrong is named."""

from pathlib import Path

import numpy as np
import pytest

from trainer.config import COLOUR_RIG, DirectionalLight, SceneConfig
from trainer.data.picture import light_direction, lit
from trainer.data.rig import Rig, load_rig, rig_names
from trainer.errors import ConfigError


def test_the_colour_rig_is_the_default_scene() -> None:
    assert load_rig("colour") == Rig(COLOUR_RIG) == Rig(SceneConfig().lights, SceneConfig().ambient)
    assert rig_names() == ["colour", "white"]


def test_the_white_rig_is_one_white_light_and_a_white_ambient() -> None:
    rig = load_rig("white")
    scene = SceneConfig(lights=rig.lights, ambient=rig.ambient)
    (light,) = rig.lights
    towards = light_direction(light)
    across = np.cross(towards, (0.0, 1.0, 0.0))
    colours = lit(np.stack((towards, -towards, across / np.linalg.norm(across))), scene)
    np.testing.assert_allclose(colours, [(1.0,) * 3, (1.0,) * 3, (0.2,) * 3], atol=1e-12)


def test_a_file_says_the_same_as_its_values(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        "ambient = [0.1, 0, 0.25]\n[[lights]]\nazimuth_degrees = 10\nelevation_degrees = -20.5\ncolour = [0.1, 1, 0]\n"
        "[[lights]]\nazimuth_degrees = 200\nelevation_degrees = 90\ncolour = [0.5, 0.5, 0.5]\n"
    )
    lights = (DirectionalLight(10.0, -20.5, (0.1, 1.0, 0.0)), DirectionalLight(200.0, 90.0, (0.5, 0.5, 0.5)))
    assert load_rig(str(path)) == Rig(lights, (0.1, 0.0, 0.25))
    path.write_text("ambient = [1, 1, 1]\n")
    assert load_rig(str(path)) == Rig((), (1.0, 1.0, 1.0))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("ambiant = [1, 1, 1]", r"mine\.toml: there is no setting 'ambiant'; did you mean 'ambient'\?"),
        (
            "[[lights]]\nazimuth_degrees = 1\nelevation_degrees = 2\ncolor = [1, 1, 1]",
            r"mine\.toml: lights\[0\]: there is no setting 'color'; did you mean 'colour'\?",
        ),
        ("[[lights]]\nazimuth_degrees = 1\ncolour = [1, 1, 1]", r"'elevation_degrees' is missing"),
        ("ambient = [1, 1]", "ambient: expected a list of 3 values"),
        ("ambient = ['red', 0, 0]", r"ambient\[0\]: expected a finite number, found 'red'"),
        ("ambient = [-1, 0, 0]", r"mine\.toml: ambient\[0\]: expected 0.0 to 1000.0, found -1.0"),
        ("ambient = [inf, 0, 0]", "expected a finite number"),
        ("ambient = [0, 0, 0]", r"mine\.toml: expected a light or an ambient colour above 0, found none"),
        ("", "found none. Add"),
        ("[lights", "expected a TOML file"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / "mine.toml").write_text(content)
    with pytest.raises(ConfigError, match=message):
        load_rig(str(tmp_path / "mine.toml"))


def test_names_and_paths_that_do_not_exist_are_answered(tmp_path: Path) -> None:
    with pytest.raises(
        ConfigError, match=r"no rig 'whit'; did you mean 'white'\? There are colour, white, and any file"
    ):
        load_rig("whit")
    with pytest.raises(ConfigError, match=r"absent\.toml cannot be read .*Check the path"):
        load_rig(str(tmp_path / "absent.toml"))
