"""What differs in a computation that is recorded once, as a CUDA graph, and then replayed on the same memory.

A replay runs the same kernels again, whatever numbers they meet: nothing can be asked of the device in between, and
nothing can be handed to it but through memory that both know. So, while a `Recording` is at work, lists have lengths
that were agreed on beforehand, what would be refused is told afterwards, and noise stands in tensors that are filled
before each replay. Without one, all of this is as it reads: asked, refused, drawn.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor


class Recording:
    """The agreements of one computation, which asks for the same things in the same order each time."""

    def __init__(self) -> None:
        self.room: list[int] | None = None
        """Of each list; None: as much as needed, which has to be asked of the device."""
        self.needed: list[Int[Tensor, ""]] = []
        """Of each list, in the last run."""
        self.sound: list[Bool[Tensor, ""]] = []
        """What had to be true in the last run, or else its outcome is worth nothing."""
        self._noise: list[Tensor] = []
        self._taken = 0

    @contextmanager
    def at_work(self, room: list[int] | None) -> Iterator[None]:
        """One run, with so much room for each list."""
        global _at_work  # noqa: PLW0603  # Not of one thread: torch runs backward passes in another.
        self.room, self.needed, self.sound, self._taken = room, [], [], 0
        _at_work = self
        try:
            yield
        finally:
            _at_work = None

    def draw_noise(self, generator: torch.Generator) -> None:
        """Fills the noise of the next run as the first run drew its own."""
        for kept in self._noise:
            kept.copy_(torch.randn(kept.shape, generator=generator, dtype=kept.dtype))

    def next_noise(
        self, shape: tuple[int, ...], generator: torch.Generator, dtype: torch.dtype, device: torch.device
    ) -> Tensor:
        if self._taken == len(self._noise):
            self._noise.append(torch.randn(shape, generator=generator, dtype=dtype).to(device))
        self._taken += 1
        return self._noise[self._taken - 1]


_at_work: Recording | None = None


def is_recorded() -> bool:
    return _at_work is not None


def length(needed: Int[Tensor, ""]) -> int:
    """How long a list is to be that needs so many entries: just so long, or as agreed. What is agreed may be more than
    needed or, in a run whose outcome will be thrown away, less."""
    if _at_work is None:
        return int(needed)
    _at_work.needed.append(needed)
    return int(needed) if _at_work.room is None else _at_work.room[len(_at_work.needed) - 1]


def is_sound(condition: Bool[Tensor, ""]) -> bool:
    """Whether it is true; if recorded, True for now."""
    if _at_work is None:
        return bool(condition)
    _at_work.sound.append(condition)
    return True


def harmless(values: Float[Tensor, "*N"]) -> Float[Tensor, "*N"]:
    """The same values; if recorded, 0 for those that are not finite, which nobody has been able to refuse."""
    return values if _at_work is None else values.nan_to_num(0.0, 0.0, 0.0)


def normal_noise(
    shape: tuple[int, ...], generator: torch.Generator, dtype: torch.dtype, device: torch.device
) -> Float[Tensor, "*N"]:
    """Standard normal, from the generator, which is on the CPU: a seed means the same on every device."""
    if _at_work is None:
        return torch.randn(shape, generator=generator, dtype=dtype).to(device)
    return _at_work.next_noise(shape, generator, dtype, device)
