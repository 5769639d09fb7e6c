"""Three chairs in files, pictures of them, and a predictor that knows the truth."""

import math
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import torch
import trimesh
from torch import Tensor

from trainer.config import SceneConfig, TrainConfig
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh
from trainer.evaluation.pictures import Pictures, Validation, from_meshes, linear_batches, validation_from
from trainer.evaluation.subject import Subject, from_checkpoint
from trainer.geometry.conventions import rotation_about_y
from trainer.model.posterior import Posterior, bin_centres
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint

SCENE = SceneConfig(width=40, height=30)
BINS = 12
SURENESS = 1e4


class Oracle:
    """Knows pictures: answers each with its true shape and azimuth, in a frame turned by `frame` radians, and is sure.

    A shape turned by `frame` in its own frame looks as before at an azimuth that is smaller by as much.
    """

    def __init__(
        self, codes: np.ndarray, azimuths: np.ndarray, shapes: list[Mesh], objects: np.ndarray, frame: float
    ) -> None:
        self.faces = torch.tensor(shapes[0].faces)
        self.images = torch.cat(list(linear_batches(codes)))
        self.azimuths = torch.tensor(azimuths - frame, dtype=torch.float32)
        vertices = torch.tensor(np.stack([shape.vertices for shape in shapes]), dtype=torch.float32)
        self.vertices = (vertices @ rotation_about_y(torch.tensor(frame)).T)[torch.tensor(objects)]

    def encode(self, images: Tensor) -> Posterior:
        (number,) = torch.nonzero((images[:, None] == self.images).flatten(2).all(2), as_tuple=True)[1:]
        assert len(number) == len(images)
        azimuth = self.azimuths[number]
        away = torch.remainder(azimuth[:, None] - bin_centres(BINS, azimuth) + math.pi, 2 * math.pi) - math.pi
        fine = away.gather(1, away.abs().argmin(1, keepdim=True)).squeeze(1)
        return Posterior(
            number[:, None].float(), torch.ones(len(number), 1), -SURENESS * away.abs(), fine, torch.ones(len(number))
        )

    def decode(self, shape_code: Tensor) -> Tensor:
        return self.vertices[shape_code.squeeze(1).long()]


def subject_of(oracle: Oracle) -> Subject:
    return from_checkpoint(Checkpoint(TrainConfig(), SCENE, "chair", 1, cast(Model, oracle), {}, {"seconds": 1.0}))


def knowing(shapes: list[Mesh], frame: float, *sets: Pictures | Validation) -> Oracle:
    """A perfect predictor on all the pictures of these sets."""
    codes, azimuths, objects = (
        np.concatenate([getattr(pictures, name) for pictures in sets]) for name in ("codes", "azimuths", "objects")
    )
    return Oracle(codes, azimuths, shapes, objects, frame)


def stretched(seed: int) -> Mesh:
    """One shape in several proportions, so that all share their faces; none has a symmetry about +Y."""
    mesh = make_shape("chair", 3)
    x, y, z = mesh.vertices.T
    leaning = np.stack((x + 0.15 * z, y, z), 1) * np.random.default_rng(seed).uniform(0.75, 1, 3)
    return Mesh(leaning, mesh.faces)


@pytest.fixture(scope="session")
def mesh_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("meshes") / "chairs"
    folder.mkdir()
    for seed in range(3):
        trimesh.Trimesh(*stretched(seed), process=False).export(folder / f"{seed}.obj", digits=17)
    return folder


@pytest.fixture(scope="session")
def shapes(mesh_folder: Path) -> list[Mesh]:
    """As the judge reads them: normalised."""
    return [load_mesh(path) for path in mesh_files(mesh_folder)]


@pytest.fixture(scope="session")
def tested(mesh_folder: Path) -> Pictures:
    """Eight pictures of each mesh."""
    return from_meshes(mesh_folder, SCENE, 8)


@pytest.fixture(scope="session")
def validation_folder(tmp_path_factory: pytest.TempPathFactory, mesh_folder: Path) -> Path:
    folder = tmp_path_factory.mktemp("validation") / "pictures"
    render_folder(folder, RenderSettings(str(mesh_folder), seed=1), SCENE, None, 6, 1, show_progress=False)
    return folder


@pytest.fixture(scope="session")
def validation(validation_folder: Path) -> Validation:
    return validation_from(validation_folder, SCENE)
