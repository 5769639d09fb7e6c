"""What a training leaves in its run directory while it runs.

config.json          the resolved settings
metrics.jsonl        one JSON object per logged step
log.txt              what happened, one line each
tensorboard/         the same figures, for TensorBoard
previews/*.png       held-out pictures, their reconstructions, and the same shapes from two other sides
"""

import json
import time
from pathlib import Path
from types import TracebackType
from typing import Self

import torch
from jaxtyping import Float
from torch import Tensor
from torch.utils.tensorboard.writer import SummaryWriter

from trainer.config import SceneConfig, TrainConfig
from trainer.errors import StorageError
from trainer.evaluation.gallery import reconstruction_rows
from trainer.evaluation.sheet import write_sheet
from trainer.mapping import to_mapping
from trainer.model.vae import Model


class Journal:
    """Context manager; lines of metrics.jsonl after `start` (a resumed run's lost steps) are dropped on entry."""

    def __init__(self, directory: Path, config: TrainConfig, start: int) -> None:
        self.directory = directory
        try:
            directory.mkdir(parents=True, exist_ok=True)
            (directory / "config.json").write_text(json.dumps(to_mapping(config), indent=2) + "\n")
            metrics = directory / "metrics.jsonl"
            kept = []
            if start and metrics.exists():
                kept = [line for line in metrics.read_text().splitlines() if json.loads(line)["step"] <= start]
            metrics.write_text("".join(line + "\n" for line in kept))
            self._metrics = metrics.open("a")
        except OSError as error:
            raise StorageError(f"The run directory {directory} cannot be written ({error}). Name another.") from error
        self._board = SummaryWriter(str(directory / "tensorboard"), purge_step=start)  # type: ignore[no-untyped-call]
        self._began = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._metrics.close()
        self._board.close()  # type: ignore[no-untyped-call]

    def log(self, step: int, figures: dict[str, float]) -> None:
        seconds = round(time.monotonic() - self._began, 3)
        self._metrics.write(json.dumps({"step": step, "seconds": seconds} | figures) + "\n")
        self._metrics.flush()
        for name, value in figures.items():
            self._board.add_scalar(name, value, step)  # type: ignore[no-untyped-call]

    def note(self, line: str) -> None:
        with (self.directory / "log.txt").open("a") as log:
            log.write(line + "\n")

    def preview(self, step: int, model: Model, scene: SceneConfig, images: Float[Tensor, "B 3 H W"]) -> None:
        """Writes previews/<step>.png; the model is left in evaluation mode."""
        model.eval()
        with torch.no_grad():
            titles, rows = reconstruction_rows(model, scene, images)
        write_sheet(self.directory / "previews" / f"{step:06d}.png", rows, titles)
