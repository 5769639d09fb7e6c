"""`python -m trainer evaluate`"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
import tyro

from trainer.data.images import load_image_folder
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.evaluation.gallery import reconstruction_rows
from trainer.evaluation.protocol import as_json, fit_offset, from_folder, from_meshes, judge, mean_of
from trainer.evaluation.sheet import write_sheet
from trainer.training.checkpoint import load_checkpoint


@dataclass(frozen=True)
class EvaluateCommand:
    """Judge a model on objects that it never saw: IoU at 32³, azimuth error, accuracy within 30°.

    The one rotation between the model's canonical frame and the class's is fitted on the validation pictures only.
    Writes metrics.json and a contact sheet.
    """

    checkpoint: Path
    """Run directory or checkpoint."""
    validation: Path
    """Folder that `trainer render` wrote: the canonical frame is aligned on it, and the mean-shape baseline is its."""
    images: Path | None = None
    """Test pictures: a folder that `trainer render` wrote, with another seed than training and validation."""
    meshes: Path | None = None
    """Instead of --images: folder of mesh files (front = +z, up = +y), rendered here."""
    views: int = 24
    """Pictures of each mesh at evenly spaced azimuths, 1 to 360 (paper: 24); only with --meshes."""
    output: Path | None = None
    """Folder for metrics.json and sheet.png; by default evaluation/ in the run directory."""
    json: bool = False
    """Print one JSON object on standard output, and nothing else."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required, required)

    def run(self) -> None:
        if not 1 <= self.views <= 360:
            raise ConfigError(f"Expected --views from 1 to 360, found {self.views}.")
        if (self.images is None) == (self.meshes is None):
            raise ConfigError("Expected either --images or --meshes, found both or neither.")
        checkpoint = load_checkpoint(self.checkpoint)
        scene = checkpoint.scene
        validation = load_image_folder(self.validation, scene.width, scene.height)
        offset = fit_offset(checkpoint, validation)
        if self.meshes is not None:
            tested = from_meshes(self.meshes, scene, self.views)
        elif self.images is not None:
            tested = from_folder(self.images, scene)
        report = judge(checkpoint, tested, offset, mean_of(self.validation, validation))
        figures = as_json(report) | {
            "category": checkpoint.category,
            "step": checkpoint.step,
            "seconds": checkpoint.run["seconds"],
        }
        directory = self.checkpoint if self.checkpoint.is_dir() else self.checkpoint.parent
        output = directory / "evaluation" if self.output is None else self.output
        write_bytes(output / "metrics.json", (json.dumps(figures, indent=2) + "\n").encode())
        shown = np.linspace(0, len(tested.images) - 1, min(8, len(tested.images))).astype(int)
        with torch.no_grad():
            titles, rows = reconstruction_rows(checkpoint.model, scene, tested.images[shown], offset)
        write_sheet(output / "sheet.png", rows, titles)
        if self.json:
            print(json.dumps(figures))
            return
        overlap, baseline = report.iou, report.mean_shape_iou
        known = "not known" if baseline is None else f"{baseline:.3f}"
        accuracy, flipped = report.azimuth_accuracy.value, report.flipped
        print(f"{report.objects} objects, {report.pictures} pictures of {checkpoint.category}")
        print(f"IoU               {overlap.value:.3f}  [{overlap.low:.3f}, {overlap.high:.3f}]   (mean shape: {known})")
        print(f"azimuth error     {report.azimuth_error_degrees.value:.1f}° (median)")
        print(f"within 30°        {accuracy:.2f}   (wrong by more than 150°: {flipped:.2f})")
        print(f"canonical frame   turned by {report.azimuth_offset_degrees:.0f}°")
        print(f"written           {output / 'metrics.json'}, {output / 'sheet.png'}")
