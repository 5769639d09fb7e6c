"""What goes back: a file, what is to be said about it, and how long each stage took."""

from dataclasses import dataclass
from typing import Literal

from service.report import Report

Form = Literal["glb", "png"]


@dataclass(frozen=True)
class Answer:
    """A GLB or PNG file and what is to be said about it."""

    content: bytes
    report: Report
    timings_ms: dict[str, float]
    """Milliseconds of each stage."""


@dataclass(frozen=True)
class Gallery:
    """Several objects in one GLB or PNG file."""

    content: bytes
    reports: tuple[Report, ...]
    timings_ms: dict[str, float]


def milliseconds(seconds: dict[str, float]) -> dict[str, float]:
    """Times of stages as they are told."""
    return {stage: round(1000 * value, 3) for stage, value in seconds.items()}
