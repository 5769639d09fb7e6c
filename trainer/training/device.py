"""Where a training computes: on the CPU, or on a GPU with nothing but the pictures' way there and figures' way back."""

from collections.abc import Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Final, Literal, TypeVar

import torch
from torch import Tensor

from trainer import processes
from trainer.errors import ConfigError, StorageError

Choice = Literal["auto", "cpu", "cuda"]
CPU: Final = torch.device("cpu")

Batch = TypeVar("Batch", bound=tuple[Any, ...])


def chosen_device(choice: Choice) -> torch.device:
    """`auto` is a GPU where torch finds one. Processes that train together on a machine take one each.

    Raises:
        ConfigError: there is no GPU, or there are fewer than processes.
    """
    found = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if choice == "cpu" or (choice == "auto" and not found):
        return CPU
    if found < processes.on_this_machine():
        needed = "a GPU" if processes.on_this_machine() == 1 else f"{processes.on_this_machine()} GPUs, one a process,"
        raise ConfigError(
            f"Expected {needed} for --device {choice}, found {found or 'none'} that torch {torch.__version__} can use. "
            "Install torch's CUDA build and a driver, start fewer processes, or train with --device cpu."
        )
    device = torch.device("cuda", processes.number_on_this_machine())
    torch.cuda.set_device(device)
    # What is asked for in float32 is computed in float32.
    torch.backends.cudnn.allow_tf32 = False
    return device


def sent_to(device: torch.device, minibatches: Generator[Batch]) -> Generator[Batch]:
    """The same minibatches, their tensors on the device; while one is learnt from, another thread gets the next one
    ready. To be closed, before `minibatches` are."""
    if device.type == "cpu":
        yield from minibatches
        return
    with ThreadPoolExecutor(1, "minibatches") as ahead:
        following = ahead.submit(next, minibatches)
        while True:
            batch = following.result()
            following = ahead.submit(next, minibatches)
            yield on(device, batch)


def on(device: torch.device, value: Any) -> Any:
    """The same tensors, in the same named tuples, on the device."""
    if isinstance(value, Tensor):
        # From pinned memory a copy does not hold up the CPU.
        return value.pin_memory().to(device, non_blocking=True)
    return type(value)(*(on(device, part) for part in value)) if isinstance(value, tuple) else value


@contextmanager
def enough_memory(device: torch.device, batch_size: int) -> Iterator[None]:
    """Raises StorageError where the device's memory, or the machine's, does not hold what the block computes."""
    try:
        yield
    except (torch.OutOfMemoryError, MemoryError, RuntimeError) as error:
        full = isinstance(error, torch.OutOfMemoryError | MemoryError) or "can't allocate memory" in str(error)
        if not full:
            raise
        where = "this machine" if device.type == "cpu" else "the GPU"
        raise StorageError(
            f"The memory of {where} does not hold a step of {batch_size} pictures. Lower --optimiser.batch-size, and "
            "continue with --resume from the last checkpoint, if there is one."
        ) from error
