"""`python -m trainer evaluate`"""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self, cast

from trainer.errors import ConfigError
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import Pictures, from_folder, from_meshes, grouped, validation_from
from trainer.evaluation.record import judge_and_record
from trainer.evaluation.report import as_text
from trainer.evaluation.subject import Subject, check_refinement, from_checkpoint
from trainer.training.checkpoint import load_checkpoint


@dataclass(frozen=True)
class EvaluateCommand:
    """Judge a model on objects that it never saw: IoU at 32³, azimuth error, accuracy within 30°, and more.

    The one rotation between the model's canonical frame and the class's is fitted on the validation pictures only.
    Writes metrics.json, report.md and contact sheets of the best, middle and worst objects.
    """

    checkpoint: Path | None = None
    """Run directory or checkpoint."""
    bundle: Path | None = None
    """Instead of --checkpoint: directory of a bundle, which is judged as it is served."""
    images: Path | None = None
    """Test pictures: a folder that `trainer render` wrote, with another seed than training and validation."""
    meshes: Path | None = None
    """Instead of --images: folder of mesh files (front = +z, up = +y), rendered here."""
    validation: Path | None = None
    """Folder that `trainer render` wrote: the canonical frame is aligned on it, and the baselines know its shapes. Both
    are left out without it."""
    views: int = 24
    """Pictures of each mesh at evenly spaced azimuths, 1 to 360 (paper: 24); only with --meshes."""
    views_per_instance: int = 1
    """Pictures of an object that the model sees at once, 1 to 64 (paper: 1 or 3, section 5.5): its shape is found from
    all of them. Of each object there are a multiple of so many."""
    refine: int = 0
    """Iterations of test-time refinement of each answer, 0 to 100; 0 takes the encoder's word."""
    output: Path | None = None
    """Folder to write to; by default evaluation/ in the run directory, or right here for a bundle."""
    json: bool = False
    """Print one JSON object on standard output, and nothing else."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        return cls()

    def run(self) -> None:
        self._check()
        subject, beside = self._subject()
        subject = replace(subject, refinement=self.refine)
        pictures = grouped(self._pictures(subject), self.views_per_instance)
        validation = None if self.validation is None else validation_from(self.validation, subject.scene)
        output = beside / "evaluation" if self.output is None else self.output
        judgement, figures = judge_and_record(subject, pictures, validation, output)
        if self.json:
            print(json.dumps(figures, allow_nan=False))
            return
        print(as_text(judgement.report, subject.category))
        print(f"{'written':30}{output}: metrics.json, report.md, best.png, median.png, worst.png, sheet.png")

    def _check(self) -> None:
        if not 1 <= self.views <= 360:
            raise ConfigError(f"Expected --views from 1 to 360, found {self.views}.")
        if not 1 <= self.views_per_instance <= 64:
            raise ConfigError(f"Expected --views-per-instance from 1 to 64, found {self.views_per_instance}.")
        check_refinement(self.refine)
        if self.meshes is not None and self.views % self.views_per_instance:
            raise ConfigError(
                f"Expected --views to be a multiple of --views-per-instance {self.views_per_instance}, found "
                f"{self.views}."
            )
        if (self.checkpoint is None) == (self.bundle is None):
            raise ConfigError("Expected either --checkpoint or --bundle, found both or neither.")
        if (self.images is None) == (self.meshes is None):
            raise ConfigError("Expected either --images or --meshes, found both or neither.")

    def _subject(self) -> tuple[Subject, Path]:
        """(the model, the directory beside whose files the figures belong)"""
        if self.bundle is not None:
            return from_bundle(self.bundle), Path()
        path = cast(Path, self.checkpoint)
        return from_checkpoint(load_checkpoint(path)), path if path.is_dir() else path.parent

    def _pictures(self, subject: Subject) -> Pictures:
        if self.meshes is not None:
            return from_meshes(self.meshes, subject.scene, self.views)
        return from_folder(cast(Path, self.images), subject.scene)
