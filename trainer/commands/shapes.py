"""`python -m trainer shapes`"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Self

import tyro

from trainer.config import SceneConfig
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.picture import draw
from trainer.data.plan import shape_seed
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh
from trainer.errors import ConfigError, DataError
from trainer.evaluation.sheet import write_sheet

_COLUMNS = 8


@dataclass(frozen=True)
class ShapesCommand:
    """Show objects of a procedural class, or of a folder of meshes, on one sheet."""

    category: Annotated[str, tyro.conf.arg(name="class")] = ""
    """Procedural class."""
    meshes: Path | None = None
    """Instead of a class: folder of mesh files, front = +z, up = +y."""
    sheet: Path = Path("shapes.png")
    """PNG to write."""
    count: int = 64
    """How many objects, 1 to 400."""
    seed: int = 0
    """Seed of the objects, as in `trainer render`."""
    azimuth_degrees: float = 35.0
    """How far each object is turned about +Y, degrees; at 0 it shows its front."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        return cls()

    def run(self) -> None:
        if bool(self.category) == (self.meshes is not None):
            raise ConfigError("Expected either --class CLASS or --meshes DIRECTORY, found both or neither.")
        if not 1 <= self.count <= 400:
            raise ConfigError(f"Expected --count from 1 to 400, found {self.count}.")
        if not math.isfinite(self.azimuth_degrees):
            raise ConfigError(f"Expected a number for --azimuth-degrees, found {self.azimuth_degrees}.")
        meshes = self._procedural() if self.meshes is None else _readable(self.meshes, self.count)
        scene, azimuth = SceneConfig(), math.radians(self.azimuth_degrees)
        pictures = [draw(mesh, azimuth, 0.0, scene)[0] for mesh in meshes]
        rows = [pictures[start : start + _COLUMNS] for start in range(0, len(pictures), _COLUMNS)]
        write_sheet(self.sheet, rows)
        print(f"{len(pictures)} objects of {self.category or self.meshes}: {self.sheet}")

    def _procedural(self) -> list[Mesh]:
        return [make_shape(self.category, shape_seed(self.seed, index)) for index in range(self.count)]


def _readable(folder: Path, count: int) -> list[Mesh]:
    """The meshes of a folder, without those that cannot be read, which are named."""
    meshes: list[Mesh] = []
    for path in mesh_files(folder)[:count]:
        try:
            meshes.append(load_mesh(path))
        except DataError as error:
            print(f"skipped: {error}")
    if not meshes:
        raise DataError(f"no mesh in {folder} can be read; the reasons stand above")
    return meshes
