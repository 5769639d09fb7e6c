"""The service's pictures against the trainer's renderer: the same camera, the same light, the same object."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

import service.rendering.picture
from rasteriser.topology import build_topology
from service.inference import Engine, Surface, decode, sample_shape_code
from service.manifest import Light
from service.rendering.picture import draw, draw_all
from service.rendering.projection import project
from service.rendering.shading import shade
from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.rendering import camera, lighting, renderer

WIDTH, HEIGHT = 64, 48


@pytest.fixture(scope="module")
def surface(engine: Engine) -> Surface:
    return decode(engine, sample_shape_code(5, engine.manifest.latent, 0.5))


def scene(elevation: float, distance: float, field_of_view: float) -> SceneConfig:
    lights = (
        DirectionalLight(azimuth_degrees=30.0, elevation_degrees=20.0, colour=(1.0, 0.5, 0.0)),
        DirectionalLight(azimuth_degrees=200.0, elevation_degrees=-70.0, colour=(0.0, 0.2, 0.4)),
    )
    return SceneConfig(WIDTH, HEIGHT, CameraConfig(elevation, distance, field_of_view), lights, ambient=(0.1, 0.0, 0.2))


@pytest.mark.parametrize(
    ("view", "azimuth", "light_azimuth"),
    [((30.0, 2.0, 30.0), 0.0, 0.0), ((17.0, 2.3, 40.0), 0.9, 0.0), ((-40.0, 3.0, 20.0), -2.5, 1.1)],
)
def test_the_trainers_renderer_sees_the_same(
    engine: Engine, surface: Surface, view: tuple[float, float, float], azimuth: float, light_azimuth: float
) -> None:
    given = scene(*view)
    manifest = replace(
        engine.manifest,
        camera=replace(
            engine.manifest.camera, elevation_degrees=view[0], distance=view[1], field_of_view_degrees=view[2]
        ),
        lights=tuple(Light(one.azimuth_degrees, one.elevation_degrees, one.colour) for one in given.lights),
        ambient=given.ambient,
    )
    screen = project(surface.vertices, azimuth, manifest.camera, WIDTH, HEIGHT)
    colours = shade(surface.normals, azimuth, light_azimuth, manifest.lights, manifest.ambient)
    vertices, normals = (
        torch.from_numpy(part.astype(np.float64))[None] for part in (surface.vertices, surface.normals)
    )
    turn = torch.tensor([azimuth], dtype=torch.float64)
    expected_screen = camera.project(vertices, turn, given.camera, WIDTH, HEIGHT)
    expected_colours = lighting.shade_by_light(
        normals, turn, torch.tensor([[light_azimuth]], dtype=torch.float64), given
    ).squeeze(2)
    np.testing.assert_allclose(screen, expected_screen[0], atol=1e-9)
    np.testing.assert_allclose(colours, expected_colours[0], atol=1e-9)

    drawn = draw(screen, colours, engine.faces, WIDTH, HEIGHT, 8)
    topology = build_topology(engine.faces)
    expected = renderer.draw(expected_screen, expected_colours, topology, WIDTH, HEIGHT, backend="reference")[0]
    found = np.concatenate((drawn.colour, drawn.coverage[None]))
    assert 0.05 < drawn.coverage.mean() < 0.9
    assert np.abs(found - expected.numpy()).mean() < 0.004
    assert np.abs(found - expected.numpy()).max() < 0.35


def test_without_lights_there_is_ambient_light(engine: Engine, surface: Surface) -> None:
    colours = shade(surface.normals, 0.3, 0.0, (), (0.1, 0.2, 0.3))
    np.testing.assert_array_equal(colours, np.tile((0.1, 0.2, 0.3), (len(surface.normals), 1)))


@pytest.mark.parametrize("most", [1, 5 * WIDTH * 4, WIDTH * HEIGHT * 4])
def test_bands_make_the_whole_picture(
    engine: Engine, surface: Surface, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = engine.manifest
    screen = project(surface.vertices, 0.7, manifest.camera, WIDTH, HEIGHT)
    colours = shade(surface.normals, 0.7, 0.0, manifest.lights, manifest.ambient)
    whole = draw_all(screen[None], colours[None], engine.faces, WIDTH, HEIGHT, 2)
    monkeypatch.setattr(service.rendering.picture, "_MOST_SAMPLES", most)
    drawn = draw(screen, colours, engine.faces, WIDTH, HEIGHT, 2)
    np.testing.assert_allclose(drawn.colour, whole.colour[0], atol=1e-12)
    np.testing.assert_array_equal(drawn.coverage, whole.coverage[0])


def test_what_is_behind_the_camera_is_brought_before_it(engine: Engine) -> None:
    behind = project(np.array([[0.0, 0.0, 9.0]], np.float32), 0.0, engine.manifest.camera, WIDTH, HEIGHT)
    assert np.isfinite(behind).all()
    assert behind[0, 2] == pytest.approx(20)


def test_a_quarter_turn_brings_the_front_to_the_right(engine: Engine) -> None:
    front = np.array([[0.0, 0.0, 0.5]], np.float32)
    ahead, aside = (project(front, turn, engine.manifest.camera, WIDTH, HEIGHT)[0] for turn in (0.0, math.pi / 2))
    assert ahead[0] == pytest.approx(WIDTH / 2)
    assert aside[0] > WIDTH / 2 + 5
