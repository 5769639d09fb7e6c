"""Torch and numba share OpenMP's threads, and must not have different numbers of them."""

import os
import subprocess
import sys

PROGRAM = """
import numba, torch
from trainer.training.threads import agree_on_threads
agree_on_threads()
before = torch.get_num_threads()
@numba.njit(parallel=True)
def total(values):
    found = 0.0
    for k in numba.prange(len(values)):
        found += values[k]
    return found
total(torch.ones(100).numpy())
print(before, numba.get_num_threads(), torch.get_num_threads())
"""


def test_a_kernel_does_not_change_how_many_threads_torch_has() -> None:
    known = os.environ | {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "2"}
    told = subprocess.run([sys.executable, "-c", PROGRAM], env=known, check=True, capture_output=True, text=True)
    assert told.stdout.split() == ["1", "1", "1"]
