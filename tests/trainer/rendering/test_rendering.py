"""Camera and light by closed form, the reference by gradcheck, the autograd functions against the reference."""

import math

import numpy as np
import pytest
import torch

from tests.rasteriser.scenes import random_scene
from trainer.config import CameraConfig, DirectionalLight, SceneConfig
from trainer.rendering import cpu, reference
from trainer.rendering.camera import NEAREST_DEPTH, project
from trainer.rendering.lighting import light_directions, shade


def test_the_origin_is_seen_in_the_middle_at_the_camera_s_distance() -> None:
    screen = project(torch.zeros(1, 1, 3), torch.tensor([0.3]), CameraConfig(distance=2.5), 128, 96)
    np.testing.assert_allclose(screen[0, 0], [64, 48, 1 / 2.5], rtol=1e-6)


def test_up_is_up_right_is_right_and_the_front_is_near() -> None:
    level = CameraConfig(elevation_degrees=0.0)
    points = torch.tensor([[[0.0, 0.2, 0.0], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2]]])
    up, right, front = project(points, torch.zeros(1), level, 100, 80)[0]
    assert up[1] < 40 < right[0] < 100
    assert up[0] == 50
    assert front[2] == pytest.approx(1 / 1.8)
    # The top of the picture is half the field of view above the axis.
    edge = torch.tensor([[[0.0, 2 * math.tan(math.radians(15)), 0.0]]])
    assert project(edge, torch.zeros(1), level, 100, 80)[0, 0, 1] == pytest.approx(0, abs=1e-4)


def test_a_quarter_turn_brings_the_front_to_the_right_of_the_picture() -> None:
    front = torch.tensor([[[0.0, 0.0, 0.3]]])
    turned = project(front, torch.tensor([math.pi / 2]), CameraConfig(), 128, 96)[0, 0]
    assert turned[0] > 64 + 10
    assert turned[1] == pytest.approx(48, abs=1e-3)


def test_a_raised_camera_looks_down() -> None:
    top_front = torch.tensor([[[0.0, 0.0, 0.3]]])
    assert project(top_front, torch.zeros(1), CameraConfig(elevation_degrees=30), 128, 96)[0, 0, 1] > 48


def test_behind_the_camera_is_clamped_not_infinite() -> None:
    seen = project(torch.full((1, 1, 3), 50.0), torch.zeros(1), CameraConfig(), 128, 96)
    assert torch.isfinite(seen).all()
    assert seen[0, 0, 2] == pytest.approx(1 / NEAREST_DEPTH)


def test_light_falls_by_the_cosine_from_both_sides_and_stays_with_the_camera() -> None:
    side = DirectionalLight(azimuth_degrees=90.0, elevation_degrees=0.0, colour=(0.5, 0.0, 0.0))
    scene = SceneConfig(lights=(side,), ambient=(0.1, 0.2, 0.3))
    np.testing.assert_allclose(light_directions(scene, torch.zeros(1)), [[1, 0, 0]], atol=1e-6)
    normals = torch.tensor([[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8, 0.0]]])
    colours = shade(normals, torch.zeros(1), scene)[0]
    np.testing.assert_allclose(colours[:, 0], [0.6, 0.6, 0.1, 0.4], atol=1e-6)
    np.testing.assert_allclose(colours[:, 1:], [[0.2, 0.3]] * 4, atol=1e-6)
    # The object's front, turned by 90°, faces the light at the picture's right.
    front = torch.tensor([[[0.0, 0.0, 1.0]]])
    assert shade(front, torch.tensor([math.pi / 2]), scene)[0, 0, 0] == pytest.approx(0.6)
    assert shade(front, torch.zeros(1), scene)[0, 0, 0] == pytest.approx(0.1)


def test_a_light_is_met_by_turning_towards_it_not_away() -> None:
    light = DirectionalLight(azimuth_degrees=60.0, elevation_degrees=0.0, colour=(1.0, 1.0, 1.0))
    scene, front = SceneConfig(lights=(light,)), torch.tensor([[[0.0, 0.0, 1.0]]])
    assert shade(front, torch.tensor([math.pi / 3]), scene)[0, 0, 0] == pytest.approx(1.0)
    assert shade(front, torch.tensor([-math.pi / 3]), scene)[0, 0, 0] == pytest.approx(0.5)


def test_the_reference_s_gradient_is_that_of_its_picture() -> None:
    checked = 0
    for seed in range(40):
        scene = random_scene(seed)
        width, height = scene.size
        if len(scene.screen) > 30 or len(np.unique(scene.screen, axis=0)) < len(scene.screen):
            continue
        if len(np.unique(scene.screen[:, 2])) < len(scene.screen):
            continue  # Of faces at one depth, the difference itself would decide which is seen.
        faces = torch.tensor(scene.topology.faces.astype(np.int64))
        upstream = torch.tensor(np.random.default_rng(seed).normal(size=scene.target.shape))

        def value(screen: torch.Tensor, colours: torch.Tensor) -> torch.Tensor:
            return (reference.draw(screen, colours, faces, width, height) * upstream).sum()  # noqa: B023

        screen = torch.tensor(scene.screen, dtype=torch.float64, requires_grad=True)
        colours = torch.tensor(scene.colours, dtype=torch.float64, requires_grad=True)
        # Along random directions: one number at a time would take a minute, and tells no more.
        assert torch.autograd.gradcheck(value, (screen, colours), eps=1e-7, atol=1e-3, rtol=1e-3, fast_mode=True), seed
        checked += 1
    assert checked >= 10


