"""The E-step as the loss uses it, against the reference renderer and its formula written out in numpy."""

from typing import Literal

import numpy as np
import pytest
import torch
from torch import Tensor

from rasteriser.pictures import HARD
from rasteriser.topology import Topology, build_topology
from trainer.config import LossConfig, ModelConfig, SceneConfig
from trainer.geometry.normals import vertex_normals
from trainer.geometry.topology import subdivided_cube
from trainer.model.loss import LossWeights
from trainer.model.vae import Model
from trainer.rendering import reference
from trainer.rendering.camera import project
from trainer.rendering.lighting import shade
from trainer.training import step
from trainer.training.loop import fixed_geometry
from trainer.training.step import e_step, forward
from trainer.training.views import Views, bin_views

PICTURES, BINS, ROUNDS = 4, 3, 5
SCENE = SceneConfig(width=24, height=18)
WEIGHTS = LossWeights(kl=1.0, prior_matching=1.0, temperature=2.5, encoder_prior=0.7, distillation=1.0, laplacian=1.0)


@pytest.fixture(scope="module")
def views() -> tuple[Views, Topology]:
    """Boxes of different proportions from three sides."""
    generator = torch.Generator().manual_seed(0)
    base = subdivided_cube(2)
    faces = torch.tensor(base.faces)
    sizes = torch.rand(PICTURES, 1, 3, generator=generator) * 0.4 + 0.2
    vertices = torch.tensor(base.vertices, dtype=torch.float32) * sizes
    azimuth = torch.tensor([-2.0, 0.3, 1.2]).expand(PICTURES, BINS)
    everywhere = vertices[:, None].expand(-1, BINS, -1, -1)
    normals = vertex_normals(vertices, faces)[:, None].expand(-1, BINS, -1, -1)
    screen = project(everywhere, azimuth, SCENE.camera, SCENE.width, SCENE.height)
    return Views(screen, shade(normals, azimuth, SCENE)), build_topology(base.faces)


@pytest.mark.parametrize(("antialias", "crease"), [("none", HARD), ("contours", np.inf)])
def test_the_e_step_is_its_formula(
    views: tuple[Views, Topology], antialias: Literal["none", "contours"], crease: float
) -> None:
    (screen, colours), topology = views
    faces = torch.as_tensor(topology.faces).long()
    images = reference_pictures(screen[:, 1], colours[:, 1], faces)
    log_rho = torch.randn(PICTURES, BINS, generator=torch.Generator().manual_seed(1)).log_softmax(1)
    config = LossConfig(antialias_e_step=antialias, sinkhorn_iterations=ROUNDS)
    found = e_step(config, WEIGHTS, Views(screen, colours), log_rho, images, topology)

    posterior = np.empty((PICTURES, BINS))
    for picture in range(PICTURES):
        for r in range(BINS):
            drawn = reference.draw(
                screen[picture, r].double(), colours[picture, r].double(), faces, SCENE.width, SCENE.height, crease
            )
            likelihood = float(reference.log_likelihood(drawn, images[picture].double()))
            posterior[picture, r] = np.exp(likelihood / 2.5) * np.exp(float(log_rho[picture, r])) ** 0.7
    posterior /= posterior.sum(1, keepdims=True)
    for _ in range(ROUNDS):
        posterior /= posterior.sum(0, keepdims=True)
        posterior /= posterior.sum(1, keepdims=True)
    np.testing.assert_allclose(found.numpy(), posterior, atol=1e-4)
    # Not every picture is explained by the same bin, nor any by one alone: the formula's parts all count.
    assert 0.05 < posterior.max(1).min() < 0.95


def reference_pictures(screen: Tensor, colours: Tensor, faces: Tensor) -> Tensor:
    """What each shape looks like from one side."""
    return torch.stack(
        [
            reference.draw(one, paint, faces, SCENE.width, SCENE.height)
            for one, paint in zip(screen, colours, strict=True)
        ]
    )


@pytest.mark.parametrize("light", ["fixed", "varying"])
@pytest.mark.parametrize("fine", [False, True])
def test_the_e_step_compares_poses_at_the_centres_of_bins_or_at_the_fine_angle(
    monkeypatch: pytest.MonkeyPatch, light: Literal["fixed", "varying"], fine: bool
) -> None:
    compared: list[Views] = []

    def watched(config: LossConfig, weights: LossWeights, views: Views, *others: Tensor | Topology) -> Tensor:
        compared.append(views)
        return e_step(config, weights, views, *others)

    monkeypatch.setattr(step, "e_step", watched)
    torch.manual_seed(0)
    model = Model(ModelConfig(segments=2, light=light), SCENE.width, SCENE.height)
    # Running means of the batch normalisation say then what the batch does, and no shape depends on its code.
    model.eval()
    for layer in model.decoder.hidden.parameters():
        torch.nn.init.zeros_(layer)
    images = torch.rand(PICTURES, 3, SCENE.height, SCENE.width)
    config = LossConfig()
    geometry, weights = fixed_geometry(model, SCENE, config), WEIGHTS._replace(e_step_fine=fine)
    forward(model, geometry, SCENE, config, weights, images, None, torch.Generator().manual_seed(0))

    posterior = model.encode(images)
    assert posterior.azimuth_fine_mean.abs().min() > 1e-4
    turned = None if posterior.light is None else fine * posterior.light.fine_mean
    vertices = model.decode(posterior.shape_mean)
    expected = bin_views(model, SCENE, vertices, fine * posterior.azimuth_fine_mean, turned)
    torch.testing.assert_close(compared[0].screen, expected.screen)
    torch.testing.assert_close(compared[0].colours, expected.colours)
