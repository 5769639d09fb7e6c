"""The judge: how well a model reconstructs shape and finds pose, on objects that it never saw.

Each object is shown in several pictures. A prediction is the decoded mean of z, and the most probable coarse azimuth
plus the mean of the fine one. The canonical frame of a model that was never told a pose is its own, so one rotation
about +Y is fitted per model on *validation* pictures, applied to all test predictions, and reported.
"""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray
from torch import Tensor

from trainer.config import SceneConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.normals import corner_normals
from trainer.data.picture import draw
from trainer.data.plan import is_procedural, load_instance, read_settings
from trainer.errors import DataError
from trainer.evaluation.fill import voxelise_solid
from trainer.evaluation.gallery import render
from trainer.evaluation.metrics import (
    Interval,
    accuracy,
    azimuth_error,
    bootstrap,
    fit_azimuth_offset,
    iou,
    mean_shape,
    median_error,
)
from trainer.evaluation.voxels import voxelise
from trainer.geometry.conventions import rotation_about_y
from trainer.model.posterior import most_probable_azimuth
from trainer.training.checkpoint import Checkpoint

# Pictures that go through the encoder at once.
BATCH = 256

Voxels = Bool[ndarray, "32 32 32"]


@dataclass(frozen=True)
class Pictures:
    """Test pictures with their truth."""

    images: Float[Tensor, "N 3 H W"]
    azimuths: Float[ndarray, "N"]
    """True azimuths, radians."""
    objects: ndarray
    """[N] which object each picture shows."""
    truth: list[Voxels]
    """The occupancy of each object, in the class's frame."""


@dataclass(frozen=True)
class Report:
    """Figures over all pictures, with 95 % bootstrap intervals over objects. Azimuths after the fitted offset."""

    iou: Interval
    azimuth_error_degrees: Interval
    """Median."""
    azimuth_accuracy: Interval
    """Share within 30°."""
    flipped: float
    """Share of azimuths that are wrong by more than 150°: taken for their own back."""
    picture_error: float
    """Mean absolute difference of input and reconstruction, linear RGB 0..1."""
    mean_shape_iou: float | None
    """The baseline that knows the class but not the picture: one mean shape of the validation objects."""
    azimuth_offset_degrees: float
    """What was fitted on the validation pictures: true ≈ predicted + offset."""
    pictures: int
    objects: int


@dataclass(frozen=True)
class Prediction:
    vertices: Float[Tensor, "N V 3"]
    azimuths: Float[Tensor, "N"]


def predict(checkpoint: Checkpoint, images: Float[Tensor, "N 3 H W"]) -> Prediction:
    """What the service would answer for each picture."""
    vertices, azimuths = [], []
    with torch.no_grad():
        for batch in images.split(BATCH):
            posterior = checkpoint.model.encode(batch)
            vertices.append(checkpoint.model.decode(posterior.shape_mean))
            azimuths.append(most_probable_azimuth(posterior))
    return Prediction(torch.cat(vertices), torch.cat(azimuths))


def fit_offset(checkpoint: Checkpoint, validation: ImageSet) -> float:
    """The azimuth offset of a model's canonical frame, radians. Raises DataError where no azimuths are known."""
    if validation.azimuths is None:
        raise DataError(
            "The canonical frame is aligned on validation pictures with known azimuths; metadata.csv names none. "
            "Render some with python -m trainer render."
        )
    everything = validation.batch(np.arange(len(validation)))
    return fit_azimuth_offset(predict(checkpoint, everything).azimuths.double().numpy(), validation.azimuths)


