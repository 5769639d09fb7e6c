"""Camera, lights and drawing in closed form, and against the definition of the camera written out by hand."""

import dataclasses
import math

import numpy as np
import pytest

from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.data.normals import corner_normals
from trainer.data.picture import draw, focal_length, light_direction, lit, rotation_about_y, to_camera
from trainer.data.shapes.catalogue import CATEGORIES, make_shape
from trainer.data.shapes.solid import Mesh, box

SCENE = SceneConfig()


def project(points: np.ndarray, scene: SceneConfig) -> np.ndarray:
    camera = to_camera(points, scene)
    scale = focal_length(scene) / camera[:, 2]
    return np.stack((scene.width / 2 + camera[:, 0] * scale, scene.height / 2 - camera[:, 1] * scale), -1)


def test_a_positive_azimuth_turns_the_front_towards_positive_x() -> None:
    np.testing.assert_allclose(rotation_about_y(math.pi / 2) @ (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), atol=1e-15)


def test_the_camera_sees_x_to_the_right_y_up_and_its_own_side_below() -> None:
    centre, right, above, near = project(np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)], float), SCENE)
    np.testing.assert_allclose(centre, (64.0, 48.0))
    assert right[0] > 64
    assert right[1] == pytest.approx(48.0)
    assert above[1] < 48
    assert near[1] > 48  # from 30° above, what is nearer stands lower in the picture


def test_a_point_is_projected_as_defined() -> None:
    scene = SceneConfig(100, 50, CameraConfig(elevation_degrees=90 - 1e-9, distance=3.0, field_of_view_degrees=90.0))
    # From straight above: the picture's up is -z, and a focal length of 25 pixels divides by the depth 3 - y.
    np.testing.assert_allclose(
        project(np.array([(0.3, 0.5, -0.2)]), scene), [(50 + 25 * 0.3 / 2.5, 25 - 25 * 0.2 / 2.5)]
    )


def test_an_object_of_unit_diagonal_fits() -> None:
    picture = draw(box((0.999, 0.02, 0.02)), 0.0, 0.0, SCENE)[1]
    assert picture.sum() > 100
    assert not picture[[0, -1]].any()
    assert not picture[:, [0, -1]].any()


def test_lights_stand_where_their_angles_say() -> None:
    expected = {(0, 0): (0, 0, 1), (90, 0): (1, 0, 0), (270, 0): (-1, 0, 0), (13, 90): (0, 1, 0)}
    for (azimuth, elevation), direction in expected.items():
        light = DirectionalLight(azimuth, elevation, (1.0, 1.0, 1.0))
        np.testing.assert_allclose(light_direction(light), direction, atol=1e-15)
    turned = light_direction(DirectionalLight(30.0, 20.0, (1.0, 1.0, 1.0)), math.radians(60))
    np.testing.assert_allclose(turned, light_direction(DirectionalLight(90.0, 20.0, (1.0, 1.0, 1.0))), atol=1e-15)


def test_light_is_lambertian_double_sided_additive_and_clipped() -> None:
    lights = (DirectionalLight(0, 0, (0.5, 0.0, 0.1)), DirectionalLight(90, 0, (0.0, 0.25, 0.1)))
    scene = SceneConfig(lights=lights, ambient=(0.0, 0.0, 0.875))
    half = math.sqrt(0.5)
    normals = np.array([(0, 0, 1), (0, 0, -1), (1, 0, 0), (half, 0, half), (0, 1, 0)], float)
    expected = [
        (0.5, 0, 0.975), (0.5, 0, 0.975), (0, 0.25, 0.975),
        (0.5 * half, 0.25 * half, 1.0), (0, 0, 0.875),
    ]  # fmt: skip
    np.testing.assert_allclose(lit(normals, scene), expected, atol=1e-12)
    np.testing.assert_allclose(lit(normals, SceneConfig(lights=(), ambient=(0.1, 0.2, 0.3)))[2], (0.1, 0.2, 0.3))


def test_the_lights_stay_with_the_camera_and_the_normals_turn_with_the_object() -> None:
    """A mesh turned by hand and drawn at azimuth 0 gives the picture of the mesh at that azimuth."""
    mesh = make_shape("car", 5)
    turned = Mesh(mesh.vertices @ rotation_about_y(0.8).T, mesh.faces)
    by_hand, by_azimuth = draw(turned, 0.0, 0.3, SCENE), draw(mesh, 0.8, 0.3, SCENE)
    np.testing.assert_allclose(by_hand[0], by_azimuth[0], atol=1e-5)
    np.testing.assert_allclose(by_hand[1], by_azimuth[1], atol=1e-6)


def test_a_face_towards_the_camera_has_its_light_and_its_place() -> None:
    """A wall of z = 0.1 seen head-on under a light from the camera's side: one exact rectangle of one exact colour."""
    camera = CameraConfig(elevation_degrees=0.0, distance=2.1, field_of_view_degrees=2 * math.degrees(math.atan(0.24)))
    scene = SceneConfig(96, 96, camera, (DirectionalLight(60.0, 0.0, (1.0, 0.5, 0.25)),))
    assert focal_length(scene) == pytest.approx(200.0)
    # The front of the box lies at depth 2, so 100 pixels a unit, and hides its other sides.
    colour, alpha = draw(box((0.4, 0.2, 0.2)), 0.0, 0.0, scene)
    expected = np.zeros((96, 96), np.float32)
    expected[38:58, 28:68] = 1.0
    np.testing.assert_array_equal(alpha, expected)
    np.testing.assert_allclose(colour, expected[..., None] * (0.5, 0.25, 0.125), atol=1e-6)


def test_given_normals_are_used() -> None:
    mesh = box((0.4, 0.4, 0.4))
    scene = dataclasses.replace(SCENE, lights=(DirectionalLight(0.0, 90.0, (1.0, 1.0, 1.0)),))
    upward = np.broadcast_to((0.0, 1.0, 0.0), (len(mesh.faces), 3, 3))
    colour, alpha = draw(mesh, 0.3, 0.0, scene, 4, upward)
    np.testing.assert_allclose(colour, np.repeat(alpha[..., None], 3, -1), atol=1e-6)
    assert not np.allclose(draw(mesh, 0.3, 0.0, scene, 4, corner_normals(mesh))[0], colour)


@pytest.mark.parametrize("category", sorted(CATEGORIES))
def test_solids_look_the_same_without_their_backs(category: str) -> None:
    for seed in range(4):
        mesh = make_shape(category, seed)
        whole, spared = (draw(mesh, 0.7 + 1.9 * seed, 0.0, SCENE, closed=closed) for closed in (False, True))
        np.testing.assert_array_equal(spared[1], whole[1])
        # Where two solids touch, either may win a sample; a solid that looked inward would lose whole faces.
        assert np.abs(spared[0] - whole[0]).mean() < 1e-4
