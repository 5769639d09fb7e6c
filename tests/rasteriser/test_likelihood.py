"""The fused kernels against the readable reference, and against closed forms."""

import os

import numpy as np
import pytest
import torch

from rasteriser import likelihood, pictures
from rasteriser.topology import build_topology
from tests.rasteriser.scenes import Scene, random_scene
from trainer.rendering import reference


def _reference(scene: Scene, crease: float) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
    screen = torch.tensor(scene.screen, dtype=torch.float64, requires_grad=True)
    colours = torch.tensor(scene.colours, dtype=torch.float64, requires_grad=True)
    picture = reference.draw(screen, colours, torch.tensor(scene.topology.faces.astype(np.int64)), *scene.size, crease)
    value = reference.log_likelihood(picture, torch.tensor(scene.target, dtype=torch.float64))
    value.backward()
    gradients = [np.zeros(x.shape) if x.grad is None else x.grad.numpy() for x in (screen, colours)]
    return picture.detach().numpy(), value.item(), gradients[0], gradients[1]


# The reference takes its time: `make test` looks at a fifth of the scenes, SCENES=1000 at all.
SCENES = int(os.environ.get("SCENES", "200"))
BLOCK = 25


@pytest.mark.parametrize("first", range(0, SCENES, BLOCK))
def test_fused_kernels_agree_with_the_reference(first: int) -> None:
    for seed in range(first, min(first + BLOCK, SCENES)):
        _compare(random_scene(seed), seed)


@pytest.mark.parametrize("seed", range(8))
def test_they_agree_on_pictures_of_a_model_s_size(seed: int) -> None:
    _compare(random_scene(seed, least=48, most=128), seed)


def _compare(scene: Scene, seed: int) -> None:
    crease = (0.0, 0.3, np.inf, pictures.HARD)[seed % 4]
    picture, value, to_screen, to_colours = _reference(scene, crease)
    batch = scene.screen[None], scene.colours[None], scene.topology
    np.testing.assert_allclose(
        pictures.draw(*batch, *scene.size, crease)[0], picture, atol=1e-5, err_msg=f"seed {seed}"
    )
    assert likelihood.log_likelihood(*batch, scene.target[None], crease)[0] == pytest.approx(value, rel=1e-5), seed
    again, gradients = likelihood.log_likelihood_gradient(*batch, scene.target[None], np.ones(1), crease)
    assert again[0] == pytest.approx(value, rel=1e-5), seed
    for found, expected in ((gradients.screen[0], to_screen), (gradients.colours[0], to_colours)):
        tolerance = 1e-5 * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(
            scene.together(found), scene.together(expected), atol=tolerance, err_msg=f"seed {seed}"
        )


def test_gradient_of_a_picture_agrees_with_the_reference() -> None:
    for seed in range(20):
        scene = random_scene(seed)
        upstream = np.random.default_rng(seed).normal(size=scene.target.shape)
        screen = torch.tensor(scene.screen, dtype=torch.float64, requires_grad=True)
        colours = torch.tensor(scene.colours, dtype=torch.float64, requires_grad=True)
        faces = torch.tensor(scene.topology.faces.astype(np.int64))
        picture = reference.draw(screen, colours, faces, *scene.size)
        (picture * torch.tensor(upstream)).sum().backward()
        found = pictures.draw_gradient(scene.screen[None], scene.colours[None], scene.topology, upstream[None])
        for mine, theirs in ((found.screen[0], screen.grad), (found.colours[0], colours.grad)):
            expected = scene.together(np.zeros(mine.shape) if theirs is None else theirs.numpy())
            np.testing.assert_allclose(
                scene.together(mine), expected, atol=1e-5 * max(1.0, np.abs(expected).max()), err_msg=f"seed {seed}"
            )


def _square(x0: float, y0: float, x1: float, y1: float) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[x0, y0, 0.5], [x1, y0, 0.5], [x1, y1, 0.5], [x0, y1, 0.5]], np.float32)
    return corners, np.array([[0, 1, 2], [0, 2, 3]])


