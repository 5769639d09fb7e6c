"""Several processes that train one model, each on its share of every batch. Of a single one nothing is asked.

`torchrun` starts them and says in the environment who they are; they talk through gloo, and through nccl about what
lies on GPUs. What a batch has in common (the aggregate posterior, the statistics of the batch normalisation) is that of
the whole batch, so that any number of processes computes what one would.
"""

import gc
import importlib
import os
from collections.abc import Iterator
from contextlib import contextmanager

import torch
from torch import Tensor, autograd, distributed

from trainer.errors import ConfigError


@contextmanager
def joined() -> Iterator[None]:
    """Joins the other processes that torchrun has started, if any. Raises ConfigError where they cannot meet."""
    if int(os.environ.get("WORLD_SIZE", "1")) == 1:
        yield
        return
    # DistributedDataParallel imports it, and its functions keep the group they find as a default for good: now none.
    # gloo's threads end with the group, and one that lets go of a tensor while Python ends aborts the process.
    importlib.import_module("torch.distributed.nn.functional")
    try:
        distributed.init_process_group("cpu:gloo,cuda:nccl" if torch.cuda.is_available() else "gloo")
    except (RuntimeError, ValueError) as error:
        raise ConfigError(
            f"Expected {os.environ['WORLD_SIZE']} processes to meet, as WORLD_SIZE says, found that they cannot "
            f"({error}). Start them with torchrun, or unset WORLD_SIZE."
        ) from error
    try:
        yield
    finally:
        distributed.destroy_process_group()
        gc.collect()  # What trained refers to itself, and to the group.


def count() -> int:
    return distributed.get_world_size() if distributed.is_initialized() else 1


def number() -> int:
    """Of this process, from 0. Number 0 writes and reports for all."""
    return distributed.get_rank() if distributed.is_initialized() else 0


def on_this_machine() -> int:
    """How many of them share this machine's cores."""
    return int(os.environ.get("LOCAL_WORLD_SIZE", "1")) if distributed.is_initialized() else 1


def number_on_this_machine() -> int:
    """Of this process among those, from 0."""
    return int(os.environ.get("LOCAL_RANK", "0")) if distributed.is_initialized() else 0


def share(size: int) -> slice:
    """This process's part of a batch; all are of one size, which divides the batch's."""
    own = size // count()
    return slice(number() * own, (number() + 1) * own)


def whole(part: Tensor) -> Tensor:
    """The parts of all processes, one after the other along the first axis; without gradient."""
    if count() == 1:
        return part
    parts = [torch.empty_like(part, memory_format=torch.contiguous_format) for _ in range(count())]
    distributed.all_gather(parts, part.detach().contiguous())
    return torch.cat(parts)


def mean(value: Tensor) -> Tensor:
    """The mean over all processes. Its gradient reaches each process's own value."""
    if count() == 1:
        return value
    found: Tensor = _Mean.apply(value)  # type: ignore[no-untyped-call]
    return found


def anywhere(true_here: bool) -> bool:
    """Whether it is true in any process; all get the same answer."""
    if count() == 1:
        return true_here
    found = torch.tensor(float(true_here))
    distributed.all_reduce(found, distributed.ReduceOp.MAX)
    return bool(found)


class _Mean(autograd.Function):
    """Linear, and its own transpose."""

    @staticmethod
    def forward(context: object, value: Tensor) -> Tensor:
        summed = value.clone(memory_format=torch.contiguous_format)
        distributed.all_reduce(summed)
        return summed / count()

    @staticmethod
    def backward(context: object, *gradients: Tensor) -> Tensor:
        return _Mean.forward(context, gradients[0])
