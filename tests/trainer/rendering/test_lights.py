"""One drawing under several lights is as many drawings: values, gradients, and the picture that the data shows."""

import dataclasses
import math

import numpy as np
import pytest
import torch
from torch import Tensor

from rasteriser import likelihood
from tests.rasteriser.scenes import Scene, random_scene
from trainer.config import COLOUR_RIG, WHITE_AMBIENT, WHITE_RIG, SceneConfig
from trainer.data.picture import draw
from trainer.data.shapes.solid import Mesh
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering import cpu, renderer
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade, shade_by_light

LIGHTS = 3
DEVICES: dict[renderer.Backend, str] = {"cpu": "cpu", "cuda": "cuda" if torch.cuda.is_available() else "cpu"}


def _hypotheses(scene: Scene, seed: int) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """(screen, colours [1, 2, V, L, C], picture, weights [1, 2, L]) in float64, of the mesh, and of it shifted."""
    rng = np.random.default_rng(seed)
    shift = torch.tensor([[0.0, 0.0, 0.0], [0.37, -0.61, 0.0]], dtype=torch.float64)
    screen = (torch.tensor(scene.screen).double() + shift[:, None])[None]
    colours = torch.tensor(rng.uniform(size=(1, 2, screen.shape[2], LIGHTS, 3)))
    weights = torch.tensor(rng.uniform(size=(1, 2, LIGHTS)))
    weights[0, 0, 1], weights[0, 1, 2] = 0.0, 1e-4
    return screen, colours, torch.tensor(scene.target).double()[None], weights


def _with_gradients(
    backend: renderer.Backend, scene: Scene, seed: int, crease: float, binarise: float
) -> tuple[list[Tensor], list[Tensor]]:
    """(log p and its expectation, gradients of the latter with respect to vertices and colours)"""
    screen, colours, picture, weights = _hypotheses(scene, seed)
    if backend != "reference":
        arguments = (screen, colours, picture, weights)
        screen, colours, picture, weights = (x.float().to(DEVICES[backend]) for x in arguments)
    screen.requires_grad_()
    colours.requires_grad_()
    options = (scene.topology, crease, binarise, backend)
    values = renderer.log_likelihood(screen, colours, picture, *options)
    expected = renderer.expected_log_likelihood(screen, colours, picture, weights, *options)
    expected.sum().backward()
    assert screen.grad is not None
    assert colours.grad is not None
    return [values.detach().cpu(), expected.detach().cpu()], [screen.grad.cpu(), colours.grad.cpu()]


@pytest.mark.parametrize("backend", DEVICES)
@pytest.mark.parametrize(("crease", "binarise"), [(0.0, 0.0), (math.inf, 0.0), (0.0, 0.1), (0.3, 0.0)])
def test_several_lights_at_once_are_those_of_the_reference(
    crease: float, binarise: float, backend: renderer.Backend
) -> None:
    # Without a GPU, the kernels of one are interpreted, which takes its time.
    for seed in range(40, 46 if DEVICES[backend] == backend else 41):
        scene = random_scene(seed)
        values, (to_screen, to_colours) = _with_gradients(backend, scene, seed, crease, binarise)
        true_values, (true_screen, true_colours) = _with_gradients("reference", scene, seed, crease, binarise)
        for found, expected in zip(values, true_values, strict=True):
            np.testing.assert_allclose(found, expected, rtol=2e-5, err_msg=f"seed {seed}")
        assert to_colours.shape == true_colours.shape
        pairs = [(to_screen[0], true_screen[0]), (to_colours.flatten(3)[0], true_colours.flatten(3)[0])]
        for found, expected in pairs:
            tolerance = 2e-5 * max(1.0, expected.abs().max().item())
            for pose in range(2):
                np.testing.assert_allclose(
                    scene.together(found[pose].numpy()),
                    scene.together(expected[pose].numpy()),
                    atol=tolerance,
                    err_msg=f"seed {seed}",
                )


@pytest.mark.parametrize("wanted", [(0,), (2,), (0, 2), (0, 1, 2)])
def test_each_light_is_as_if_it_were_alone_and_those_without_weight_are_left_out(wanted: tuple[int, ...]) -> None:
    scene = random_scene(3)
    screen, colours, picture, _ = (x.float().numpy() for x in _hypotheses(scene, 3))
    shapes, paints, scales = screen[0], colours[0], np.zeros((2, LIGHTS))
    scales[1, wanted] = 1.0 + np.arange(len(wanted))
    values, gradients = likelihood.log_likelihood_gradient(shapes, paints, scene.topology, picture, scales, np.inf)
    assert not values[0].any()
    summed = np.zeros_like(gradients.screen[1])
    for light in range(LIGHTS):
        alone = likelihood.log_likelihood_gradient(
            shapes[1:], paints[1:, :, light].copy(), scene.topology, picture, scales[1:, light].copy(), np.inf
        )
        assert (values[1, light], gradients.colours[1, :, light]) == (
            pytest.approx(alone[0][0]),
            pytest.approx(alone[1].colours[0], abs=1e-6),
        )
        summed += alone[1].screen[0]
    np.testing.assert_allclose(gradients.screen[1], summed, atol=1e-5 * np.abs(summed).max())
    assert summed.any()


def test_colours_of_another_number_of_channels_are_refused() -> None:
    scene = random_scene(3)
    screen, colours, picture, _ = (x.float().numpy() for x in _hypotheses(scene, 3))
    with pytest.raises(ValueError, match=r"\[N, V, C\] or \[N, V, L, C\] with the pictures' channels, found .*3, 2\]"):
        likelihood.log_likelihood(screen[0], colours[0, ..., :2], scene.topology, picture)


@pytest.mark.parametrize(("lights", "ambient"), [(COLOUR_RIG, (0.0, 0.0, 0.0)), (WHITE_RIG, WHITE_AMBIENT)])
@pytest.mark.parametrize("light_degrees", [0.0, 40.0, 135.0])
def test_the_lights_turn_as_they_do_in_the_data(lights: tuple, ambient: tuple, light_degrees: float) -> None:
    """The same box with the same smooth normals, drawn by the data's rasteriser and by the model's."""
    scene = dataclasses.replace(SceneConfig(48, 36), lights=lights, ambient=ambient)
    base = subdivided_cube(3, 0.5)
    vertices, faces = base.vertices * [1.0, 0.7, 1.3], base.faces
    azimuth, light_azimuth = 0.8, math.radians(light_degrees)
    normals = vertex_normals(torch.tensor(vertices), torch.tensor(faces))
    truth, _ = draw(Mesh(vertices, faces), azimuth, light_azimuth, scene, 16, normals.numpy()[faces])

    shape, turn = torch.tensor(vertices).float()[None], torch.tensor([azimuth])
    screen = project(shape, turn, scene.camera, scene.width, scene.height)
    facing = normals.float()[None]
    colours = shade_by_light(facing, turn, torch.tensor([[1.0, light_azimuth]]), scene)
    assert torch.allclose(colours[:, :, 0], shade(facing, turn - 1.0, scene), atol=1e-6)
    found = cpu.draw(screen, colours[:, :, 1], cpu.topology_of(torch.tensor(faces)), 48, 36, crease=0.0)
    difference = np.abs(found[0].permute(1, 2, 0).numpy() - truth)
    assert truth.max() > 0.5
    assert difference.max() < 0.03
    assert difference.mean() < 1e-3
