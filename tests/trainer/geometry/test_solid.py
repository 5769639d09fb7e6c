"""The solid inside a cube: its volume, what of it is turned inside out, and which way the gradient pushes."""

import numpy as np
import pytest
import torch
from torch import Tensor

from trainer.geometry.solid import Solid, cube_solid, inverted_volume
from trainer.geometry.topology import subdivided_cube


def surface(segments: int) -> Tensor:
    return torch.tensor(subdivided_cube(segments).vertices)


def inverted(solid: Solid, vertices: Tensor, margin: float = 0, offsets: Tensor | None = None) -> Tensor:
    inner = torch.tensor(solid.inner) @ vertices
    points = torch.cat((vertices, inner if offsets is None else inner + offsets), 1)
    return inverted_volume(points, torch.tensor(solid.tetrahedra), margin)


def volumes(solid: Solid, vertices: np.ndarray, offsets: np.ndarray | float = 0.0) -> np.ndarray:
    points = np.concatenate((vertices, solid.inner @ vertices + offsets))
    return np.array([np.linalg.det(points[corners[1:]] - points[corners[0]]) / 6 for corners in solid.tetrahedra])


@pytest.mark.parametrize("segments", [1, 2, 3, 4, 8])
def test_tetrahedra_fill_the_cube(segments: int) -> None:
    solid = cube_solid(segments)
    assert solid.inner.shape == ((segments - 1) ** 3, 6 * segments**2 + 2)
    assert solid.tetrahedra.shape == (5 * segments**3, 4)
    found = volumes(solid, surface(segments).numpy())
    assert found.min() > 0
    assert found.sum() == pytest.approx(1)


@pytest.mark.parametrize("proportions", [(1, 3, 10), (5, 1, 2)])
def test_tetrahedra_fill_a_cube_whose_edges_are_cut_unevenly(proportions: tuple[int, int, int]) -> None:
    solid = cube_solid(2, proportions)
    vertices = subdivided_cube(2, 1, proportions).vertices
    cells = 2 * np.array(proportions)
    assert solid.inner.shape == (np.prod(cells - 1), len(vertices))
    assert solid.tetrahedra.shape == (5 * np.prod(cells), 4)
    found = volumes(solid, vertices)
    assert found.min() > 0
    assert found.sum() == pytest.approx(1)


@pytest.mark.parametrize("segments", [2, 4])
def test_it_is_its_own_mirror_image(segments: int) -> None:
    solid, vertices = cube_solid(segments), surface(segments).numpy()
    points = np.concatenate((vertices, solid.inner @ vertices))
    there = {frozenset(map(tuple, points[corners].round(9) + 0.0)) for corners in solid.tetrahedra}
    for axis in range(3):
        mirrored = points * np.where(np.arange(3) == axis, -1, 1)
        assert {frozenset(map(tuple, mirrored[corners].round(9) + 0.0)) for corners in solid.tetrahedra} == there


def test_inner_points_lie_in_the_middle_of_their_neighbours_whatever_the_surface_does() -> None:
    solid, vertices = cube_solid(4), surface(4).numpy()
    lattice = np.rint((np.concatenate((vertices, solid.inner @ vertices)) + 0.5) * 4)
    displaced = vertices + np.random.default_rng(0).normal(size=vertices.shape)
    points = np.concatenate((displaced, solid.inner @ displaced))
    for number in range(len(vertices), len(points)):
        neighbours = np.abs(lattice - lattice[number]).sum(1).round(6) == 1
        assert neighbours.sum() == 6
        np.testing.assert_allclose(points[number], points[neighbours].mean(0), atol=1e-12)


def test_what_is_moved_turned_or_stretched_is_not_inside_out() -> None:
    vertices = surface(4)
    stretched = vertices * torch.tensor([1.0, 0.02, 3.0], dtype=torch.float64) + 7.0
    turned = vertices[:, [1, 2, 0]]
    assert inverted(cube_solid(4), torch.stack((vertices, stretched, turned))).tolist() == [0, 0, 0]


def test_a_mirrored_cube_is_inside_out_as_a_whole() -> None:
    mirrored = surface(4) * torch.tensor([1.0, -0.5, 1.0], dtype=torch.float64)
    assert inverted(cube_solid(4), mirrored[None]).item() == pytest.approx(0.5)