def test_autograd_s_log_likelihood_of_several_hypotheses_is_the_reference_s() -> None:
    scene = random_scene(11)
    rng = np.random.default_rng(0)
    shift = rng.normal(scale=0.7, size=(2, 3, 1, 3)) * [1, 1, 0]
    screen = torch.tensor(scene.screen + shift, dtype=torch.float32, requires_grad=True)
    colours = torch.tensor(scene.colours).expand(2, 3, -1, -1).clone().requires_grad_()
    pictures = torch.tensor(np.stack((scene.target, scene.target[:, ::-1])).copy())
    weights = torch.tensor(rng.normal(size=(2, 3)), dtype=torch.float32)
    values = cpu.log_likelihood(screen, colours, pictures, scene.topology)
    (values * weights).sum().backward()

    faces = torch.tensor(scene.topology.faces.astype(np.int64))
    twin, paint = (x.detach().double().requires_grad_() for x in (screen, colours))
    expected = torch.stack(
        [
            torch.stack(
                [
                    reference.log_likelihood(
                        reference.draw(twin[b, r], paint[b, r], faces, *scene.size), pictures[b].double()
                    )
                    for r in range(3)
                ]
            )
            for b in range(2)
        ]
    )
    (expected * weights).sum().backward()
    np.testing.assert_allclose(values.detach(), expected.detach(), rtol=1e-5)
    for mine, theirs in ((screen.grad, twin.grad), (colours.grad, paint.grad)):
        assert mine is not None
        assert theirs is not None
        np.testing.assert_allclose(mine, theirs, atol=1e-5 * theirs.abs().max().item())


def test_an_expectation_is_the_weighed_sum_and_leaves_out_what_does_not_matter() -> None:
    scene = random_scene(11)
    screen = torch.tensor(scene.screen).expand(2, 3, -1, -1).clone()
    screen[:, 1, :, 0] += 0.6
    colours = torch.tensor(scene.colours).expand(2, 3, -1, -1)
    pictures = torch.tensor(np.stack((scene.target, scene.target[:, ::-1])).copy())
    weights = torch.tensor([[0.7, 0.3, 0.0], [0.2, 0.7999, 0.0001]])
    twin = screen.clone().requires_grad_()
    found = screen.clone().requires_grad_()
    value = cpu.expected_log_likelihood(found, colours, pictures, weights, scene.topology)
    kept = torch.where(weights < 1e-3, 0.0, weights)
    expected = (cpu.log_likelihood(twin, colours, pictures, scene.topology) * kept).sum(1)
    np.testing.assert_allclose(value.detach(), expected.detach(), rtol=1e-5)
    upstream = torch.tensor([1.5, -2.0])
    value.backward(upstream)
    expected.backward(upstream)
    assert found.grad is not None
    assert twin.grad is not None
    np.testing.assert_allclose(found.grad, twin.grad, atol=1e-4 * twin.grad.abs().max().item())
    assert not found.grad[:, 2].any()


def test_autograd_s_picture_is_the_reference_s() -> None:
    scene = random_scene(12)
    screen = torch.tensor(scene.screen[None], requires_grad=True)
    colours = torch.tensor(scene.colours[None], requires_grad=True)
    picture = cpu.draw(screen, colours, scene.topology, *scene.size)
    picture.square().sum().backward()
    faces = torch.tensor(scene.topology.faces.astype(np.int64))
    twin = torch.tensor(scene.screen, dtype=torch.float64, requires_grad=True)
    expected = reference.draw(twin, torch.tensor(scene.colours, dtype=torch.float64), faces, *scene.size)
    expected.square().sum().backward()
    np.testing.assert_allclose(picture[0].detach(), expected.detach(), atol=1e-5)
    assert screen.grad is not None
    assert twin.grad is not None
    np.testing.assert_allclose(screen.grad[0], twin.grad, atol=1e-4)


def test_reduction_of_a_constant_residual_is_constant_at_every_level() -> None:
    picture, target = torch.full((1, 96, 128), 0.5, dtype=torch.float64), torch.zeros(1, 96, 128, dtype=torch.float64)
    sizes = [(96, 128), (48, 64), (24, 32), (12, 16), (6, 8), (3, 4), (2, 2), (1, 1)]
    expected = -0.5 * sum(4**level * 0.25 * rows * columns for level, (rows, columns) in enumerate(sizes))
    assert reference.log_likelihood(picture, target).item() == pytest.approx(expected)
