"""`python -m trainer interpolate`"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

import torch
import tyro

from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.evaluation.gallery import as_pictures, render
from trainer.evaluation.interpolation import shape_codes_between, there_and_back
from trainer.evaluation.mesh_file import mesh_file
from trainer.evaluation.picture_file import read_picture
from trainer.evaluation.sheet import write_sheet
from trainer.evaluation.turntable import FRAMES, turntable
from trainer.model.posterior import most_probable_azimuth, most_probable_light
from trainer.training.checkpoint import load_checkpoint

MOST_STEPS = 64


@dataclass(frozen=True)
class InterpolateCommand:
    """Change one object into another: shapes on the straight way between the shape codes of two pictures.

    Writes strip.png (the first picture, the shapes, the second picture), turntable.webp (the object turns while it
    changes, there and back), and the shapes as 01.glb, 02.glb and so on, in the model's own frame.
    """

    first: Annotated[Path, tyro.conf.Positional]
    """Picture of the object to begin with: PNG, JPEG or WebP."""
    last: Annotated[Path, tyro.conf.Positional]
    """Picture of the object to end with."""
    checkpoint: Path
    """Run directory or checkpoint."""
    output: Path = Path("interpolation")
    """Folder to write to."""
    steps: int = 5
    """How many shapes, 2 to 64; the first and the last are the reconstructions of the two pictures."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required, required, required)

    def run(self) -> None:
        if not 2 <= self.steps <= MOST_STEPS:
            raise ConfigError(f"Expected --steps from 2 to {MOST_STEPS}, found {self.steps}.")
        checkpoint = load_checkpoint(self.checkpoint)
        model, scene = checkpoint.model, checkpoint.scene
        images = torch.stack([read_picture(path, scene) for path in (self.first, self.last)])
        shares = torch.linspace(0, 1, self.steps)
        with torch.no_grad():
            posterior = model.encode(images)
            first, last = posterior.shape_mean
            shapes = model.decode(shape_codes_between(first, last, shares))
            # All from the side and in the light of the first picture.
            azimuth, lights = most_probable_azimuth(posterior)[0], most_probable_light(posterior)
            light = None if lights is None else lights[0].expand(self.steps)
            drawn = render(model.faces, scene, shapes, azimuth.expand(self.steps), light)
            # A turn on the way there, and one on the way back.
            change = model.decode(shape_codes_between(first, last, there_and_back(2 * FRAMES)))
            animation = turntable(model.faces, scene, change[:, None], azimuth.item())
        left, right = as_pictures(images)
        titles = [self.first.name, *(f"{share:.2f}" for share in shares.tolist()), self.last.name]
        write_sheet(self.output / "strip.png", [[left, *as_pictures(drawn), right]], titles)
        write_bytes(self.output / "turntable.webp", animation)
        for number, vertices in enumerate(shapes, 1):
            write_bytes(self.output / f"{number:02d}.glb", mesh_file(vertices, model.faces, model.decoder.parts, "glb"))
        print(f"{self.steps} shapes of {checkpoint.category}: {self.output}")