def test_an_underside_that_rises_through_the_top_is_told_and_is_pushed_back() -> None:
    """Seen from above, this slab has the same outline and a plane top: its underside."""
    vertices = surface(4) * torch.tensor([1.0, 0.1, 1.0], dtype=torch.float64)
    middle = (vertices[:, [0, 2]].abs() < 0.3).all(1)
    below = middle & (vertices[:, 1] < 0)
    crossed = torch.where(below[:, None], vertices + torch.tensor([0.0, 0.14, 0.0]), vertices).requires_grad_()
    (found,) = inverted(cube_solid(4), crossed[None])
    assert found.item() > 0.004
    (gradient,) = torch.autograd.grad(found, crossed)
    assert (gradient[below, 1] > 0).all()
    assert (gradient[middle & (vertices[:, 1] > 0), 1] < 0).all()


def test_its_gradient_is_that_of_finite_differences() -> None:
    rng, solid = np.random.default_rng(1), cube_solid(2)
    vertices = surface(2) + 0.4 * torch.tensor(rng.normal(size=(3, 26, 3)))
    offsets = 0.4 * torch.tensor(rng.normal(size=(3, 1, 3)))
    assert inverted(solid, vertices, 0, offsets).min() > 0
    inputs = (vertices.requires_grad_(), offsets.requires_grad_())
    assert torch.autograd.gradcheck(lambda x, moved: inverted(solid, x, 0, moved), inputs)


def test_it_is_the_sum_of_the_negative_volumes() -> None:
    rng, solid = np.random.default_rng(2), cube_solid(3)
    vertices = surface(3) + 0.3 * torch.tensor(rng.normal(size=(2, 56, 3)))
    offsets = 0.3 * torch.tensor(rng.normal(size=(2, 8, 3)))
    each = [volumes(solid, shape, moved) for shape, moved in zip(vertices.numpy(), offsets.numpy(), strict=True)]
    expected = [-np.minimum(found, 0).sum() for found in each]
    np.testing.assert_allclose(inverted(solid, vertices, 0, offsets), expected, rtol=1e-10)


def test_a_bar_bent_to_a_hook_is_sound_as_soon_as_its_inner_points_are_anywhere_right() -> None:
    """Where the surface alone carries them, they leave the bar at its bend."""
    solid, vertices = cube_solid(8), surface(8)

    def bent(points: Tensor) -> Tensor:
        along, across = 4 * points[:, 2], 0.6 + 0.2 * points[:, 0]
        return torch.stack((across * along.cos(), points[:, 1], across * along.sin()), 1)

    hook, inner = bent(vertices)[None], torch.tensor(solid.inner)
    offsets = bent(inner @ vertices) - inner @ hook
    assert inverted(solid, hook).item() > 0.2
    assert inverted(solid, hook, 0.01, offsets).item() == 0


def test_with_a_margin_it_is_what_each_tetrahedron_lacks_of_its_share_of_the_mean() -> None:
    vertices = surface(3) + 0.2 * torch.tensor(np.random.default_rng(2).normal(size=(2, 56, 3)))
    solid = cube_solid(3)
    each = [volumes(solid, shape) for shape in vertices.numpy()]
    expected = [np.maximum(0.3 * found.mean() - found, 0).sum() for found in each]
    np.testing.assert_allclose(inverted(solid, vertices, 0.3), expected, rtol=1e-10)
    assert (inverted(solid, vertices, 0.3) > inverted(solid, vertices)).all()


def test_a_margin_thickens_what_is_thin_beside_the_rest() -> None:
    slab = surface(4) * torch.tensor([1.0, 0.03, 1.0], dtype=torch.float64)
    thin = slab[:, 2] > 0.2
    thinned = torch.where(thin[:, None], slab * torch.tensor([1.0, 0.01, 1.0]), slab).requires_grad_()
    alike, uneven = inverted(cube_solid(4), torch.stack((slab, thinned)), 0.2)
    assert alike.item() == 0
    (gradient,) = torch.autograd.grad(uneven, thinned)
    assert (gradient * thinned)[thin, 1].sum() < 0


def test_what_is_inside_out_as_a_whole_asks_for_no_more_than_to_be_turned() -> None:
    mirrored = surface(4) * torch.tensor([1.0, -0.5, 1.0], dtype=torch.float64)
    assert inverted(cube_solid(4), mirrored[None], 0.5).item() == pytest.approx(0.5)
