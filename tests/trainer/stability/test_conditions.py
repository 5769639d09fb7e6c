"""Conditions begin with untouched pictures, and change them the same way on every call; cameras and lights."""

import math

import numpy as np
import pytest

from imaging.srgb import decode_table
from trainer.data.scene import check_scene
from trainer.stability.conditions import CONDITIONS, DAMAGES, SCENES, Condition, Sitting, pictures_under
from trainer.stability.damages import box_of
from trainer.stability.scenes import lens, lights_raised, lights_turned, lights_whiter, raised


@pytest.mark.parametrize("condition", CONDITIONS, ids=lambda condition: condition.name)
def test_a_condition_leaves_nothing_as_it_was_but_at_its_first_severity(condition: Condition, sitting: Sitting) -> None:
    first, *others = condition.severities
    assert np.array_equal(pictures_under(condition, sitting, first, 0), sitting.codes)
    changes = []
    for severity in others:
        altered = pictures_under(condition, sitting, severity, 0)
        assert altered.shape == sitting.codes.shape
        assert altered.dtype == np.uint8
        assert np.array_equal(altered, pictures_under(condition, sitting, severity, 0))
        changes.append(float(np.abs(altered - sitting.codes.astype(float)).mean()))
    assert 0 < changes[0] < changes[-1]


def test_names_tell_conditions_apart() -> None:
    assert len({condition.name for condition in CONDITIONS}) == len(CONDITIONS) == len(DAMAGES) + len(SCENES)


def test_what_is_drawn_at_random_does_not_depend_on_severity(sitting: Sitting) -> None:
    (cut,) = (condition for condition in DAMAGES if condition.name == "cut")
    little, much = (pictures_under(cut, sitting, severity, 0) for severity in cut.severities[3:5])
    assert not ((little == 0) & (much > 0)).any()


def test_a_wide_lens_nearby_shows_the_object_as_large(sitting: Sitting) -> None:
    for severity in (0.2, 2.5):
        scene, light = lens(sitting.scene, severity)
        camera, usual = scene.camera, sitting.scene.camera
        assert light == 0
        assert camera.distance * math.tan(math.radians(camera.field_of_view_degrees) / 2) == pytest.approx(
            usual.distance * math.tan(math.radians(usual.field_of_view_degrees) / 2)
        )
    (nearer,) = (condition for condition in SCENES if condition.name == "nearer")
    boxes = [
        [box_of(picture) for picture in pictures_under(nearer, sitting, severity, 0)]
        for severity in nearer.severities[:2]
    ]
    widths = np.array([[box.right - box.left for box in some] for some in boxes])
    assert np.abs(widths[0] - widths[1]).max() <= 3


def test_the_camera_stops_straight_above(sitting: Sitting) -> None:
    assert raised(sitting.scene, 10)[0].camera.elevation_degrees == 40
    assert raised(sitting.scene, -45)[0].camera.elevation_degrees == -15
    assert raised(sitting.scene, 100)[0].camera.elevation_degrees == 89
    for condition in SCENES:
        if condition.name.startswith("camera"):
            for severity in condition.severities:
                check_scene(raised(sitting.scene, severity)[0])


def test_lights_turn_rise_and_whiten(sitting: Sitting) -> None:
    scene, turn = lights_turned(sitting.scene, 90)
    assert (scene, turn) == (sitting.scene, pytest.approx(math.pi / 2))
    assert lights_raised(sitting.scene, 80)[0].lights[0].elevation_degrees == 90
    white = lights_whiter(sitting.scene, 1)[0].lights
    assert all(light.colour == pytest.approx((1 / 3, 1 / 3, 1 / 3)) for light in white)
    (whiter,) = (condition for condition in SCENES if condition.name == "lights-whiter")
    light = decode_table()[pictures_under(whiter, sitting, 1, 0)]
    assert np.abs(light - light.mean(1, keepdims=True)).max() < 1e-6
