"""`python -m trainer sample`"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import torch
import tyro
from jaxtyping import Float
from torch import Tensor

from trainer.data.images import load_image_folder
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.evaluation.gallery import sample_rows
from trainer.evaluation.self_consistency import consistent_posterior
from trainer.evaluation.sheet import write_sheet
from trainer.evaluation.turntable import FRAMES, turntable
from trainer.training.checkpoint import Checkpoint, load_checkpoint

_BATCH = 64


@dataclass(frozen=True)
class SampleCommand:
    """Invent shapes: draw shape codes, and show each shape from four sides."""

    checkpoint: Path
    """Run directory or checkpoint."""
    images: Path | None = None
    """A folder of pictures of the class, 40 at least, such as those that were trained on: codes are drawn from where
    those of a thousand lie, as far as the model knows its shapes again. Without it they are drawn from the prior, which
    is larger than that."""
    output: Path = Path("samples.png")
    """PNG to write: a row for each shape."""
    count: int = 6
    """How many shapes, 1 to 100."""
    seed: int = 0
    """Seed of the shape codes, 0 or more."""
    temperature: float = 1.0
    """Standard deviation of the shape codes, as a multiple of what it is; less is more typical."""
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
        shape_codes = self._shape_codes(checkpoint)
        with torch.no_grad():
            titles, rows = sample_rows(checkpoint.model, checkpoint.scene, shape_codes)
            moments = checkpoint.model.decode(shape_codes).expand(FRAMES, -1, -1, -1)
            turning = turntable(checkpoint.model.faces, checkpoint.scene, moments) if self.turntable else None
        write_sheet(self.output, rows, titles)
        if turning is not None:
            write_bytes(self.output.with_suffix(".webp"), turning)
        print(f"{self.count} samples of {checkpoint.category}: {self.output}")

    def _shape_codes(self, checkpoint: Checkpoint) -> Float[Tensor, "N Z"]:
        generator = torch.Generator().manual_seed(self.seed)
        noise = torch.randn(self.count, checkpoint.config.model.latent, generator=generator)
        if self.images is None:
            return noise * self.temperature
        scene = checkpoint.scene
        pictures = load_image_folder(self.images, scene.width, scene.height, scene)
        batches = (pictures.batch(rows) for rows in torch.arange(len(pictures)).split(_BATCH))
        density = consistent_posterior(checkpoint.model, scene, batches)
        shares = torch.rand(self.count, generator=generator)
        codes = density.codes(noise.double().numpy(), shares.numpy(), self.temperature)
        return torch.from_numpy(codes).float()
