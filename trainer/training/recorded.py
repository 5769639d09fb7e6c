"""Steps on a GPU as one recorded sequence of kernels.

A step is more than a thousand small kernels, and a GPU has done with one before the CPU has launched the next. A CUDA
graph launches them all at once. It knows the memory that it was recorded on and no other: pictures and weights are
copied there, and lists have the lengths that the steps before needed, with some to spare (`trainer.recording`). A step
that needs more is taken again by itself, and the next one recorded anew; and so it is where lists have become much
shorter, as they do while poses become certain.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any, Final, Generic

import torch
from torch import nn

from trainer import processes
from trainer.recording import Recording
from trainer.training.descent import Descent, Differentiation, Given, Result, Unrecorded, differentiate, put_back
from trainer.training.longer_look import Look

# Weights that change from step to step are numbers in memory; the others are part of what is recorded.
COOLING: Final = ("kl", "temperature", "encoder_prior", "laplacian")
# Room for a list, as a multiple of what it needed, and entries more.
SPARE: Final = 1.25
SPARE_ENTRIES: Final = 16
# After so many steps in which a list never filled so much of its room, less is recorded.
PATIENCE: Final = 50
FILLED: Final = 0.6


def differentiation_on(
    device: torch.device,
    model: nn.Module,
    gradient_clip: float,
    forward: Callable[[Given], Result],
    record: bool = True,
) -> Differentiation[Result]:
    """Recorded on a GPU, if it may be; not where several processes train together."""
    if record and device.type == "cuda" and processes.count() == 1:
        return Recorded(model, gradient_clip, forward)
    return Unrecorded(model, gradient_clip, forward)


class Recorded(Differentiation[Result]):
    """Computes what `descent.Unrecorded` does, up to the order in which a GPU adds. Tensors of a result hold until the
    next step."""

    def __init__(self, model: nn.Module, gradient_clip: float, forward: Callable[[Given], Result]) -> None:
        self.model, self.gradient_clip, self.forward = model, gradient_clip, forward
        self.kind: object = None
        self.recording = Recording()
        self.room: list[int] | None = None
        self.graph: _Graph[Result] | None = None
        self.stream = _stream()

    def __call__(self, given: Given) -> Descent[Result] | None:
        kind = _kind_of(given)
        if kind != self.kind:
            self.kind, self.recording, self.room, self.graph = kind, Recording(), None, None
            self.inputs = _Inputs(given)
        self.inputs.fill(given)
        self.recording.draw_noise(given.generator)
        seen = self.inputs.as_given(given)
        if self.room is None:
            return self._by_itself(seen)
        if self.graph is None:
            self.graph = _Graph(self, seen, self.room)
        taken = self.graph.replay()
        if self.graph.overflown:
            self.graph = None
            return self._by_itself(seen)
        less = self.graph.less_room()
        if less is not None:
            self.graph, self.room = None, less
        return taken

    def _by_itself(self, seen: Given) -> Descent[Result] | None:
        """The step, and what room it needed."""
        before = [buffer.clone() for buffer in self.model.buffers()]
        self.model.zero_grad()
        self.stream.wait_stream(torch.cuda.current_stream())
        with self.recording.at_work(None), torch.cuda.stream(self.stream):
            result, norm = differentiate(self.model, self.gradient_clip, self.forward, seen)
        torch.cuda.current_stream().wait_stream(self.stream)
        room = [roomy(int(needed)) for needed in self.recording.needed]
        # No less than before: it was too little for one of the lists, and they shrink and grow together.
        self.room = room if self.room is None else [max(pair) for pair in zip(self.room, room, strict=True)]
        gradient_norm = float(norm)
        if all(self.recording.sound) and math.isfinite(gradient_norm):
            return Descent(result, gradient_norm)
        put_back(self.model, before)
        return None


class _Graph(Generic[Result]):
    """A recorded step."""

    def __init__(self, steps: Recorded[Result], seen: Given, room: list[int]) -> None:
        self.model, self.room = steps.model, room
        self.graph = torch.cuda.CUDAGraph()
        self.model.zero_grad()
        # Pictures are drawn from their folder in another thread, which may do meanwhile what a recording must not.
        recorded = torch.cuda.graph(self.graph, stream=steps.stream, capture_error_mode="thread_local")
        with steps.recording.at_work(room), recorded:
            self.before = [buffer.clone() for buffer in self.model.buffers()]
            self.result, norm = differentiate(self.model, steps.gradient_clip, steps.forward, seen)
            told = norm, *steps.recording.needed, *steps.recording.sound
            self.told = torch.stack([number.double() for number in told])
        self.gradients = [(parameter, parameter.grad) for parameter in self.model.parameters()]
        self.overflown = False
        self.most, self.replays = [0.0] * len(room), 0

    def replay(self) -> Descent[Result] | None:
        self.graph.replay()
        for parameter, gradient in self.gradients:
            parameter.grad = gradient
        norm, *others = self.told.tolist()
        needed, sound = others[: len(self.room)], others[len(self.room) :]
        self.overflown = any(one > room for one, room in zip(needed, self.room, strict=True))
        self.most = [max(pair) for pair in zip(self.most, needed, strict=True)]
        self.replays += 1
        if all(sound) and math.isfinite(norm) and not self.overflown:
            return Descent(self.result, norm)
        put_back(self.model, self.before)
        return None

    def less_room(self) -> list[int] | None:
        """What room would do, where a list has long had much more than it needs. Asked after every replay."""
        if self.replays < PATIENCE:
            return None
        enough = [roomy(most) for most in self.most]
        self.most, self.replays = [0.0] * len(self.room), 0
        much = any(FILLED * room > less for room, less in zip(self.room, enough, strict=True))
        return enough if much else None


def roomy(needed: float) -> int:
    return math.ceil(SPARE * needed) + SPARE_ENTRIES


class _Inputs:
    """What changes from step to step, in memory that stays."""

    def __init__(self, given: Given) -> None:
        self.pictures = torch.empty_like(given.pictures)
        self.azimuths = None if given.azimuths is None else torch.empty_like(given.azimuths)
        self.look = given.look and given.look.each(torch.empty_like)
        self.cooling = given.pictures.new_empty(len(COOLING))

    def fill(self, given: Given) -> None:
        self.pictures.copy_(given.pictures)
        if self.azimuths is not None and given.azimuths is not None:
            self.azimuths.copy_(given.azimuths)
        _copy(given.look, self.look)
        if given.weights is not None:
            self.cooling.copy_(torch.tensor([getattr(given.weights, name) for name in COOLING]))

    def as_given(self, given: Given) -> Given:
        weights = given.weights
        if weights is not None:
            in_memory: dict[str, Any] = dict(zip(COOLING, self.cooling.unbind(), strict=True))
            weights = weights._replace(**in_memory)
        return Given(self.pictures, self.azimuths, weights, given.generator, self.look)


def _copy(source: Look | None, target: Look | None) -> None:
    for given, kept in zip(source or (), target or (), strict=True):
        if given is not None and kept is not None:
            kept.copy_(given)


@cache
def _stream() -> torch.cuda.Stream:
    """One for all recordings: a parameter's gradient is accumulated on the stream of its first use, which must be the
    graph's, also where another phase of the training learns from the same parameters."""
    return torch.cuda.Stream()


def _kind_of(given: Given) -> tuple[Any, ...]:
    """Steps of one kind can be replayed from one recording."""
    weights = None if given.weights is None else given.weights._asdict()
    kept = [(name, weight) for name, weight in (weights or {}).items() if name not in COOLING]
    return tuple(given.pictures.shape), given.azimuths is None, given.look is None, kept
