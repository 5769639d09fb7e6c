"""Views that are moved onto pictures, against where the reference renderer puts the light of both."""

import pytest
import torch
from torch import Tensor

from trainer.config import LossConfig, SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.rendering import reference
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade
from trainer.training.moving import brightness_centre, moved_onto
from trainer.training.schedule import weights_at
from trainer.training.views import Views

SCENE = SceneConfig(width=32, height=24)
BASE = subdivided_cube(4)
FACES = torch.tensor(BASE.faces)
AZIMUTHS = torch.tensor([[-2.0, 0.3, 1.2]])


def views_of(vertices: Tensor) -> Views:
    """One shape from three sides, in double precision."""
    everywhere = vertices.double().expand(1, 3, -1, -1)
    azimuths = AZIMUTHS.double()
    screen = project(everywhere, azimuths, SCENE.camera, SCENE.width, SCENE.height)
    return Views(screen, shade(vertex_normals(everywhere, FACES), azimuths, SCENE))


def pictures_of(views: Views) -> Tensor:
    drawn = [
        reference.draw(screen, colours, FACES, SCENE.width, SCENE.height, torch.inf)
        for screen, colours in zip(views.screen[0], views.colours[0], strict=True)
    ]
    return torch.stack(drawn)


@pytest.fixture(scope="module")
def box() -> Tensor:
    """A convex shape whose bulk is not in the middle of the picture."""
    return torch.tensor(BASE.vertices) * torch.tensor([0.3, 0.2, 0.5]) + torch.tensor([0.05, 0.02, 0.1])


def test_the_light_of_a_view_comes_to_lie_where_the_picture_s_is(box: Tensor) -> None:
    views = views_of(box)
    for picture in pictures_of(views_of(box * torch.tensor([0.8, 1.3, 0.7]) - 0.1)):
        moved = moved_onto(views, picture[None], FACES)
        aim = brightness_centre(picture[None])
        before, after = brightness_centre(pictures_of(views)), brightness_centre(pictures_of(moved))
        assert (before - aim).norm(dim=1).min() > 1
        assert (after - aim).norm(dim=1).max() < 0.05
        assert torch.equal(moved.colours, views.colours)
        assert torch.equal(moved.screen[..., 2], views.screen[..., 2])


def test_where_a_shape_lies_in_the_picture_s_plane_no_longer_matters(box: Tensor) -> None:
    views = views_of(box)
    picture = pictures_of(views)[:1]
    shifted = views._replace(screen=views.screen + torch.tensor([1.7, -0.6, 0.0]))
    torch.testing.assert_close(
        moved_onto(shifted, picture, FACES).screen, moved_onto(views, picture, FACES).screen, atol=1e-9, rtol=0
    )


def test_gradients_are_those_of_finite_differences(box: Tensor) -> None:
    picture = pictures_of(views_of(box))[:1]
    generator = torch.Generator().manual_seed(0)
    weights = torch.randn(1, 3, len(box), 3, generator=generator, dtype=torch.float64)

    def value(screen: Tensor) -> Tensor:
        return (moved_onto(Views(screen, colours), picture, FACES).screen * weights).sum()

    screen, colours = views_of(box)
    direction = torch.randn(screen.shape, generator=generator, dtype=torch.float64)
    screen.requires_grad_()
    (gradient,) = torch.autograd.grad(value(screen), screen)
    step = 1e-6
    with torch.no_grad():
        difference = (value(screen + step * direction) - value(screen - step * direction)) / (2 * step)
    assert float((gradient * direction).sum()) == pytest.approx(float(difference), rel=1e-6)


def test_several_lights_move_a_view_together(box: Tensor) -> None:
    views = views_of(box)
    picture = pictures_of(views)[:1]
    twice = views._replace(colours=views.colours[..., None, :].expand(-1, -1, -1, 2, -1))
    torch.testing.assert_close(moved_onto(twice, picture, FACES).screen, moved_onto(views, picture, FACES).screen)


def test_a_black_picture_and_a_black_shape_stay_finite(box: Tensor) -> None:
    views = views_of(box)
    black = torch.zeros(1, 3, SCENE.height, SCENE.width, dtype=torch.float64)
    assert moved_onto(views._replace(colours=views.colours * 0), black, FACES).screen.isfinite().all()


def test_a_shape_learns_from_moved_views_for_the_first_steps_only() -> None:
    config = LossConfig(moved_steps=3)
    assert [weights_at(config, step, 128, 96).moved for step in range(5)] == [True, True, True, False, False]
    assert not weights_at(LossConfig(), 0, 128, 96).moved
