"""`python -m trainer render`"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Self

import tyro

from trainer.config import CameraConfig, SceneConfig
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.scene import check_scene
from trainer.data.shapes.catalogue import check_category
from trainer.errors import ConfigError

# A sample takes eight bytes while its picture is drawn.
MOST_SAMPLES = 2**27


@dataclass(frozen=True)
class RenderCommand:
    """Render pictures of objects at random azimuths, with the truth beside them in metadata.csv.

    Writes PNG pictures, metadata.csv (file name, instance, azimuth, light azimuth), scene.json and render.json.
    Finished pictures of an earlier call with the same options are kept.
    """

    output: Path
    """Folder to write."""
    category: str = ""
    """Procedural class: car or chair."""
    meshes: Path | None = None
    """Instead of a class: folder of OBJ, PLY, STL, OFF, GLB or glTF files, front = +z, up = +y."""
    instances: int = 0
    """Objects; 0 means 1000 of a procedural class, or every file of a mesh folder."""
    views: int = 1
    """Pictures of each object, 1 to 1000."""
    seed: int = 0
    """Seed of shapes and poses; another seed gives other objects."""
    width: int = 128
    """Width of a picture, pixels."""
    height: int = 96
    """Height of a picture, pixels."""
    camera: CameraConfig = field(default_factory=CameraConfig)
    """Where the camera stands."""
    supersampling: int = 4
    """Samples along each side of a pixel, 1 to 32."""
    workers: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Processes; 0 means one per core."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required)

    def run(self) -> None:
        if bool(self.category) == (self.meshes is not None):
            raise ConfigError("Expected either --category CLASS or --meshes DIRECTORY, found both or neither.")
        for option, value, low, high in (
            ("instances", self.instances, 0, 1_000_000),
            ("views", self.views, 1, 1000),
            ("supersampling", self.supersampling, 1, 32),
            ("workers", self.workers, 0, 1024),
        ):
            if not low <= value <= high:
                raise ConfigError(f"Expected --{option} from {low} to {high}, found {value}.")
        if self.category:
            check_category(self.category)
        scene = SceneConfig(width=self.width, height=self.height, camera=self.camera)
        check_scene(scene)
        samples = self.width * self.height * self.supersampling**2
        if samples > MOST_SAMPLES:
            raise ConfigError(
                f"Expected at most {MOST_SAMPLES:,} samples a picture (width · height · supersampling²), found "
                f"{samples:,}. Make the pictures smaller, or lower --supersampling."
            )
        # An absolute path is never taken for a class, whatever the folder is called.
        source = self.category if self.meshes is None else str(self.meshes.resolve())
        settings = RenderSettings(source=source, seed=self.seed, supersampling=self.supersampling)
        instances = self.instances or (1000 if self.category else None)
        report = render_folder(self.output, settings, scene, instances, self.views, self.workers or None)
        print(
            f"{report.written} pictures written, {report.kept} kept, {len(report.skipped)} objects skipped in "
            f"{report.seconds:.1f} s: {self.output}"
        )
