"""The pictures that cells need, rendered where they are not there yet."""

from collections.abc import Sequence

from trainer.data.metadata import read_metadata
from trainer.data.plan import read_settings
from trainer.data.render import render_folder
from trainer.tables.cells import Task
from trainer.tables.study import Folder, Study


def missing_folders(study: Study, tasks: Sequence[Task]) -> list[Folder]:
    """The folders that these tasks read and that are not complete, each once."""
    folders: dict[Folder, None] = {}
    for task in tasks:
        if not study.is_trained(task.cell):
            folders[study.training_pictures(task.cell)] = None
        folders[study.validation_pictures(task.cell)] = None
        folders[study.test_pictures(task.cell)] = None
    return [folder for folder in folders if not _is_complete(folder)]


def _is_complete(folder: Folder) -> bool:
    """All pictures are planned before the first is drawn, so what is planned and there is all that there will be."""
    if not folder.path.is_dir() or read_settings(folder.path) != folder.settings:
        return False
    planned = read_metadata(folder.path)
    return planned is not None and all((folder.path / name).exists() for name in planned)


def render_missing(folder: Folder, workers: int) -> None:
    """Raises as `render_folder` does."""
    render_folder(folder.path, folder.settings, folder.scene, folder.instances, folder.views, workers)
