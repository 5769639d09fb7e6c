"""`python -m trainer sample`"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import torch
import tyro

from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.evaluation.gallery import sample_rows
from trainer.evaluation.sheet import write_sheet
from trainer.evaluation.turntable import FRAMES, turntable
from trainer.training.checkpoint import load_checkpoint


@dataclass(frozen=True)
class SampleCommand:
    """Invent shapes: draw shape codes from the prior, and show each from four sides."""

    checkpoint: Path
    """Run directory or checkpoint."""
    output: Path = Path("samples.png")
    """PNG to write: a row for each shape."""
    count: int = 6
    """How many shapes, 1 to 100."""
    seed: int = 0
    """Seed of the shape codes, 0 or more."""
    temperature: float = 1.0
    """Standard deviation of the shape codes; 1 is the prior, less is more typical."""
    turntable: bool = False
    """Also write an animation in which all shapes turn, beside the PNG, as .webp."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required)

    def run(self) -> None:
        if not 1 <= self.count <= 100:
            raise ConfigError(f"Expected --count from 1 to 100, found {self.count}.")
        if not 0 <= self.temperature <= 10:
            raise ConfigError(f"Expected --temperature from 0 to 10, found {self.temperature}.")
        if not 0 <= self.seed < 2**63:
            raise ConfigError(f"Expected --seed from 0 to {2**63 - 1}, found {self.seed}.")
        if self.turntable and self.output.suffix.lower() != ".png":
            raise ConfigError(f"Expected --output to end in .png beside --turntable, found {self.output}.")
        checkpoint = load_checkpoint(self.checkpoint)
        generator = torch.Generator().manual_seed(self.seed)
        shape_codes = torch.randn(self.count, checkpoint.config.model.latent, generator=generator) * self.temperature
        with torch.no_grad():
            titles, rows = sample_rows(checkpoint.model, checkpoint.scene, shape_codes)
            moments = checkpoint.model.decode(shape_codes).expand(FRAMES, -1, -1, -1)
            turning = turntable(checkpoint.model.faces, checkpoint.scene, moments) if self.turntable else None
        write_sheet(self.output, rows, titles)
        if turning is not None:
            write_bytes(self.output.with_suffix(".webp"), turning)
        print(f"{self.count} samples of {checkpoint.category}: {self.output}")