def test_an_axis_aligned_square_is_its_exact_area_in_every_pixel() -> None:
    corners, faces = _square(1.25, 2.5, 5.75, 4.125)
    drawn = pictures.draw(corners[None], np.ones((1, 4, 1), np.float32), build_topology(faces), 8, 6)[0, 0]
    columns = np.clip(np.minimum(np.arange(8) + 1, 5.75) - np.maximum(np.arange(8), 1.25), 0, 1)
    rows = np.clip(np.minimum(np.arange(6) + 1, 4.125) - np.maximum(np.arange(6), 2.5), 0, 1)
    np.testing.assert_allclose(drawn, np.outer(rows, columns), atol=1e-6)


def test_total_coverage_is_the_polygon_s_area_and_does_not_change_under_translation() -> None:
    triangle = np.array([[2.3, 3.1, 0.5], [17.9, 5.2, 0.5], [8.4, 14.8, 0.5]], np.float32)
    topology = build_topology(np.array([[0, 1, 2]]))
    (ax, ay), (bx, by) = triangle[1, :2] - triangle[0, :2], triangle[2, :2] - triangle[0, :2]
    white, ones = np.ones((1, 3, 1), np.float32), np.ones((1, 1, 18, 20), np.float32)
    assert pictures.draw(triangle[None], white, topology, 20, 18).sum() == pytest.approx(abs(ax * by - bx * ay) / 2)
    gradient = pictures.draw_gradient(triangle[None], white, topology, ones).screen[0]
    np.testing.assert_allclose(gradient[:, :2].sum(0), 0, atol=1e-5)
    # d area / d scale about the origin is twice the area.
    assert (gradient[:, :2] * triangle[:, :2]).sum() == pytest.approx(abs(ax * by - bx * ay), rel=1e-5)


def test_a_wing_too_thin_for_any_pixel_centre_keeps_its_area() -> None:
    corners, faces = _square(2.0, 3.1, 9.0, 3.3)
    drawn = pictures.draw(corners[None], np.ones((1, 4, 1), np.float32), build_topology(faces), 12, 6)
    assert drawn.sum() == pytest.approx(7.0 * 0.2, rel=1e-4)


def test_an_empty_mesh_explains_a_picture_as_black() -> None:
    topology = build_topology(np.zeros((0, 3), np.int64))
    target = np.random.default_rng(0).uniform(size=(1, 3, 6, 8)).astype(np.float32)
    value = likelihood.log_likelihood(
        np.zeros((1, 0, 3), np.float32), np.zeros((1, 0, 3), np.float32), topology, target
    )
    black = torch.zeros(3, 6, 8, dtype=torch.float64)
    assert value[0] == pytest.approx(reference.log_likelihood(black, torch.tensor(target[0]).double()).item(), rel=1e-6)


def test_what_is_not_finite_is_refused_by_the_number_of_the_first_bad_mesh() -> None:
    corners, faces = _square(1, 1, 3, 3)
    screen = np.stack([corners, corners, corners])
    screen[1, 2, 0] = np.nan
    with pytest.raises(ValueError, match="first in mesh 1"):
        pictures.draw(screen, np.ones((3, 4, 1), np.float32), build_topology(faces), 8, 6)

    with pytest.raises(ValueError, match="first in mesh 1"):
        pictures.draw_each([(one, np.ones((4, 1), np.float32), build_topology(faces)) for one in screen], 8, 6)
    with pytest.raises(ValueError, match="first in mesh 2"):
        pictures.draw(corners[None] * [[[1]], [[1]], [[1e39]]], np.ones((3, 4, 1)), build_topology(faces), 8, 6)
    target = np.full((1, 1, 6, 8), np.nan, np.float32)
    with pytest.raises(ValueError, match="expected finite pictures"):
        likelihood.log_likelihood(corners[None], np.ones((1, 4, 1), np.float32), build_topology(faces), target)


