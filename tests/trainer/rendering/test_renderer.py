"""The one door to the renderer: coverage, backgrounds, the silhouette loss, and the choice of a backend."""

import math

import numpy as np
import pytest
import torch

from rasteriser.pictures import HARD
from rasteriser.topology import build_topology
from tests.rasteriser.scenes import random_scene
from trainer.rendering import reference, renderer

BACKENDS: tuple[renderer.Backend, ...] = ("reference", "cpu")
SQUARE = torch.tensor([[[1.25, 2.5, 0.5], [5.75, 2.5, 0.5], [5.75, 4.125, 0.5], [1.25, 4.125, 0.5]]])
FACES = build_topology(np.array([[0, 1, 2], [0, 2, 3]]))


def square_coverage() -> np.ndarray:
    columns = np.clip(np.minimum(np.arange(8) + 1, 5.75) - np.maximum(np.arange(8), 1.25), 0, 1)
    rows = np.clip(np.minimum(np.arange(6) + 1, 4.125) - np.maximum(np.arange(6), 2.5), 0, 1)
    return np.outer(rows, columns)


@pytest.mark.parametrize("backend", ["cpu", "reference"])
def test_the_last_channel_is_coverage_and_the_background_shows_through(backend: renderer.Backend) -> None:
    colours = torch.tensor([0.2, 0.5, 0.9]).expand(1, 4, 3)
    background = torch.rand(1, 3, 6, 8, generator=torch.Generator().manual_seed(0), requires_grad=True)
    drawn = renderer.draw(SQUARE, colours, FACES, 8, 6, background, backend=backend)
    coverage = torch.tensor(square_coverage(), dtype=torch.float32)
    expected = coverage * colours[0, 0, :, None, None] + (1 - coverage) * background.detach()[0]
    np.testing.assert_allclose(drawn[0, 3].detach(), coverage, atol=1e-6)
    np.testing.assert_allclose(drawn[0, :3].detach(), expected, atol=1e-6)
    drawn[:, :3].sum().backward()
    assert background.grad is not None
    np.testing.assert_allclose(background.grad[0], np.broadcast_to(1 - coverage, (3, 6, 8)), atol=1e-6)


def test_a_uniform_background_is_the_same_as_other_colours_on_black() -> None:
    scene = random_scene(5)
    screen, colours = torch.tensor(scene.screen[None]), torch.tensor(scene.colours[None])
    grey = torch.full((1, 3, 1, 1), 0.4)
    found = renderer.draw(screen, colours, scene.topology, *scene.size, grey)[:, :3]
    expected = 0.4 + renderer.draw(screen, colours - 0.4, scene.topology, *scene.size)[:, :3]
    np.testing.assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize("crease", [0.0, 0.3, math.inf, HARD])
@pytest.mark.parametrize("binarise", [0.0, 0.05])
def test_backends_agree_on_likelihoods(crease: float, binarise: float) -> None:
    scene = random_scene(13)
    shift = torch.tensor([0.0, 0.6, -0.8])[None, :, None, None] * torch.tensor([1.0, 0.5, 0.0])
    pictures = torch.tensor(np.stack((scene.target, scene.target[:, ::-1])).copy())
    weights = torch.tensor([[0.7, 0.3, 0.0], [0.1, 0.2, 0.7]])
    found = {}
    for backend, number in (("cpu", torch.float32), ("reference", torch.float64)):
        screen = (torch.tensor(scene.screen) + shift).expand(2, -1, -1, -1).to(number).requires_grad_()
        colours = torch.tensor(scene.colours).expand(2, 3, -1, -1).to(number).requires_grad_()
        arguments = screen, colours, pictures.to(number)
        every = renderer.log_likelihood(*arguments, scene.topology, crease, binarise, backend)
        mean = renderer.expected_log_likelihood(
            *arguments, weights.to(number), scene.topology, crease, binarise, backend
        )
        gradients = torch.autograd.grad(mean.sum() + every[:, 1].sum(), (screen, colours))
        found[backend] = [part.detach().double() for part in (every, mean, *gradients)]
    for mine, theirs in zip(found["cpu"], found["reference"], strict=True):
        np.testing.assert_allclose(mine, theirs, atol=1e-5 * max(1.0, theirs.abs().max().item()))


