"""What a training leaves in its run directory while it runs.

config.json          the resolved settings
metrics.jsonl        one JSON object per logged step: `figures_of`, and with every preview `health_of`; of the last
                     phase (`training.reframing`) its loss alone
log.txt              what happened, one line each
tensorboard/         the same figures, for TensorBoard
previews/*.png       held-out pictures, their reconstructions, and the same shapes from three other sides
"""

import json
import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

import torch
from jaxtyping import Float
from torch import Tensor
from torch.utils.tensorboard.writer import SummaryWriter

from trainer.config import SceneConfig, TrainConfig
from trainer.data.writing import discard_parts, write_bytes
from trainer.errors import StorageError
from trainer.evaluation.gallery import reconstruction_rows
from trainer.evaluation.sheet import write_sheet
from trainer.mapping import to_mapping
from trainer.model.vae import Model


class Journal:
    """Context manager; lines of metrics.jsonl after `start` (a resumed run's lost steps) are dropped on entry.

    `seconds_before` is what earlier parts of the training took. Every method raises StorageError on a full disk.
    """

    def __init__(self, directory: Path, config: TrainConfig, start: int, seconds_before: float = 0.0) -> None:
        self.directory = directory
        metrics = directory / "metrics.jsonl"
        with self._storage():
            discard_parts(directory)
            kept = _lines_until(start, metrics) if start else []
            write_bytes(directory / "config.json", (json.dumps(to_mapping(config), indent=2) + "\n").encode())
            write_bytes(metrics, "".join(kept).encode())
            self._metrics = metrics.open("a")
            self._board = SummaryWriter(str(directory / "tensorboard"), purge_step=start + 1)
        self._began = time.monotonic() - seconds_before

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        with self._storage():
            self._metrics.close()
            self._board.close()

    def log(self, step: int, figures: dict[str, float]) -> None:
        """A line of metrics.jsonl and the curves of TensorBoard. JSON knows no NaN: such a figure is null there."""
        known = {name: value if math.isfinite(value) else None for name, value in figures.items()}
        line = {"step": step, "seconds": round(time.monotonic() - self._began, 3)} | known
        with self._storage():
            self._metrics.write(json.dumps(line) + "\n")
            self._metrics.flush()
            for name, value in figures.items():
                self._board.add_scalar(name, value, step)

    def note(self, line: str) -> None:
        """A line of log.txt."""
        with self._storage(), (self.directory / "log.txt").open("a") as log:
            log.write(line + "\n")

    def preview(self, step: int, model: Model, scene: SceneConfig, images: Float[Tensor, "B 3 H W"]) -> None:
        """Writes previews/<step>.png; the model is left in evaluation mode."""
        model.eval()
        with torch.no_grad():
            titles, rows = reconstruction_rows(model, scene, images)
        write_sheet(self.directory / "previews" / f"{step:06d}.png", rows, titles)

    @contextmanager
    def _storage(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise StorageError(
                f"The run directory {self.directory} cannot be written ({error.strerror or error}). Make room and "
                "continue with --resume from its last checkpoint, or name another directory."
            ) from error


def _lines_until(step: int, metrics: Path) -> list[str]:
    """The whole lines of an earlier part, up to a step; a line that a crash has cut short is dropped."""
    kept = []
    for line in metrics.read_text().splitlines() if metrics.exists() else []:
        try:
            if json.loads(line)["step"] <= step:
                kept.append(line + "\n")
        except (ValueError, TypeError, KeyError):
            continue
    return kept
