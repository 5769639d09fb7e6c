"""A study: what all cells of a table have in common, and where each keeps its files.

OUT/pictures/<size>/<source>/<class>/<light>/       train-<objects>x<views>, validation-…, test-…
OUT/runs/<recipe>[-best-of-<starts>]/<class>/<setting>/seed-<n>/
    cell.json          what was asked for; another cell is refused here
    trained.json       steps, seconds and core seconds (all starts' together), once the training is done
    evaluation-…/      what `trainer evaluate` writes
"""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from trainer.config import SceneConfig, TrainConfig
from trainer.data.plan import RenderSettings
from trainer.data.rig import load_rig
from trainer.data.shapenet import Split, synset_of
from trainer.mapping import to_mapping
from trainer.tables.cells import Cell, Task
from trainer.tables.setting import setting_name, training_config
from trainer.training.checkpoint import FILE_NAME

CELL_FILE, TRAINED_FILE = "cell.json", "trained.json"

# A training of so many minutes begins with so many steps, which tell how many more there will be.
_FIRST_STEPS = 50
# Nearer to the time that was given than this share of it, a training is done.
_TOLERANCE = 0.02
# Shapes and poses of each part; a procedural class has no other split.
_PARTS: dict[Split, int] = {"train": 0, "validation": 1, "test": 2}


class Folder(NamedTuple):
    """A folder of pictures, as `render_folder` makes it."""

    path: Path
    settings: RenderSettings
    scene: SceneConfig
    instances: int | None
    """None: all that there are."""
    views: int


@dataclass(frozen=True)
class Study:
    root: Path
    recipe_name: str
    recipe: TrainConfig
    instances: int | None
    """Objects to train on; None, of ShapeNet only: all."""
    test_instances: int
    """Objects to test on, and as many others to validate on."""
    test_views: int
    """Pictures of each of them."""
    seconds: float | None
    """How long a cell is trained; None: for the recipe's steps."""
    shapenet: Path | None = None
    """ShapeNetCore instead of procedural classes."""
    picture_size: tuple[int, int] | None = None
    """Width and height at which pictures are rendered, pixels; None: at the recipe's. Trainings reduce them."""
    starts: int = 1
    """Trainings that are begun for each cell, of which one goes on (`selection.starts`)."""

    @property
    def objects(self) -> str:
        """Whose objects are shown."""
        return "procedural" if self.shapenet is None else "ShapeNet"

    def config(self, cell: Cell) -> TrainConfig:
        """Of several starts, the first one's: no two cells have a start in common."""
        return replace(training_config(cell.setting, self.recipe), seed=self.starts * cell.seed)

    def run_directory(self, cell: Cell) -> Path:
        recipe = self.recipe_name if self.starts == 1 else f"{self.recipe_name}-best-of-{self.starts}"
        return self.root / "runs" / recipe / cell.category / setting_name(cell.setting) / f"seed-{cell.seed}"

    def evaluation(self, cell: Cell, test_views: int) -> Path:
        """Where the judge's files are."""
        together = f"-by-{test_views}" if test_views > 1 else ""
        return self.run_directory(cell) / f"evaluation-{self.test_instances}x{self.test_views}{together}"

    def training_pictures(self, cell: Cell) -> Folder:
        return self._folder(cell, "train", self.instances, cell.setting.views)

    def validation_pictures(self, cell: Cell) -> Folder:
        return self._folder(cell, "validation", self.test_instances, self.test_views)

    def test_pictures(self, cell: Cell) -> Folder:
        return self._folder(cell, "test", self.test_instances, self.test_views)

    def _folder(self, cell: Cell, part: Split, instances: int | None, views: int) -> Folder:
        width, height = self.picture_size or (self.recipe.width, self.recipe.height)
        varying = cell.setting.light == "varying"
        rig = load_rig(cell.setting.rig)
        parent = self.root / "pictures" / f"{width}x{height}" / self.objects / cell.category
        return Folder(
            parent / f"{cell.setting.light}-{cell.setting.rig}" / f"{part}-{instances or 'all'}x{views}",
            RenderSettings(
                source=cell.category if self.shapenet is None else str(self.shapenet.resolve()),
                seed=_PARTS[part],
                rotate_lights=varying,
                synset="" if self.shapenet is None else synset_of(cell.category),
                split="all" if self.shapenet is None else part,
            ),
            SceneConfig(width, height, lights=rig.lights, ambient=rig.ambient),
            instances,
            views,
        )

    def identity(self, cell: Cell) -> dict[str, Any]:
        """What a cell's directory is for: all but how long it is trained."""
        config = to_mapping(self.config(cell))
        del config["optimiser"]["steps"]
        return {"config": config, "objects": self.objects, "pictures": self.training_pictures(cell).path.name}

    def is_begun(self, cell: Cell) -> bool:
        """Whether there is a checkpoint to go on from."""
        return (self.run_directory(cell) / FILE_NAME).exists()

    def is_trained(self, cell: Cell) -> bool:
        """As long as is asked for, or longer."""
        if not (self.run_directory(cell) / TRAINED_FILE).exists():
            return False
        trained = self.trained(cell)
        steps: int = trained["steps"]
        return self.next_goal(cell, steps, trained["seconds"]) == steps

    def next_goal(self, cell: Cell, steps: int, seconds: float) -> int:
        """The step until which a cell is trained next, from what it has behind it; that step itself at the end.

        A cell that is given time makes a first few steps, and then as many as their pace leaves time for, until hardly
        any is left.
        """
        if self.seconds is None:
            return max(steps, self.config(cell).optimiser.steps)
        if steps == 0:
            return _FIRST_STEPS
        left = self.seconds - seconds
        if left < _TOLERANCE * self.seconds:
            return steps
        return steps + int(left * steps / seconds)

    def is_done(self, task: Task) -> bool:
        """Trained, and judged in all the ways that are asked for."""
        return self.is_trained(task.cell) and all(
            self.metrics(task.cell, views) is not None for views in task.test_views
        )

    def trained(self, cell: Cell) -> dict[str, Any]:
        """Steps, seconds and core seconds of a training that came to its end."""
        found: dict[str, Any] = json.loads((self.run_directory(cell) / TRAINED_FILE).read_text())
        return found

    def metrics(self, cell: Cell, test_views: int) -> dict[str, Any] | None:
        """What the judge found, or None where it has not been asked since the training's end."""
        path = self.evaluation(cell, test_views) / "metrics.json"
        if not path.exists():
            return None
        found: dict[str, Any] = json.loads(path.read_text())
        return found if found["step"] == self.trained(cell)["steps"] else None
