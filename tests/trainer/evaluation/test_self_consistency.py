"""Whether a model knows its own shapes again: encoders of which that is known."""

from typing import cast

import numpy as np
import pytest
import torch
from torch import Tensor

from imaging.srgb import decode_table
from tests.trainer.evaluation.conftest import SCENE, stretched
from trainer.evaluation import self_consistency
from trainer.evaluation.refinement import Inference
from trainer.evaluation.self_consistency import UNKNOWN, consistent_posterior, doubts, self_distances, unknown
from trainer.evaluation.subject import Subject
from trainer.model.aggregate_posterior import LEAST_PICTURES
from trainer.model.posterior import Posterior
from trainer.model.vae import Model

CHAIR = torch.tensor(stretched(0).vertices, dtype=torch.float32)
RADIUS = float(CHAIR.square().sum(1).mean().sqrt())
ANSWER = 0.6


class Sizes:
    """Its code is an object's size; it takes whatever it sees for one of the size ANSWER."""

    faces = torch.tensor(stretched(0).faces)

    def __init__(self) -> None:
        self.seen: list[Tensor] = []

    def decode(self, codes: Tensor) -> Tensor:
        return codes[:, :1, None] * CHAIR

    def encode(self, images: Tensor) -> Posterior:
        self.seen.append(images)
        sizes = torch.full((len(images), 1), ANSWER)
        return Posterior(sizes, torch.zeros_like(sizes), torch.zeros(len(images), 12), *torch.zeros(2, len(images)))


class Told(Sizes):
    """Of pictures that are black but for one point, that point's brightness is the size."""

    def encode(self, images: Tensor) -> Posterior:
        posterior = super().encode(images)
        one = (images.flatten(1) > 0).sum(1) == 1
        sizes = torch.where(one, images.flatten(1).amax(1), posterior.shape_mean[:, 0])[:, None]
        return posterior._replace(shape_mean=sizes)


def distances(model: Sizes, codes: Tensor) -> Tensor:
    return self_distances(lambda seen: model.encode(seen).shape_mean, model.decode, model.faces, SCENE, codes)


def test_the_distance_is_that_of_what_the_encoder_takes_it_for() -> None:
    codes = torch.linspace(0.2, 1.0, 300)[:, None]
    model = Sizes()
    found = distances(model, codes)
    torch.testing.assert_close(found, (codes[:, 0] - ANSWER).abs() * RADIUS, atol=1e-5, rtol=0)
    assert found.min() < 0.01 * RADIUS


def test_shapes_are_seen_from_four_sides() -> None:
    model = Sizes()
    distances(model, torch.tensor([[1.0]]))
    sides = torch.cat(model.seen)
    assert sides.shape == (4, 3, SCENE.height, SCENE.width)
    assert (sides.flatten(1).amax(1) > 0.1).all()
    apart = (sides[:, None] - sides[None]).abs().flatten(2).mean(2)
    assert (apart[~torch.eye(4, dtype=torch.bool)] > 0.01).all()


def test_unknown_are_the_pictures_whose_shapes_are_least_known_again() -> None:
    """Of sizes from 0.1 to 1.0, those that are farthest from the one that is taken for all."""
    model, count = Told(), 40

    def infer(images: Tensor) -> Inference:
        return Inference(model.encode(images).shape_mean, torch.empty(0), torch.empty(0), torch.empty(0), None)

    subject = Subject(infer, model.decode, model.faces, torch.empty(0), SCENE, "chair", {})
    pictures = np.zeros((count, 3, SCENE.height, SCENE.width), np.uint8)
    sizes = np.random.default_rng(0).permutation(np.linspace(0.1, 1.0, count))
    table = decode_table()
    pictures[:, 0, 0, 0] = np.searchsorted(table, sizes)
    found = unknown(doubts(subject, pictures))
    apart = np.abs(table[pictures[:, 0, 0, 0]] - ANSWER)
    assert found.sum() == round(UNKNOWN * count)
    assert apart[found].min() > apart[~found].max()


def test_of_many_pictures_some_are_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(self_consistency, "MOST_PICTURES", LEAST_PICTURES)
    pictures = torch.zeros(2 * LEAST_PICTURES, 3, SCENE.height, SCENE.width)
    # Those that are chosen are all alike: no number of their codes tells anything.
    pictures[::2, 0, 0, 0], pictures[1::2, 0, 0, 0] = ANSWER, 0.2
    density = consistent_posterior(cast(Model, Told()), SCENE, pictures.split(7))
    assert density.pictures == LEAST_PICTURES
    assert density.numbers == ()


def test_codes_are_drawn_from_where_shapes_are_known_again() -> None:
    """Sizes from 0.1 to 1.1, of which the encoder knows ANSWER again, and the less the farther from it."""
    pictures = torch.zeros(LEAST_PICTURES, 3, SCENE.height, SCENE.width)
    sizes = torch.linspace(0.1, 1.1, LEAST_PICTURES)
    pictures[:, 0, 0, 0] = sizes
    density = consistent_posterior(cast(Model, Told()), SCENE, pictures.split(7))
    random = np.random.default_rng(0)
    codes = density.codes(random.standard_normal((1000, 1)), random.random(1000))
    assert density.pictures == LEAST_PICTURES
    assert codes.mean() == pytest.approx(ANSWER, abs=0.05)
    # As of the nearer three quarters of the sizes, spread evenly; of all of them it would be 0.29.
    assert codes.std() == pytest.approx(0.75 / np.sqrt(12), rel=0.15)
