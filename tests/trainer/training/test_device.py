"""Trainings on a GPU, as far as can be told without one."""

from collections.abc import Generator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from tests.trainer.training.one_step import SETTINGS, moved_to
from tests.trainer.training.runs import EVERY_STEP, run, silent, with_steps
from trainer.config import LossConfig, ModelConfig, SceneConfig, TrainConfig
from trainer.data.images import ImageSet, frame_in
from trainer.data.source import Minibatch, step_generator
from trainer.errors import ConfigError, StorageError
from trainer.model.vae import Model
from trainer.rendering import renderer
from trainer.rendering.cpu import topology_of
from trainer.selection import bound
from trainer.selection.bound import held_out_bound
from trainer.training import device as device_module
from trainer.training import longer_look, reframing, step
from trainer.training.device import CPU, chosen_device, enough_memory, sent_to
from trainer.training.lessons import Lesson
from trainer.training.longer_look import Look, look_longer
from trainer.training.loop import fixed_geometry, train
from trainer.training.neighbours import Memory
from trainer.training.reframing import learn_reframed
from trainer.training.schedule import weights_at
from trainer.training.step import forward, number_format

GPU = torch.device("cuda", 0)
LIT = ModelConfig(
    latent=4, azimuth_bins=6, light="varying", light_bins=2, segments=2, encoder_channels=(4, 4, 8, 8, 8, 16)
)
BLOCKS = replace(LIT, parameterisation="full-block", light="fixed", symmetry="mirror")
TINY = SETTINGS["exact"]


@pytest.fixture
def no_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)


@pytest.mark.usefixtures("no_gpu")
def test_without_a_gpu_the_cpu_is_taken_unless_a_gpu_is_asked_for() -> None:
    assert chosen_device("cpu") == chosen_device("auto") == CPU
    with pytest.raises(ConfigError, match=r"Expected a GPU for --device cuda, found none .* --device cpu"):
        chosen_device("cuda")


@pytest.fixture
def gpus(monkeypatch: pytest.MonkeyPatch) -> list[torch.device]:
    """Two of them; those that are chosen are told."""
    chosen: list[torch.device] = []
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 2)
    monkeypatch.setattr(torch.cuda, "set_device", chosen.append)
    return chosen


@pytest.mark.parametrize("choice", ["auto", "cuda"])
def test_each_process_takes_a_gpu_of_its_own(
    choice: device_module.Choice, gpus: list[torch.device], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert chosen_device(choice) == GPU
    monkeypatch.setattr(device_module.processes, "on_this_machine", lambda: 2)
    monkeypatch.setattr(device_module.processes, "number_on_this_machine", lambda: 1)
    assert chosen_device(choice) == torch.device("cuda", 1)
    assert gpus == [GPU, torch.device("cuda", 1)]
    monkeypatch.setattr(device_module.processes, "on_this_machine", lambda: 3)
    with pytest.raises(ConfigError, match=r"Expected 3 GPUs, one a process, .* found 2"):
        chosen_device(choice)


def test_minibatches_are_sent_one_ahead_and_none_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Tensor, "pin_memory", lambda self: self)
    drawn: list[int] = []

    def minibatches() -> Generator[Minibatch]:
        for number in range(6):
            drawn.append(number)
            yield Minibatch(torch.empty(2, 3, 4, number + 1), torch.zeros(2), step_generator(0, number))

    there = sent_to(torch.device("meta"), minibatches())
    for number in range(6):
        pictures, azimuths, generator = next(there)
        assert azimuths is not None
        assert pictures.device.type == azimuths.device.type == "meta"
        assert pictures.shape[3] == number + 1
        assert generator.initial_seed() == number
        assert number < len(drawn) <= number + 2
    there.close()
    assert [len(one.pictures) for one in sent_to(CPU, minibatches())] == [2] * 6


