"""What a candidate has shown after so many steps, as it lies on the disk."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.data.writing import write_bytes
from trainer.errors import ConfigError, DataError
from trainer.mapping import from_mapping, to_mapping


@dataclass(frozen=True)
class Record:
    """A candidate's bound at a rung; each tuple holds the mean over its pictures of every held-out object, nats."""

    step: int
    training_core_seconds: float
    """From the first step on, of all cores that computed."""
    judging_core_seconds: float
    """What this judgement took, likewise."""
    log_likelihood: tuple[float, ...] = ()
    """These three are the parts of `selection.bound.Bound`."""
    shape_nats: tuple[float, ...] = ()
    angle_nats: tuple[float, ...] = ()
    problem: str | None = None
    """Why training or judgement failed; then there are no numbers."""

    @property
    def values(self) -> NDArray[np.float64]:
        """The bound itself."""
        likelihood, shape, angle = map(np.array, (self.log_likelihood, self.shape_nats, self.angle_nats))
        bound: NDArray[np.float64] = likelihood - shape - angle
        return bound

    @property
    def mean(self) -> float:
        return float(self.values.mean())


class Mean(NamedTuple):
    """A mean over objects, nats."""

    value: float
    standard_error: float


def mean_of(values: NDArray[np.float64]) -> Mean:
    """Of two objects or more."""
    return Mean(float(values.mean()), float(values.std(ddof=1)) / math.sqrt(len(values)))


def paired(better: Record, worse: Record) -> Mean:
    """How much likelier the same objects are under one model than under another."""
    return mean_of(better.values - worse.values)


def told(mean: Mean) -> str:
    return f"{mean.value:.2f} ± {mean.standard_error:.2f}"


def save_record(path: Path, record: Record) -> None:
    """Raises StorageError where the file cannot be written."""
    write_bytes(path, (json.dumps(to_mapping(record)) + "\n").encode())


def load_record(path: Path) -> Record | None:
    """None where there is none yet. Raises DataError for a file that is none."""
    if not path.exists():
        return None
    try:
        return from_mapping(Record, json.loads(path.read_text(encoding="utf-8")), "the record")
    except (ValueError, ConfigError) as error:
        raise DataError(f"{path}: expected a record of `trainer select`, found {error} Delete the file.") from error
