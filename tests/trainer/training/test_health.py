"""The closer looks at a training: right where the answer is known, and without a trace in the training."""

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.training.runs import run
from trainer.config import TrainConfig
from trainer.data.images import ImageSet
from trainer.geometry.blocks import chamfered_cube
from trainer.geometry.intersections import crossed_faces
from trainer.geometry.topology import subdivided_cube
from trainer.model.vae import Model
from trainer.training.health import health_of, term_gradients
from trainer.training.intervals import Intervals
from trainer.training.loop import fixed_geometry
from trainer.training.schedule import weights_at
from trainer.training.step import StepResult, forward


@pytest.fixture
def model(config: TrainConfig) -> Model:
    torch.manual_seed(0)
    return Model(config.model, config.width, config.height)


def look(model: Model, config: TrainConfig, images: ImageSet) -> StepResult:
    """A step's forward pass that is the same on every call."""
    weights = weights_at(config.loss, 0, config.width, config.height)
    generator = torch.Generator().manual_seed(0)
    batch = images.batch(np.arange(8))
    return forward(
        model,
        fixed_geometry(model, images.scene, config.loss),
        images.scene,
        config.loss,
        weights,
        batch,
        None,
        generator,
    )


def test_the_gradients_of_the_terms_are_those_of_the_loss(model: Model, config: TrainConfig, images: ImageSet) -> None:
    norms = term_gradients(model, partial(look, model, config, images))
    assert norms.keys() == {f"gradient_{term}" for term in ("reconstruction", "kl", "distillation", "laplacian")}
    for term in ("reconstruction", "kl"):
        model.zero_grad()
        getattr(look(model, config, images).terms, term).backward()
        squares = [parameter.grad.square().sum() for parameter in model.parameters() if parameter.grad is not None]
        assert norms[f"gradient_{term}"] == pytest.approx(math.sqrt(float(torch.stack(squares).sum())), rel=1e-4)


def test_a_look_changes_nothing(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    often = run(config, images, tmp_path / "often", intervals=Intervals(log=1, preview=2))
    never = run(config, images, tmp_path / "never", intervals=Intervals(log=1, preview=1000))
    for name, value in often.model.state_dict().items():
        assert torch.equal(value, never.model.state_dict()[name]), name


def test_the_prototype_of_a_new_model_is_a_whole_cube(model: Model, config: TrainConfig, images: ImageSet) -> None:
    figures = health_of(model, images.scene, images.batch(np.arange(4)), partial(look, model, config, images))
    vertices = model.decode(torch.zeros(1, config.model.latent))[0].detach()
    low, high = vertices.min(0).values, vertices.max(0).values
    assert figures["prototype_volume"] == pytest.approx(float((high - low).prod()), rel=0.2)
    assert figures["self_intersections"] == 0
    assert 0 < figures["rerender_error"] < 5


def test_a_closed_solid_does_not_cross_itself_and_a_pushed_in_one_does() -> None:
    cube = subdivided_cube(4, 1.0)
    assert not crossed_faces(cube.vertices, cube.faces).any()
    pushed = cube.vertices.copy()
    top = np.flatnonzero((cube.vertices[:, 1] == 0.5) & (np.abs(cube.vertices[:, [0, 2]]) < 0.4).all(1))
    # Askew, so that no edge meets another one's line.
    pushed[top] += [0.03, -1.2, 0.05]
    crossed = crossed_faces(pushed, cube.faces)
    # Those of the bottom that the dent goes through, and those of the dent that the bottom's edges meet.
    assert 0 < crossed.sum() < len(cube.faces) / 2
    assert not crossed[(pushed[cube.faces][..., 1] > 0).all(1)].any()


def test_two_cubes_cross_where_they_overlap_and_not_apart() -> None:
    vertices, faces = chamfered_cube()
    for distance, expected in ((3.0, False), (0.35, True)):
        shift = np.array([distance, 0.11, 0.07]) * np.ptp(vertices, 0)
        both = np.concatenate((vertices, vertices + shift))
        assert crossed_faces(both, np.concatenate((faces, faces + len(vertices)))).any() == expected


def test_looks_stand_in_the_journal(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    seen: dict[int, dict[str, float]] = {}
    intervals = Intervals(log=1, preview=3)
    run(
        config,
        images,
        tmp_path,
        intervals=intervals,
        report=lambda step, figures: seen.update({step: figures}),
    )
    assert [step for step, figures in seen.items() if "self_intersections" in figures] == [3, 6]
    assert all(math.isfinite(value) for value in seen[6].values())
