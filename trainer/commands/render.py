"""`python -m trainer render`"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tyro

from trainer.commands.objects import check_stretch, object_source
from trainer.config import CameraConfig, SceneConfig
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.rig import load_rig
from trainer.data.scene import check_scene
from trainer.data.shapenet import Split
from trainer.errors import ConfigError

# A sample takes eight bytes while its picture is drawn.
MOST_SAMPLES = 2**27


@dataclass(frozen=True)
class RenderCommand:
    """Render pictures of objects at random azimuths, with the truth beside them in metadata.csv.

    Writes PNG pictures, metadata.csv (file name, instance, azimuth, light azimuth), scene.json and render.json; with
    --shards, tar files with both.
    Finished pictures of an earlier call with the same options are kept.
    """

    output: Path
    """Folder to write."""
    category: Annotated[str, tyro.conf.arg(name="class")] = ""
    """Procedural class, of which `trainer shapes` shows what it holds; or, with --shapenet, class of ShapeNet."""
    meshes: Path | None = None
    """Instead of a class: folder of OBJ, PLY, STL, OFF, GLB or glTF files, front = +z, up = +y."""
    shapenet: Path | None = None
    """Folder of ShapeNetCore, version 1 or 2 as unpacked, front = -z; takes --class of it."""
    split: Split = "all"
    """Part of ShapeNet's class: as all.csv says where it is there, else 70:10:20 % by a hash of the model's name."""
    instances: int = 0
    """Objects; 0 means 1000 of a procedural class, or everything that is in a folder."""
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
    rig: str = "colour"
    """Lights: colour, white, or a TOML file with `ambient` and [[lights]]."""
    stretch: float = 0.0
    """Stretch half of the objects, drawn by chance, along each of their axes, by factors whose logarithms have this
    standard deviation, 0 to 0.5: other proportions than the source's own. 0 does not; 0.15 changes ratios of sides by
    some 20 %."""
    rotate_lights: bool = False
    """Turn all lights together about the vertical axis, by another angle in each picture."""
    renderer: Literal["chiaro", "pyrender"] = "chiaro"
    """Who draws: chiaro, or OpenGL as an outside opinion."""
    supersampling: int = 4
    """Samples along each side of a pixel, 1 to 32."""
    shards: int = 0
    """Write tar files of so many pictures each (WebDataset) instead of a file for each picture; 0 does not."""
    workers: Annotated[int, tyro.conf.arg(metavar="N")] = 0
    """Processes; 0 means one per core."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required)

    def run(self) -> None:
        if self.shapenet is None and bool(self.category) == (self.meshes is not None):
            raise ConfigError("Expected either --class CLASS or --meshes DIRECTORY, found both or neither.")
        for option, value, low, high in (
            ("instances", self.instances, 0, 1_000_000),
            ("views", self.views, 1, 1000),
            ("supersampling", self.supersampling, 1, 32),
            ("workers", self.workers, 0, 1024),
            ("shards", self.shards, 0, 1_000_000),
        ):
            if not low <= value <= high:
                raise ConfigError(f"Expected --{option} from {low} to {high}, found {value}.")
        check_stretch(self.stretch)
        source = object_source(self.category, self.meshes, self.shapenet, self.split)
        rig = load_rig(self.rig)
        scene = SceneConfig(self.width, self.height, self.camera, rig.lights, rig.ambient)
        check_scene(scene)
        samples = self.width * self.height * self.supersampling**2
        if samples > MOST_SAMPLES:
            raise ConfigError(
                f"Expected at most {MOST_SAMPLES:,} samples a picture (width · height · supersampling²), found "
                f"{samples:,}. Make the pictures smaller, or lower --supersampling."
            )
        settings = RenderSettings(
            source=source.source,
            seed=self.seed,
            rotate_lights=self.rotate_lights,
            supersampling=self.supersampling,
            synset=source.synset,
            split=source.split,
            renderer=self.renderer,
            shard_pictures=self.shards,
            stretch=self.stretch,
        )
        instances = self.instances or (1000 if self.meshes is None and self.shapenet is None else None)
        report = render_folder(self.output, settings, scene, instances, self.views, self.workers or None)
        print(
            f"{report.written} pictures written, {report.kept} kept, {len(report.skipped)} objects skipped in "
            f"{report.seconds:.1f} s: {self.output}"
        )
