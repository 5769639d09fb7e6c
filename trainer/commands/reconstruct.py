"""`python -m trainer reconstruct`"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
import tyro

from imaging.alignment import aligned
from trainer.data.images import load_image_folder
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.evaluation.gallery import comparison_rows, render
from trainer.evaluation.mesh_file import FORMATS, mesh_file
from trainer.evaluation.sheet import write_sheet
from trainer.evaluation.subject import answer, check_refinement, from_checkpoint
from trainer.evaluation.turntable import FRAMES, turntable
from trainer.training.checkpoint import load_checkpoint

MOST_VIEWS = 64


@dataclass(frozen=True)
class ReconstructCommand:
    """Reconstruct one object from one or more pictures of it: a mesh, and a sheet that compares it with the pictures.

    The mesh stands in the model's own frame. The shape is what all pictures say, of which those that are
    surer of it count more; of a model that was trained with --optimiser.views-per-instance, as that pools them.
    """

    checkpoint: Path
    """Run directory or checkpoint."""
    images: Path
    """Folder of pictures, all of the same object, 1 to 64."""
    output: Path = Path("object.ply")
    """Mesh to write: .ply, .obj, .stl or .glb. The sheet stands beside it, as .png."""
    refine: int = 3
    """Iterations in which shape, pose and light then follow the pictures, 0 to 100; 0 takes the encoder's word."""
    turntable: bool = False
    """Also write an animation in which the shape turns, beside the mesh, as .webp."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required, required)

    def run(self) -> None:
        kind = self.output.suffix.removeprefix(".").lower()
        if kind not in FORMATS:
            raise ConfigError(f"Expected --output to end in .{', .'.join(FORMATS)}, found {self.output}.")
        check_refinement(self.refine)
        checkpoint = load_checkpoint(self.checkpoint)
        model, scene = checkpoint.model, checkpoint.scene
        pictures = load_image_folder(self.images, scene.width, scene.height, scene)
        if len(pictures) > MOST_VIEWS:
            raise ConfigError(
                f"Expected 1 to {MOST_VIEWS} pictures of one object in {self.images}, found {len(pictures)}. Name a "
                "folder of fewer."
            )
        images = pictures.batch(np.arange(len(pictures)))
        with torch.no_grad():
            subject = from_checkpoint(checkpoint)
            found = answer(subject, images, len(images))
            if checkpoint.reframed and not pictures.framed:
                # The rule has set the objects elsewhere, and larger or smaller, than the model sees them.
                drawn = render(model.faces, scene, found.vertices, found.azimuths, found.light_azimuths)
                pairs = zip(images.numpy(), drawn.numpy(), strict=True)
                images = torch.from_numpy(np.stack([aligned(picture, drawing) for picture, drawing in pairs]))
            if self.refine:
                found = answer(replace(subject, refinement=self.refine), images, len(images))
            drawn = render(model.faces, scene, found.vertices, found.azimuths, found.light_azimuths)
            titles, rows = comparison_rows(model.faces, scene, images, drawn, found.vertices)
            moments = found.vertices[:1].expand(FRAMES, -1, -1, -1)
            turning = turntable(model.faces, scene, moments, found.azimuths[0].item()) if self.turntable else None
        write_bytes(self.output, mesh_file(found.vertices[0], model.faces, model.decoder.parts, kind))
        write_sheet(self.output.with_suffix(".png"), rows, titles)
        if turning is not None:
            write_bytes(self.output.with_suffix(".webp"), turning)
        print(f"{checkpoint.category} from {len(images)} pictures: {self.output}, {self.output.with_suffix('.png')}")
