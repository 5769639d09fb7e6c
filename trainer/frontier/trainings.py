"""The trainings behind the points, as a study of `trainer.tables`: each is done once, whichever points share it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from trainer.data.images import load_image_folder
from trainer.frontier.plan import Plan, Point
from trainer.presets import load_preset
from trainer.tables.cells import Cell, Task
from trainer.tables.study import Study
from trainer.training.intervals import Intervals
from trainer.training.loop import train


class Trained(NamedTuple):
    """A point for one class: the trainings that it is measured on, one for each seed."""

    point: Point
    category: str
    cells: tuple[Cell, ...]


def study_of(plan: Plan, root: Path) -> Study:
    """The study in `root`, which several plans may share as long as they are of one scale."""
    scale = plan.scale
    return Study(
        root=root,
        recipe_name=Path(scale.preset).stem,
        recipe=load_preset(scale.preset),
        instances=scale.instances,
        test_instances=scale.test_instances,
        test_views=scale.test_views,
        seconds=None,
        picture_size=(scale.width, scale.height),
    )


def trained_points(plan: Plan) -> Iterator[Trained]:
    """All points, in the plan's order."""
    for point in plan.points:
        for category in point.choice.classes:
            yield Trained(point, category, tuple(Cell(category, point.variant, seed) for seed in point.choice.seeds))


def tasks_of(plan: Plan) -> list[Task]:
    """Each training once, in the order in which points first ask for it."""
    cells = dict.fromkeys(cell for trained in trained_points(plan) for cell in trained.cells)
    return [Task(cell, (1,)) for cell in cells]


def compile_kernels(study: Study, task: Task) -> None:
    """A step of a training that is thrown away: on a new machine, the first would be charged with compiling."""
    config = study.config(task.cell)
    folder = study.training_pictures(task.cell).path
    images = load_image_folder(folder, config.width, config.height, zoom=config.zoom)
    one_step = replace(config, optimiser=replace(config.optimiser, steps=1))
    with TemporaryDirectory() as directory:
        train(one_step, images, task.cell.category, Path(directory), Intervals(), False, lambda step, figures: None, {})
