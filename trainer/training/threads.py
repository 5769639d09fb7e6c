"""How many cores a training takes."""

import numba
import torch

from trainer.errors import ConfigError


def limit_threads(count: int) -> None:
    """Limits torch's and numba's threads to `count`; 0 leaves both at one per core. Raises ConfigError beyond that."""
    most = numba.config.NUMBA_NUM_THREADS
    if not 0 <= count <= most:
        raise ConfigError(f"Expected --threads from 0 to {most}, all that this machine offers, found {count}.")
    if count:
        torch.set_num_threads(count)
        numba.set_num_threads(count)
