"""How many cores a training takes."""

import numba
import torch

from trainer import processes
from trainer.errors import ConfigError


def limit_threads(count: int) -> None:
    """Limits torch's and numba's threads to `count`; 0 means one per core, shared among the processes that train
    together on this machine. Raises ConfigError beyond that."""
    most = numba.config.NUMBA_NUM_THREADS
    if not 0 <= count <= most:
        raise ConfigError(f"Expected --threads from 0 to {most}, all that this machine offers, found {count}.")
    if not count and processes.on_this_machine() > 1:
        count = max(1, most // processes.on_this_machine())
    if count:
        torch.set_num_threads(count)
        numba.set_num_threads(count)


def agree_on_threads() -> None:
    """Gives torch and numba the smaller of their numbers of threads.

    Where OpenMP runs numba's kernels, the first of them sets how many threads torch has from then on. Were that another
    number than before (OMP_NUM_THREADS sets torch's alone), the first step after each start would sum in another order
    than the same step of a training that was not interrupted.
    """
    count = min(torch.get_num_threads(), numba.get_num_threads())
    torch.set_num_threads(count)
    numba.set_num_threads(count)
