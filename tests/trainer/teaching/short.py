"""Trainings of a step or two, in silence."""

import io

from rich.console import Console

QUIET = Console(file=io.StringIO())
SHORT = ["--optimiser.batch-size", "4", "--threads", "1", "--model.encoder-channels", "4", "4", "4", "4", "4", "8"]
