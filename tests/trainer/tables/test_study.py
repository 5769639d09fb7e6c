"""What a study takes for its own, and for done."""

import json
from dataclasses import replace
from pathlib import Path

from trainer.config import SceneConfig
from trainer.data.render import render_folder
from trainer.presets import load_preset
from trainer.tables.cells import Cell, Task
from trainer.tables.pictures import missing_folders
from trainer.tables.setting import Setting
from trainer.tables.study import TRAINED_FILE, Study

CELL = Cell("car", Setting(), 0)


def study(root: Path) -> Study:
    return Study(root, "sharp", load_preset("sharp"), 2, 2, 1, seconds=None)


def test_procedural_objects_and_shapenet_s_are_never_mixed_up(tmp_path: Path) -> None:
    procedural = study(tmp_path)
    shapenet = replace(procedural, shapenet=tmp_path / "ShapeNetCore")
    assert procedural.identity(CELL) != shapenet.identity(CELL)
    for one, other in (
        (procedural.training_pictures(CELL), shapenet.training_pictures(CELL)),
        (procedural.validation_pictures(CELL), shapenet.validation_pictures(CELL)),
        (procedural.test_pictures(CELL), shapenet.test_pictures(CELL)),
    ):
        assert one.path != other.path


def test_no_two_cells_have_a_start_in_common_nor_a_directory_with_a_single_training(tmp_path: Path) -> None:
    one = study(tmp_path)
    three = replace(one, starts=3)
    assert [three.config(CELL._replace(seed=seed)).seed for seed in (0, 1, 2)] == [0, 3, 6]
    assert three.run_directory(CELL) != one.run_directory(CELL)
    assert three.training_pictures(CELL) == one.training_pictures(CELL)


def test_pictures_of_other_settings_are_not_taken_for_complete(tmp_path: Path) -> None:
    own = study(tmp_path)
    folder = own.test_pictures(CELL)
    assert folder in missing_folders(own, [Task(CELL, (1,))])
    scene = SceneConfig(folder.scene.width, folder.scene.height)
    render_folder(folder.path, replace(folder.settings, seed=7), scene, 2, 1, 1, show_progress=False)
    assert folder in missing_folders(own, [Task(CELL, (1,))])


def test_a_training_is_done_when_it_is_as_long_as_asked_for_and_judged_since(tmp_path: Path) -> None:
    own = study(tmp_path)
    assert not own.is_trained(CELL)
    directory, evaluation = own.run_directory(CELL), own.evaluation(CELL, 1)
    evaluation.mkdir(parents=True)
    steps = own.recipe.optimiser.steps
    for trained, judged, done in ((steps - 1, steps - 1, False), (steps, steps - 1, False), (steps, steps, True)):
        (directory / TRAINED_FILE).write_text(json.dumps({"steps": trained, "seconds": 60.0}))
        (evaluation / "metrics.json").write_text(json.dumps({"step": judged, "iou": 0.5}))
        assert own.is_done(Task(CELL, (1,))) == done
    # Of a training that is given time, the seconds count.
    assert replace(own, seconds=60.5).is_trained(CELL)
    assert not replace(own, seconds=70.0).is_trained(CELL)