def judge(checkpoint: Checkpoint, pictures: Pictures, offset: float, mean: Voxels | None) -> Report:
    """All figures of the report; `offset` in radians, `mean` the mean shape of other objects of the class."""
    prediction = predict(checkpoint, pictures.images)
    errors = azimuth_error(prediction.azimuths.double().numpy() + offset, pictures.azimuths)
    overlaps = np.array(
        [
            float(iou(predicted, pictures.truth[index]))
            for predicted, index in zip(_occupancies(checkpoint, prediction, offset), pictures.objects, strict=True)
        ]
    )
    rng = np.random.default_rng(0)
    baseline = None if mean is None else float(np.mean([iou(mean, truth) for truth in pictures.truth]))
    degrees = np.degrees(errors)
    return Report(
        iou=bootstrap(overlaps, pictures.objects, rng),
        azimuth_error_degrees=bootstrap(degrees, pictures.objects, rng, median_error),
        azimuth_accuracy=bootstrap(errors, pictures.objects, rng, accuracy),
        flipped=float(np.mean(degrees > 150)),
        picture_error=_picture_error(checkpoint, prediction, pictures.images),
        mean_shape_iou=baseline,
        azimuth_offset_degrees=math.degrees(offset),
        pictures=len(pictures.images),
        objects=len(pictures.truth),
    )


def _occupancies(checkpoint: Checkpoint, prediction: Prediction, offset: float) -> Iterator[Voxels]:
    # The picture shows R(θ) v = R(θ + offset) R(-offset) v: in the class's frame the shape is R(-offset) v.
    turned = prediction.vertices @ rotation_about_y(torch.tensor(-offset)).T
    faces = checkpoint.model.faces.numpy()
    return (voxelise(vertices, faces) for vertices in turned.double().numpy())


def _picture_error(checkpoint: Checkpoint, prediction: Prediction, images: Float[Tensor, "N 3 H W"]) -> float:
    with torch.no_grad():
        drawn = render(checkpoint.model, checkpoint.scene, prediction.vertices, prediction.azimuths)
    return float((drawn - images).abs().mean())


def shapes_of(folder: Path, images: ImageSet) -> list[Voxels]:
    """The occupancy of each object of a rendered folder, made or read again from what render.json says.

    Raises DataError where the folder was not written by `trainer render`.
    """
    settings = read_settings(folder)
    if settings is None:
        raise DataError(
            f"{folder} has no render.json, so its shapes are not known. Expected a folder that `trainer render` wrote."
        )
    meshes = [load_instance(settings, name) for name in images.instance_names]
    occupancy = voxelise if is_procedural(settings) else voxelise_solid
    return [occupancy(mesh.vertices, mesh.faces) for mesh in meshes]


def from_folder(folder: Path, scene: SceneConfig) -> Pictures:
    """Test pictures from a folder that `trainer render` wrote."""
    images = load_image_folder(folder, scene.width, scene.height)
    if images.azimuths is None:
        raise DataError(f"{folder} has no azimuths in metadata.csv. Expected a folder that `trainer render` wrote.")
    everything = images.batch(np.arange(len(images)))
    return Pictures(everything, images.azimuths, images.instances, shapes_of(folder, images))


def from_meshes(folder: Path, scene: SceneConfig, views: int) -> Pictures:
    """Test pictures of mesh files (front = +z, up = +y), `views` of each at evenly spaced azimuths."""
    azimuths = -math.pi + (np.arange(views) + 0.5) * 2 * math.pi / views
    images, truth = [], []
    for path in mesh_files(folder):
        mesh = load_mesh(path)
        normals = corner_normals(mesh)
        images += [draw(mesh, float(azimuth), 0.0, scene, normals=normals)[0] for azimuth in azimuths]
        truth.append(voxelise_solid(mesh.vertices, mesh.faces))
    stacked = torch.from_numpy(np.stack(images)).permute(0, 3, 1, 2).contiguous()
    count = len(truth)
    return Pictures(stacked, np.tile(azimuths, count), np.repeat(np.arange(count), views), truth)


def mean_of(folder: Path, images: ImageSet) -> Voxels | None:
    """The mean shape of a validation folder's objects; None where its shapes are not known."""
    return mean_shape(np.stack(shapes_of(folder, images))) if read_settings(folder) is not None else None


def as_json(report: Report) -> dict[str, object]:
    """Flat figures under the names that `metrics.json` uses; intervals beside them as [low, high]."""
    flat: dict[str, object] = {}
    for field in dataclasses.fields(report):
        value = getattr(report, field.name)
        if isinstance(value, Interval):
            flat[field.name] = round(value.value, 4)
            flat[f"{field.name}_interval"] = [round(value.low, 4), round(value.high, 4)]
        else:
            flat[field.name] = round(value, 4) if isinstance(value, float) else value
    return flat