@pytest.mark.parametrize(
    "asking",
    [
        lambda: torch.empty(2**60, dtype=torch.uint8),
        lambda: np.empty(2**60, np.uint8),
        lambda: _raise(torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 20.00 GiB")),
    ],
)
def test_too_little_memory_is_told(asking: Any) -> None:
    with (
        pytest.raises(
            StorageError, match=r"does not hold a step of 64 pictures. Lower --optimiser.batch-size, .*--resume"
        ),
        enough_memory(CPU, 64),
    ):
        asking()


def _raise(error: Exception) -> None:
    raise error


def test_other_errors_stay_what_they_are() -> None:
    with pytest.raises(RuntimeError, match="shapes"), enough_memory(CPU, 64):
        raise RuntimeError("shapes cannot be multiplied")


def test_bfloat16_is_asked_of_the_device_that_computes(monkeypatch: pytest.MonkeyPatch) -> None:
    for able in (True, False):
        monkeypatch.setattr(torch.cuda, "is_bf16_supported", lambda including_emulation, able=able: able)
        monkeypatch.setattr(torch.cpu, "get_capabilities", lambda able=able: {"avx512_bf16": not able})
        assert (number_format("auto", GPU) == torch.bfloat16) is able
        assert (number_format("auto", CPU) == torch.bfloat16) is not able
    assert number_format("float32", GPU) == torch.float32


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> torch.device:
    """A device whose tensors know shape and place only. What is drawn comes from where the vertices are."""

    def expected(screen: Tensor, colours: Tensor, images: Tensor, weights: Tensor, *_: Any) -> Tensor:
        return (screen.sum() + colours.sum() + images.sum()) * weights.flatten(1).sum(1)

    def values(screen: Tensor, colours: Tensor, images: Tensor, *_: Any) -> Tensor:
        return colours.sum((2, -1)) + (screen.sum() + images.sum())

    monkeypatch.setattr(renderer, "expected_log_likelihood", expected)
    monkeypatch.setattr(renderer, "log_likelihood", values)
    monkeypatch.setattr(step, "check_vertices", lambda vertices: None)
    monkeypatch.setattr(torch, "autocast", lambda *_, enabled: nullcontext())
    return torch.device("meta")


@pytest.mark.parametrize(
    ("model", "loss", "known", "views"),
    [
        (TINY.model, LossConfig(), False, 1),
        (TINY.model, LossConfig(objective="paper"), False, 1),
        (LIT, LossConfig(), False, 2),
        (LIT, LossConfig(pose_supervision="azimuth"), True, 1),
        (BLOCKS, LossConfig(moved_steps=10), False, 1),
        (LIT, LossConfig(neighbour_weight=1.0, e_step_centred_steps=0), False, 2),
        (TINY.model, LossConfig(inversion_weight=1.0), False, 1),
        (TINY.model, LossConfig(inversion_weight=1.0, inner_points="learnt"), False, 1),
        (TINY.model, LossConfig(front_back_weight=1.0, front_back_knee=2.0), False, 1),
    ],
)
def test_a_step_is_on_one_device(
    model: ModelConfig, loss: LossConfig, known: bool, views: int, elsewhere: torch.device
) -> None:
    """An operation on tensors of two devices would raise, and so would a number that the host asks for."""
    size = TINY.width, TINY.height
    here = Model(model, *size, lattice=loss.inner_points == "learnt")
    geometry = moved_to(fixed_geometry(here, SceneConfig(*size), loss), elsewhere)
    there, images = here.to(elsewhere), torch.empty(8, 3, *size[::-1], device=elsewhere)
    azimuths = torch.empty(8, device=elsewhere) if known else None
    weights, generator = weights_at(loss, 5, *size), torch.Generator()
    seen = geometry, SceneConfig(*size), loss, weights, images, azimuths, generator, torch.float32, views
    result = forward(there, *seen, Memory(model.latent).to(elsewhere))
    result.loss().backward()
    gradients = [parameter.grad for parameter in there.parameters() if parameter.grad is not None]
    assert len(gradients) > 10
    assert {gradient.device for gradient in gradients} == {elsewhere}


def test_what_lies_on_the_host_would_be_noticed(elsewhere: torch.device) -> None:
    there = Model(TINY.model, TINY.width, TINY.height).to(elsewhere)
    with pytest.raises(RuntimeError, match="not on the expected device"):
        there.decode(torch.zeros(1, TINY.model.latent))


def test_the_last_phase_is_on_one_device(elsewhere: torch.device, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Tensor] = []

    def noting(optimiser: Any, differentiation: Any, given: Any) -> None:
        result = differentiation.forward(given)
        result.loss().backward()
        seen.append(result.divergence)

    monkeypatch.setattr(reframing, "descend", noting)
    frame = frame_in(SceneConfig(TINY.width, TINY.height))
    pictures = torch.empty(8, 3, TINY.height, TINY.width, device=elsewhere)
    look = Look(pictures.new_empty(8, LIT.latent), pictures.new_empty(8), pictures.new_empty(8))
    taught = (Lesson(pictures, look, step_generator(0, number)) for number in range(2))
    model = Model(LIT, TINY.width, TINY.height).to(elsewhere)
    config = replace(TINY, precision="float32")
    assert len(list(learn_reframed(model, config, frame, taught, 2, elsewhere))) == 2
    assert [(divergence.device, len(divergence)) for divergence in seen] == [(elsewhere, 8)] * 2


@pytest.mark.parametrize("part", [longer_look, bound], ids=["a longer look", "the bound by which a start is chosen"])
def test_so_is(part: ModuleType, elsewhere: torch.device, monkeypatch: pytest.MonkeyPatch) -> None:
    model, scene = Model(LIT, TINY.width, TINY.height).eval(), SceneConfig(TINY.width, TINY.height)
    topology = topology_of(model.faces)
    monkeypatch.setattr(part, "topology_of", lambda _: topology)
    pictures = torch.empty(8, 3, TINY.height, TINY.width, device=elsewhere)
    model.to(elsewhere)
    found: list[Tensor | None]
    if part is longer_look:
        found = list(look_longer(model, scene, replace(TINY, model=LIT), pictures, 2))
    else:
        found = [held_out_bound(model, scene, LossConfig(), pictures, 2, torch.Generator()).value]
    assert {(tensor.device, len(tensor)) for tensor in found if tensor is not None} == {(elsewhere, 8)}


def test_a_step_with_triton_s_kernels_is_the_step_of_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """In its interpreter, or on a GPU where there is one."""
    monkeypatch.setattr(torch.backends.cudnn, "allow_tf32", False)
    config = replace(TINY, model=replace(TINY.model, azimuth_bins=2, segments=1))
    found = []
    for backend in ("cpu", "cuda"):
        where = torch.device("cuda") if backend == "cuda" and torch.cuda.is_available() else CPU
        monkeypatch.setattr(renderer, "_resolved", lambda *_, backend=backend: backend)
        torch.manual_seed(0)
        # Not for training: the normalisation of small batches makes much of rounding.
        model = Model(config.model, config.width, config.height).eval().to(where)
        scene = SceneConfig(config.width, config.height)
        geometry = fixed_geometry(model, scene, config.loss)
        images = torch.rand(2, 3, config.height, config.width, generator=torch.Generator().manual_seed(1)).to(where)
        weights = weights_at(config.loss, 5, config.width, config.height)
        seen = geometry, scene, config.loss, weights, images, None, torch.Generator().manual_seed(2)
        result = forward(model, *seen)
        result.loss().backward()
        gradients = [parameter.grad for parameter in model.parameters() if parameter.grad is not None]
        found.append([result.loss().detach().cpu(), *(gradient.cpu() for gradient in gradients)])
    for one, other in zip(*found, strict=True):
        torch.testing.assert_close(one, other, rtol=1e-4, atol=1e-5 * max(1.0, float(one.abs().max())))


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
def test_a_training_on_a_gpu_goes_on_on_the_cpu(config: TrainConfig, images: ImageSet, tmp_path: Path) -> None:
    first = with_steps(config, 4)
    last = train(first, images, "chair", tmp_path, EVERY_STEP, False, silent, {"images": "here"}, device=GPU)
    assert {parameter.device for parameter in last.model.parameters()} == {CPU}
    assert run(with_steps(config, 6), images, tmp_path, resume=True).step == 6
