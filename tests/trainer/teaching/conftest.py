"""Eight cars, and a model that nobody has trained, to teach another one."""

from pathlib import Path

import pytest

from tests.trainer.new_model import HEIGHT, WIDTH, new_model, save_model
from trainer.commands.render import RenderCommand
from trainer.data.images import ImageSet, load_image_folder


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("told") / "pictures"
    RenderCommand(path, category="car", instances=8, width=WIDTH, height=HEIGHT, workers=1).run()
    return path


@pytest.fixture(scope="session")
def images(folder: Path) -> ImageSet:
    return load_image_folder(folder, WIDTH, HEIGHT)


@pytest.fixture(scope="session")
def teacher(folder: Path) -> Path:
    save_model(folder.parent / "teacher.safetensors", new_model())
    return folder.parent / "teacher.safetensors"