def test_the_silhouette_loss_cares_for_shape_and_hardly_for_colour() -> None:
    """p / (p + η) is all but one for every colour much brighter than η."""
    target = torch.zeros(1, 3, 6, 8)
    target[0] = torch.tensor(square_coverage(), dtype=torch.float32) * 0.8
    moved = SQUARE + torch.tensor([1.0, 0.0, 0.0])
    values = {}
    for name, screen, brightness in (("same", SQUARE, 0.8), ("darker", SQUARE, 0.3), ("moved", moved, 0.8)):
        colours = torch.full((1, 1, 4, 3), brightness)
        for eta in (0.0, 1e-3):
            values[name, eta] = renderer.log_likelihood(
                screen[None], colours, target, FACES, binarise=eta, backend="cpu"
            ).item()
    assert values["same", 0.0] == pytest.approx(0, abs=1e-6)
    assert values["darker", 0.0] < 0.2 * values["moved", 0.0] < 0
    assert 0 > values["darker", 1e-3] > 0.01 * values["moved", 1e-3]


def test_the_silhouette_loss_is_the_paper_s_formula() -> None:
    picture, target = torch.rand(2, 3, 5, 7, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    expected = reference.log_likelihood(picture / (picture + 0.1), target / (target + 0.1))
    assert reference.log_likelihood(picture, target, binarise=0.1).item() == pytest.approx(expected.item())


def test_a_pixel_that_antialiasing_makes_negative_has_no_slope_in_the_silhouette_loss() -> None:
    """A contour takes away what lies on its near side, be the pixel's own colour another one: that may be too much."""
    screen = torch.tensor([[2.0, 0.5, 0.5], [2.45, 0.5, 0.5], [2.45, 5.5, 0.5], [2.0, 5.5, 0.5], [3.5, 3.0, 0.5]])
    faces = build_topology(np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]]))
    colours = torch.tensor([[1.0] * 3, [1.0] * 3, [1.0] * 3, [1.0] * 3, [0.0] * 3]).requires_grad_()
    target = torch.rand(1, 3, 6, 8, generator=torch.Generator().manual_seed(0))
    gradients = {}
    for backend in BACKENDS:
        number = torch.float64 if backend == "reference" else torch.float32
        paint = colours.detach().to(number).requires_grad_()
        value = renderer.log_likelihood(
            screen[None, None].to(number), paint[None, None], target.to(number), faces, math.inf, 0.05, backend
        )
        (gradients[backend],) = torch.autograd.grad(value.sum(), paint)
    np.testing.assert_allclose(gradients["cpu"], gradients["reference"], rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_is_not_finite_is_refused_by_the_number_of_the_first_bad_mesh(backend: renderer.Backend) -> None:
    screen = SQUARE.expand(2, 3, -1, -1).clone()
    colours, pictures = torch.ones(2, 3, 4, 3), torch.zeros(2, 3, 6, 8)
    screen[1, 1, 0, 0] = math.nan
    with pytest.raises(FloatingPointError, match="first in mesh 4"):
        renderer.log_likelihood(screen, colours, pictures, FACES, backend=backend)
    colours[0, 2, 1, 1] = math.inf
    with pytest.raises(FloatingPointError, match="first in mesh 2"):
        renderer.draw(screen[0], colours[0], FACES, 8, 6, backend=backend)


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_faces_and_no_meshes_are_black(backend: renderer.Backend) -> None:
    nothing = build_topology(np.zeros((0, 3), np.int64))
    assert not renderer.draw(torch.zeros(2, 4, 3), torch.ones(2, 4, 3), nothing, 8, 6, backend=backend).any()
    assert renderer.draw(torch.zeros(0, 4, 3), torch.ones(0, 4, 3), FACES, 8, 6, backend=backend).shape == (0, 4, 6, 8)
