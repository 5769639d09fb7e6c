"""Recorded steps give what steps give by themselves: by imitation, and on a GPU where there is one."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import pytest
import torch
from torch import Tensor, nn

from tests.trainer.training.one_step import SETTINGS
from trainer.config import LossConfig, SceneConfig
from trainer.data.source import step_generator
from trainer.model.vae import Model, model_of
from trainer.recording import is_sound, length, normal_noise
from trainer.training import recorded
from trainer.training.descent import Descent, Differentiation, Given, Unrecorded, put_back
from trainer.training.device import CPU
from trainer.training.longer_look import Look
from trainer.training.loop import stepping
from trainer.training.neighbours import Memory
from trainer.training.recorded import Recorded
from trainer.training.schedule import weights_at

TINY = SETTINGS["exact"]


class Toy(nn.Module):
    """Its loss is a parabola; it keeps a list as long as its pictures are bright, and counts its steps."""

    def __init__(self) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.ones(3))
        self.register_buffer("steps", torch.zeros(()))

    def forward(self, given: Given) -> Any:
        assert given.weights is not None
        self.steps.add_(1)
        needed = given.pictures.sum().clamp_min(0).long()
        listed = torch.arange(length(needed)) < needed
        noise = normal_noise((3,), given.generator, torch.float32, CPU)
        assert is_sound(given.pictures.min() >= 0)
        loss = ((self.weight - noise).square() * given.weights.kl).sum() * (listed.sum() + 1)
        return SimpleNamespace(loss=lambda: loss)


class Imitated(recorded._Graph[Any]):
    """A recording that computes anew what it would replay."""

    def __init__(self, *parts: Any) -> None:
        self.parts = parts
        super().__init__(*parts)
        # Recording computes nothing.
        put_back(self.model, self.before)

    def replay(self) -> Descent[Any] | None:
        most, replays = self.most, self.replays
        super().__init__(*self.parts)
        self.most, self.replays = most, replays
        return super().replay()


@pytest.fixture
def recordings(monkeypatch: pytest.MonkeyPatch) -> list[list[int]]:
    """What room each recording was made with."""
    made: list[list[int]] = []

    def record(*parts: Any) -> Imitated:
        made.append(parts[2])
        return Imitated(*parts)

    monkeypatch.setattr(recorded, "_Graph", record)
    monkeypatch.setattr(recorded, "_stream", MagicMock())
    for name in ("CUDAGraph", "current_stream"):
        monkeypatch.setattr(torch.cuda, name, MagicMock())
    for name in ("graph", "stream"):
        monkeypatch.setattr(torch.cuda, name, lambda *_, **__: nullcontext())
    return made


def a_step(number: int, bright: float, kl: float = 1.0) -> Given:
    weights = weights_at(LossConfig(), 5, 4, 4)._replace(kl=kl)
    return Given(torch.full((1, 1, 1, 1), bright), None, weights, step_generator(0, number))


def test_steps_are_recorded_with_room_to_spare_and_give_what_they_give_by_themselves(
    recordings: list[list[int]],
) -> None:
    model = Toy()
    ways = Recorded(model, 5.0, model), Unrecorded(model, 5.0, model)
    brightness = [100.0, 100.0, 110.0, 90.0, 200.0, 100.0, 0.0, 210.0]
    for number, bright in enumerate(brightness):
        found = []
        for way in ways:
            # Weights cool from step to step.
            taken = way(a_step(number, bright, kl=1 / (1 + number)))
            assert taken is not None
            assert model.weight.grad is not None
            found.append((taken.gradient_norm, model.weight.grad.tolist()))
        assert found[0] == found[1]
    # 200 were too many for the first recording.
    assert recordings == [[141], [266]]


def test_where_lists_become_shorter_less_room_is_recorded(recordings: list[list[int]]) -> None:
    model = Toy()
    way = Recorded(model, 5.0, model)
    for number in range(2 + 2 * recorded.PATIENCE):
        assert way(a_step(number, 1000.0 if number < 4 else 40.0 + number % 7)) is not None
    # Not before a recording has for long been too roomy.
    assert recordings == [[1266], [74]]


def test_steps_of_another_kind_are_recorded_anew(recordings: list[list[int]]) -> None:
    model = Toy()
    way = Recorded(model, 5.0, model)
    for number in range(6):
        given = a_step(number, 8.0)
        assert given.weights is not None
        way(given._replace(weights=given.weights._replace(moved=number < 3)))
    assert recordings == [[26], [26]]


@pytest.mark.parametrize("when", [0, 3])
def test_a_step_that_is_not_sound_changes_nothing(when: int, recordings: list[list[int]]) -> None:
    model = Toy()
    way = Recorded(model, 5.0, model)
    for number in range(5):
        steps = model.steps.item()
        for broken in (a_step(number, -1.0), a_step(number, 10.0, kl=torch.nan)):
            if number == when:
                assert way(broken) is None
                assert model.steps.item() == steps
        assert way(a_step(number, 10.0)) is not None
    assert len(recordings) == 1


gpu = pytest.mark.gpu
needs_gpu = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
GPU = torch.device("cuda", 0)


def both_ways(loss: LossConfig) -> tuple[Recorded[Any], Unrecorded[Any], list[Given]]:
    """Of the same model, and four minibatches."""
    config, size = replace(TINY, loss=loss, precision="float32"), (TINY.width, TINY.height)
    torch.backends.cudnn.allow_tf32 = False
    torch.manual_seed(0)
    there = model_of(config).to(GPU)
    memory = Memory(config.model.latent).to(GPU)
    for number in range(2):
        memory.remember(torch.randn(64, config.model.latent, device=GPU), torch.randn(64, device=GPU) + number)
    taking = stepping(there, SceneConfig(*size), config, GPU, memory)
    generator = torch.Generator().manual_seed(1)
    minibatches = [
        Given(torch.rand(8, 3, *size[::-1], generator=generator).to(GPU), None, weights_at(loss, number, *size),
              step_generator(0, number))
        for number in range(4)
    ]  # fmt: skip
    return Recorded(there, 5.0, taking), Unrecorded(there, 5.0, taking), minibatches


def gradients_of(differentiation: Differentiation[Any], given: Given) -> tuple[float, list[Tensor]]:
    given = given._replace(generator=torch.Generator().manual_seed(given.generator.initial_seed()))
    buffers = [buffer.clone() for buffer in differentiation.model.buffers()]  # type: ignore[attr-defined]
    taken = differentiation(given)
    assert taken is not None
    model: Model = differentiation.model  # type: ignore[attr-defined]
    put_back(model, buffers)
    return taken.gradient_norm, [part.grad.clone() for part in model.parameters() if part.grad is not None]


@gpu
@needs_gpu
@pytest.mark.parametrize(
    "loss",
    [
        LossConfig(independence_weight=1.0),
        LossConfig(neighbour_weight=1.0, e_step_centred_steps=0),
        LossConfig(inversion_weight=100.0),
        LossConfig(inversion_weight=100.0, inner_points="learnt"),
        LossConfig(front_back_weight=5.0, front_back_knee=2.0),
        LossConfig(objective="paper"),
        LossConfig(antialias="borders", antialias_e_step="contours"),
    ],
)
def test_a_replayed_step_has_the_gradient_of_one_by_itself(loss: LossConfig) -> None:
    replayed, unrecorded, minibatches = both_ways(loss)
    for given in minibatches:
        (norm, found), (expected_norm, expected) = (gradients_of(way, given) for way in (replayed, unrecorded))
        assert norm == pytest.approx(expected_norm, rel=1e-4)
        largest = max(float(one.abs().max()) for one in expected)
        for one, other in zip(found, expected, strict=True):
            torch.testing.assert_close(one, other, rtol=1e-3, atol=1e-5 * largest)
        assert (replayed.graph is None) == (given is minibatches[0])


@gpu
@needs_gpu
def test_a_step_that_needs_more_room_is_taken_by_itself() -> None:
    replayed, unrecorded, minibatches = both_ways(LossConfig())
    gradients_of(replayed, minibatches[0])
    replayed.room = [3 for _ in replayed.room or []]
    assert len(replayed.room) == 2
    norm, _ = gradients_of(replayed, minibatches[1])
    assert norm == pytest.approx(gradients_of(unrecorded, minibatches[1])[0], rel=1e-4)
    assert replayed.graph is None
    assert min(replayed.room) > 3
    gradients_of(replayed, minibatches[2])
    assert replayed.graph is not None


@gpu
@needs_gpu
def test_a_step_that_is_not_finite_leaves_the_model_as_it_was() -> None:
    replayed, _, minibatches = both_ways(LossConfig())
    for given in minibatches[:2]:
        gradients_of(replayed, given)
    before = [buffer.clone() for buffer in replayed.model.buffers()]
    with torch.no_grad():
        weight = next(replayed.model.parameters())
        kept = weight.clone()
        weight[:] = torch.nan
        assert replayed(minibatches[2]) is None
        weight[:] = kept
    for one, other in zip(replayed.model.buffers(), before, strict=True):
        assert torch.equal(one, other)
    gradients_of(replayed, minibatches[3])


@pytest.mark.parametrize("lit", [False, True])
def test_what_is_taught_is_copied_to_where_a_recording_looks_for_it(lit: bool) -> None:
    def given(number: int) -> Given:
        light = torch.full((2,), number / 10) if lit else None
        look = Look(torch.full((2, 4), float(number)), torch.full((2,), number / 100), light)
        return Given(torch.full((2, 3, 4, 5), number / 8), None, None, step_generator(0, number), look)

    inputs = recorded._Inputs(given(0))
    places = []
    for number in (1, 2):
        inputs.fill(given(number))
        seen, expected = inputs.as_given(given(number)).look, given(number).look
        assert seen is not None
        assert expected is not None
        for part, wanted in zip(seen, expected, strict=True):
            assert (part is None) == (wanted is None)
            assert part is None or torch.equal(part, wanted)
        places.append([part.data_ptr() for part in seen if part is not None])
    assert places[0] == places[1]
    assert recorded._kind_of(given(0)) != recorded._kind_of(given(0)._replace(look=None))
