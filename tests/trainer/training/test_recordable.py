"""A recorded step asks its device for nothing and hands it nothing: told on a device that holds no data."""

from contextlib import nullcontext
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import pytest
import torch
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

from tests.trainer.training.one_step import SETTINGS, moved_to
from tests.trainer.training.test_device import BLOCKS, LIT
from trainer.config import LossConfig, ModelConfig, SceneConfig
from trainer.data.images import frame_in
from trainer.data.source import step_generator
from trainer.model.vae import Model, model_of
from trainer.recording import Recording
from trainer.rendering import cuda, renderer
from trainer.training import loop, reframing
from trainer.training.descent import Given, differentiate
from trainer.training.lessons import Lesson
from trainer.training.longer_look import Look
from trainer.training.loop import fixed_geometry, stepping
from trainer.training.neighbours import Memory
from trainer.training.reframing import learn_reframed
from trainer.training.schedule import weights_at

TINY = SETTINGS["exact"]
ROOM = [100] * 20


class NothingFromTheHost(TorchDispatchMode):
    """Refuses what a recording cannot hold: the host asks the device for a number, or sends it some."""

    def __enter__(self) -> Any:
        # These send what a dispatch mode does not see.
        self.patches = [
            patch.object(owner, name, side_effect=AssertionError(f"{name} between host and device"))
            for owner, name in ((torch, "tensor"), (torch, "as_tensor"), (Tensor, "new_tensor"))
        ]
        for one in self.patches:
            one.start()
        return super().__enter__()

    def __exit__(self, *problem: Any) -> None:
        super().__exit__(*problem)
        for one in self.patches:
            one.stop()

    def __torch_dispatch__(self, function: Any, types: Any, arguments: Any = (), options: Any = None) -> Any:
        name = function.__name__.split(".")[0]
        assert name not in ("_local_scalar_dense", "nonzero", "item", "masked_select", "unique_dim", "_unique2"), name
        result = function(*arguments, **(options or {}))
        if name in ("_to_copy", "copy_", "lift_fresh", "to"):
            tensors = [part for part in (result, *arguments) if isinstance(part, Tensor)]
            assert len({tensor.device.type for tensor in tensors}) == 1, f"{name} between host and device"
        return result


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> torch.device:
    """A device whose tensors know shape and place only; kernels of Triton are not run there."""
    monkeypatch.setattr(renderer, "_resolved", lambda *_: "cuda")
    monkeypatch.setattr(cuda, "_check", lambda *_: None)
    monkeypatch.setattr("triton.runtime.interpreter.GridExecutor.__call__", lambda *_, **__: None)
    monkeypatch.setattr("triton.JITFunction.run", lambda *_, **__: None)
    monkeypatch.setattr(torch, "autocast", lambda *_, enabled: nullcontext())
    return torch.device("meta")


@pytest.mark.parametrize(
    ("model", "loss", "known"),
    [
        (TINY.model, LossConfig(independence_weight=1.0), False),
        (TINY.model, LossConfig(antialias="borders", antialias_e_step="contours"), False),
        (TINY.model, LossConfig(objective="paper"), False),
        (TINY.model, LossConfig(kind="silhouette"), False),
        (LIT, LossConfig(), False),
        (LIT, LossConfig(pose_supervision="azimuth"), True),
        (replace(TINY.model, symmetry="mirror"), LossConfig(), False),
        (BLOCKS, LossConfig(moved_steps=10), False),
        (TINY.model, LossConfig(neighbour_weight=1.0, e_step_centred_steps=0), False),
        (TINY.model, LossConfig(inversion_weight=1.0), False),
        (TINY.model, LossConfig(inversion_weight=1.0, inner_points="learnt"), False),
        (TINY.model, LossConfig(front_back_weight=1.0, front_back_knee=2.0), False),
    ],
)
def test_nothing_passes_between_host_and_device_in_a_recorded_step(
    model: ModelConfig, loss: LossConfig, known: bool, elsewhere: torch.device, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = replace(TINY, model=model, loss=loss, precision="float32")
    size = config.width, config.height
    here = model_of(config)
    geometry = moved_to(fixed_geometry(here, SceneConfig(*size), loss), elsewhere)
    monkeypatch.setattr(loop, "fixed_geometry", lambda *_: geometry)
    there = here.to(elsewhere)
    memory = Memory(model.latent).to(elsewhere)
    taking = stepping(there, SceneConfig(*size), config, elsewhere, memory)
    azimuths = torch.empty(8, device=elsewhere) if known else None
    images = torch.empty(8, 3, *size[::-1], device=elsewhere)
    given = Given(images, azimuths, weights_at(loss, 5, *size), torch.Generator())
    recording = Recording()
    with recording.at_work(ROOM):
        differentiate(there, 5.0, taking, given)
    with recording.at_work(ROOM), NothingFromTheHost():
        taken, _ = differentiate(there, 5.0, taking, given)
        memory.remember(taken.posterior.shape_mean, taken.azimuth)
    assert len(recording.sound) >= 2


def test_what_passes_between_host_and_device_would_be_noticed(elsewhere: torch.device) -> None:
    there = torch.empty(3, device=elsewhere)
    for asking in (lambda: there.new_tensor([1.0]), lambda: torch.zeros(3).to(there), there.nonzero):
        with pytest.raises(AssertionError), NothingFromTheHost():
            asking()


def test_nor_in_the_last_phase(elsewhere: torch.device, monkeypatch: pytest.MonkeyPatch) -> None:
    """That in which the encoder alone learns."""
    recording = Recording()

    def descend(optimiser: Any, differentiation: Any, given: Given) -> None:
        parts = differentiation.model, differentiation.gradient_clip, differentiation.forward, given
        with recording.at_work([]):
            differentiate(*parts)
        with recording.at_work([]), NothingFromTheHost():
            differentiate(*parts)

    monkeypatch.setattr(reframing, "descend", descend)
    frame = frame_in(SceneConfig(TINY.width, TINY.height))
    pictures = torch.empty(8, 3, TINY.height, TINY.width, device=elsewhere)
    look = Look(pictures.new_empty(8, LIT.latent), pictures.new_empty(8), pictures.new_empty(8))
    taught = iter([Lesson(pictures, look, step_generator(0, 0))])
    model = Model(LIT, TINY.width, TINY.height).to(elsewhere)
    config = replace(TINY, precision="float32")
    assert list(learn_reframed(model, config, frame, taught, 1, elsewhere)) == [None]