def test_shapes_that_do_not_fit_are_refused() -> None:
    """Kernels look at no bounds."""
    corners, faces = _square(1, 1, 3, 3)
    mesh = np.stack([corners] * 2), np.ones((2, 4, 3), np.float32), build_topology(faces)
    for shape in ((1, 3, 6, 8), (2, 1, 6, 8), (2, 3, 6)):
        with pytest.raises(ValueError, match=r"expected gradients \[N, C, H, W\] of the pictures"):
            pictures.draw_gradient(*mesh, np.zeros(shape, np.float32))
    for scales in (np.ones(3), np.ones((2, 1))):
        with pytest.raises(ValueError, match="expected a scale for each hypothesis"):
            likelihood.log_likelihood_gradient(*mesh, np.zeros((1, 3, 6, 8), np.float32), scales)


def test_meshes_without_weight_get_no_gradient() -> None:
    scene = random_scene(3)
    pair = np.stack([scene.screen] * 2), np.stack([scene.colours] * 2), scene.topology
    values, both = likelihood.log_likelihood_gradient(*pair, scene.target[None], np.array([0.0, 2.0]))
    (value, _), one = likelihood.log_likelihood_gradient(*pair, scene.target[None], np.array([1.0, 0.0]))
    np.testing.assert_allclose(values, [0.0, value])
    assert not both.screen[0].any()
    assert not both.colours[0].any()
    np.testing.assert_allclose(both.screen[1], 2 * one.screen[0], rtol=1e-4, atol=1e-4)


def test_meshes_that_share_nothing_are_drawn_like_each_alone() -> None:
    scenes = [random_scene(seed) for seed in range(6)]
    together = pictures.draw_each([(scene.screen, scene.colours, scene.topology) for scene in scenes], 20, 16, 0.1)
    for scene, picture in zip(scenes, together, strict=True):
        alone = pictures.draw(scene.screen[None], scene.colours[None], scene.topology, 20, 16, 0.1)
        np.testing.assert_array_equal(picture, alone[0])
    with pytest.raises(ValueError, match=r"one number of colour channels in all meshes, found \[1, 3\]"):
        pictures.draw_each([(scenes[0].screen, scenes[0].colours[:, :k], scenes[0].topology) for k in (1, 3)], 20, 16)


@pytest.mark.parametrize("shift", [(-90, 0), (90, 0), (0, -90), (0, 90), (90, 90)])
def test_a_mesh_outside_the_picture_draws_nothing(shift: tuple[int, int]) -> None:
    scene = random_scene(3)
    screen = (scene.screen + np.array([*shift, 0], np.float32))[None]
    batch = screen, scene.colours[None], scene.topology
    assert not pictures.draw(*batch, 12, 9).any()
    assert not pictures.draw_gradient(*batch, np.ones((1, 3, 9, 12), np.float32)).screen.any()
    assert not pictures.draw_each([(screen[0], scene.colours, scene.topology)], 12, 9).any()


def test_a_million_faces_are_drawn() -> None:
    # A sphere of 709 circles of latitude and as many meridians, around the axis that is looked along.
    count = 709
    latitude, longitude = np.linspace(0, np.pi, count), np.arange(count) * 2 * np.pi / count
    ring, height = np.sin(latitude)[:, None], np.repeat(np.cos(latitude), count)
    x, y = (ring * np.cos(longitude)).ravel(), (ring * np.sin(longitude)).ravel()
    screen = np.stack((20 * x + 32, 20 * y + 24, 1 / (3 + height)), 1)
    here = np.arange((count - 1) * count).reshape(-1, count)
    beside, below = np.roll(here, -1, 1), here + count
    faces = np.stack((here, below, beside, beside, below, np.roll(below, -1, 1)), -1).reshape(-1, 3)
    drawn = pictures.draw(screen[None], np.ones((1, len(screen), 1)), build_topology(faces), 64, 48, np.inf)
    assert len(faces) > 10**6
    assert drawn.sum() == pytest.approx(np.pi * 20**2, rel=1e-4)
