"""How often a training writes what."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Intervals:
    """How often what is written, in steps."""

    log: int = 20
    """Figures in metrics.jsonl and TensorBoard, steps."""
    preview: int = 500
    """Pictures of reconstructions in previews/, and a look at the training's health in metrics.jsonl, steps."""
    checkpoint: int = 500
    """checkpoint.safetensors, steps; it is also written at the end and on Ctrl-C."""
