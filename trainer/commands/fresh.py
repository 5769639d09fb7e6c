"""Options of a training whose pictures are drawn while it runs."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Self

import tyro

from imaging.srgb import encode
from trainer.commands.objects import check_stretch, object_source
from trainer.config import CameraConfig, SceneConfig, TrainConfig
from trainer.data.fresh import FreshViews, fresh_views
from trainer.data.lens import largest_zoom, zoomed
from trainer.data.plan import RenderSettings
from trainer.data.rig import load_rig
from trainer.data.scene import check_scene
from trainer.data.shapenet import Split
from trainer.errors import ConfigError
from trainer.tables.setting import Setting

_LOOKED_AT = 128
"""Views that tell how far one can zoom in."""

Folder = Annotated[str, tyro.conf.arg(metavar="DIR")]


@dataclass(frozen=True)
class FreshOptions:
    """What is drawn, and how. Texts and numbers only, so that a checkpoint can remember it."""

    meshes: Folder = ""
    """Instead of --images: folder of mesh files (front = +z, up = +y), of which each step draws views of its own."""
    shapenet: Folder = ""
    """Instead of --images: folder of ShapeNetCore (front = -z), of which each step draws views of --class."""
    split: Split = "train"
    """Part of ShapeNet's class, as in `trainer render`."""
    instances: int = 0
    """Objects to draw; 0 means 1000 of a procedural class, or everything that is in a folder."""
    shape_seed: int = 0
    """Seed of the procedural objects, as --seed of `trainer render`; test on those of another."""
    camera: CameraConfig = field(default_factory=CameraConfig)
    """Where the camera stands, for views that are drawn and for pictures of your own."""
    rig: str = "colour"
    """Lights of views that are drawn and of pictures of your own: colour, white, or a TOML file with `ambient` and
    [[lights]]."""
    stretch: float = 0.0
    """Stretch half of the objects along each of their axes, as --stretch of `trainer render`."""
    rotate_lights: bool = False
    """Turn all lights together about the vertical axis, by another angle in each view."""
    supersampling: int = 4
    """Samples along each side of a pixel of views that are drawn, 1 to 32."""
    mesh_memory_mib: int = 1024
    """Memory for meshes, MiB; those beyond it are read again when their turn comes."""

    def absolute(self) -> Self:
        """The same options from wherever the training is resumed."""
        return replace(
            self,
            meshes=_absolute(self.meshes),
            shapenet=_absolute(self.shapenet),
            rig=_absolute(self.rig) if self.rig.endswith(".toml") else self.rig,
        )


def _absolute(path: str) -> str:
    return str(Path(path).resolve()) if path else ""


def fresh_options(setting: Setting) -> FreshOptions:
    """The options with a setting's lights."""
    return FreshOptions(rig=setting.rig, rotate_lights=setting.light == "varying")


def drawn_scene(options: FreshOptions, width: int, height: int) -> SceneConfig:
    """Camera and lights of the options. Raises ConfigError for what cannot be drawn."""
    rig = load_rig(options.rig)
    scene = SceneConfig(width, height, options.camera, rig.lights, rig.ambient)
    check_scene(scene)
    return scene


def open_fresh(options: FreshOptions, category: str, config: TrainConfig) -> FreshViews:
    """The objects that the options name, ready to be drawn at the training's size.

    Raises ConfigError for options that mean nothing, DataError where there are no such objects.
    """
    for option, value, low, high in (
        ("instances", options.instances, 0, 1_000_000),
        ("shape-seed", options.shape_seed, 0, 2**31 - 1),
        ("supersampling", options.supersampling, 1, 32),
        ("mesh-memory-mib", options.mesh_memory_mib, 1, 2**20),
    ):
        if not low <= value <= high:
            raise ConfigError(f"Expected --{option} from {low} to {high}, found {value}.")
    check_stretch(options.stretch)
    if options.rotate_lights and config.model.light == "fixed" and config.loss.kind == "shading":
        raise ConfigError(
            "Expected --model.light varying with --rotate-lights, found fixed: the model would take the lights to "
            "stand still. Train with --model.light varying, or without --rotate-lights."
        )
    meshes = Path(options.meshes) if options.meshes else None
    shapenet = Path(options.shapenet) if options.shapenet else None
    source = object_source(category, meshes, shapenet, options.split if shapenet else "all")
    scene = drawn_scene(options, config.width, config.height)
    settings = RenderSettings(
        source=source.source,
        seed=options.shape_seed,
        rotate_lights=options.rotate_lights,
        supersampling=options.supersampling,
        synset=source.synset,
        split=source.split,
        stretch=options.stretch,
    )
    procedural = meshes is None and shapenet is None
    instances = options.instances or (1000 if procedural else None)
    views = fresh_views(
        settings,
        zoomed(scene, config.zoom or 1.0),
        instances,
        config.validation_share,
        config.seed,
        options.mesh_memory_mib * 2**20,
    )
    if config.zoom:
        return views
    pictures = views.sample(_LOOKED_AT, config.seed)
    return replace(views, scene=zoomed(scene, largest_zoom(encode(pictures.numpy()))))
