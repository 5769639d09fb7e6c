"""Threads of a training wait asleep, so that other programs on the machine do not slow it down."""

import os
import subprocess
import sys

import pytest

from trainer import SPIN_COUNT

PROGRAM = """
import os, sys
import trainer
print(os.environ.get("GOMP_SPINCOUNT", "unset"), "torch" in sys.modules)
"""


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ({}, str(SPIN_COUNT)),
        ({"GOMP_SPINCOUNT": "7"}, "7"),
        ({"OMP_WAIT_POLICY": "ACTIVE"}, "unset"),
    ],
)
def test_it_is_said_before_torch_is_imported_unless_the_user_has_chosen(chosen: dict[str, str], told: str) -> None:
    known = {name: value for name, value in os.environ.items() if name not in ("GOMP_SPINCOUNT", "OMP_WAIT_POLICY")}
    said = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=known | chosen, check=True, capture_output=True, text=True
    )
    assert said.stdout.split() == [told, "False"]
