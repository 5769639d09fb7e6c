"""The judge: how well a model reconstructs shape and finds pose, on objects that it never saw.

Each object is shown in several pictures. The canonical frame of a model that was never told a pose is its own, so one
rotation about +Y is fitted per model on *validation* pictures and applied to all test predictions, and so is one
temperature of its coarse bins; what depends on the frame is also given without them. `docs/judge.md` tells the protocol
in words.
"""

import math
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from trainer.data.picture import rotation_about_y
from trainer.evaluation.baselines import mean_shape_overlaps, nearest_neighbour_overlaps
from trainer.evaluation.gallery import render
from trainer.evaluation.metrics import (
    FLIPPED_BEYOND,
    Interval,
    accuracy,
    azimuth_error,
    bootstrap,
    calibration_error,
    fit_azimuth_offset,
    fit_temperature,
    iou,
    mean,
    median_error,
    symmetric_azimuth_error,
    tempered,
)
from trainer.evaluation.pictures import Pictures, Validation, linear_batches, threads
from trainer.evaluation.report import BaselineFigures, FrameFigures, Report
from trainer.evaluation.subject import Prediction, Subject, predict
from trainer.evaluation.surface import agreement, visible_surface
from trainer.evaluation.voxels import inside_out, occupy

# Another sample of the surface than the truths': points of equal shapes would else coincide.
_START = 0.25


@dataclass(frozen=True)
class Judgement:
    """A report, and what it rests on picture by picture."""

    report: Report
    prediction: Prediction
    offset: float
    """The azimuth offset, radians; 0 where none is fitted."""
    overlaps: Float[ndarray, "N"]
    """IoU after that offset."""


class Alignment(NamedTuple):
    """What is fitted to a model on validation pictures."""

    offset: float
    """Of its azimuths, radians: true ≈ predicted + offset."""
    temperature: float
    """Of its coarse bins: above 1 where it is surer than it may be."""


UNALIGNED = Alignment(0.0, 1.0)


class Likeness(NamedTuple):
    """How alike predicted and true shapes are, picture by picture."""

    overlap: Float[ndarray, "N"]
    chamfer_distance: Float[ndarray, "N"]
    normal_consistency: Float[ndarray, "N"]


def judge(subject: Subject, pictures: Pictures, validation: Validation | None) -> Judgement:
    """All figures of the report; what is fitted is fitted on `validation`, and is not known without it."""
    prediction = predict(subject, pictures.codes, pictures.views)
    half_bin = math.pi / len(subject.bin_centres)
    unaligned = _likeness(subject, prediction, pictures, 0.0)
    fitted = None if validation is None else fit_alignment(subject, validation)
    aligned = unaligned if fitted is None else _likeness(subject, prediction, pictures, fitted.offset)
    report = Report(
        aligned=None if fitted is None else _frame_figures(prediction, pictures, aligned, fitted, half_bin),
        unaligned=_frame_figures(prediction, pictures, unaligned, UNALIGNED, half_bin),
        baselines=None if validation is None else _baseline_figures(pictures, validation),
        light_error_degrees=_light_error(prediction, pictures),
        picture_error=_interval(_picture_errors(subject, prediction, pictures), pictures),
        inside_out=_interval(_inside_out(subject, prediction, pictures, (fitted or UNALIGNED).offset), pictures),
        azimuth_offset_degrees=None if fitted is None else math.degrees(fitted.offset),
        azimuth_temperature=None if fitted is None else fitted.temperature,
        symmetric_objects=_symmetric_objects(pictures),
        pictures=len(pictures.codes),
        views_per_instance=pictures.views,
        objects=len(pictures.truth),
        skipped_meshes=len(pictures.skipped),
    )
    return Judgement(report, prediction, (fitted or UNALIGNED).offset, aligned.overlap)


def fit_alignment(subject: Subject, validation: Validation) -> Alignment:
    """The offset of a model's canonical frame, and the temperature at which its coarse bins, so turned, are as probable
    as they are right."""
    prediction = predict(subject, validation.codes)
    offset = fit_azimuth_offset(prediction.azimuths.double().numpy(), validation.azimuths)
    centres = subject.bin_centres.double().numpy()
    true_bins = np.cos(validation.azimuths[:, None] - offset - centres).argmax(1)
    return Alignment(offset, fit_temperature(prediction.probabilities.double().numpy(), true_bins))


def _likeness(subject: Subject, prediction: Prediction, pictures: Pictures, offset: float) -> Likeness:
    # The picture shows R(θ) v = R(θ + offset) R(-offset) v: in the class's frame the shape is R(-offset) v.
    turned = prediction.vertices.double().numpy() @ rotation_about_y(-offset).T
    faces = subject.faces.numpy()

    def compare(number: int) -> tuple[float, float, float]:
        truth = pictures.truth[pictures.objects[number]]
        solid = occupy(turned[number], faces)
        surface = visible_surface(turned[number], faces, solid.air, start=_START)
        return float(iou(solid.full, truth.voxels)), *agreement(surface, truth.surface)

    with ThreadPoolExecutor(threads()) as pool:
        compared = np.array(list(pool.map(compare, range(0, len(turned), pictures.views))))
    # Pictures that are shown together have one shape.
    return Likeness(*compared.repeat(pictures.views, 0).T)


def _frame_figures(
    prediction: Prediction, pictures: Pictures, likeness: Likeness, alignment: Alignment, half_bin: float
) -> FrameFigures:
    azimuths = prediction.azimuths.double().numpy() + alignment.offset
    orders = np.array([truth.order for truth in pictures.truth])[pictures.objects]
    errors = azimuth_error(azimuths, pictures.azimuths)
    symmetric_errors = symmetric_azimuth_error(azimuths, pictures.azimuths, orders)
    in_bin = azimuth_error(prediction.bins.double().numpy() + alignment.offset, pictures.azimuths) <= half_bin
    probabilities = prediction.probabilities.double().numpy()
    told, untempered = (
        np.column_stack((tempered(probabilities, temperature).max(1), in_bin))
        for temperature in (alignment.temperature, 1.0)
    )
    return FrameFigures(
        iou=_interval(likeness.overlap, pictures),
        azimuth_error_degrees=_interval(np.degrees(errors), pictures, median_error),
        azimuth_accuracy=_interval(errors, pictures, accuracy),
        symmetric_azimuth_error_degrees=_interval(np.degrees(symmetric_errors), pictures, median_error),
        symmetric_azimuth_accuracy=_interval(symmetric_errors, pictures, accuracy),
        flipped=_interval((errors > FLIPPED_BEYOND).astype(float), pictures),
        azimuth_calibration_error=_interval(told, pictures, calibration_error),
        untempered_calibration_error=_interval(untempered, pictures, calibration_error),
        chamfer_distance=_interval(likeness.chamfer_distance, pictures),
        normal_consistency=_interval(likeness.normal_consistency, pictures),
    )


def _baseline_figures(pictures: Pictures, validation: Validation) -> BaselineFigures | None:
    if validation.voxels is None:
        return None
    return BaselineFigures(
        mean_shape_iou=_interval(mean_shape_overlaps(pictures, validation.voxels), pictures),
        nearest_neighbour_iou=_interval(nearest_neighbour_overlaps(pictures, validation, validation.voxels), pictures),
    )


def _light_error(prediction: Prediction, pictures: Pictures) -> Interval | None:
    if prediction.light_azimuths is None or pictures.light_azimuths is None:
        return None
    errors = azimuth_error(prediction.light_azimuths.double().numpy(), pictures.light_azimuths)
    return _interval(np.degrees(errors), pictures, median_error)


def _picture_errors(subject: Subject, prediction: Prediction, pictures: Pictures) -> Float[ndarray, "N"]:
    errors: list[Tensor] = []
    start = 0
    for images in linear_batches(pictures.codes):
        shown = prediction.of(torch.arange(start, start + len(images)))
        drawn = render(subject.faces, subject.scene, shown.vertices, shown.azimuths, shown.light_azimuths)
        errors.append((drawn - images).abs().mean((1, 2, 3)))
        start += len(images)
    found: Float[ndarray, N] = torch.cat(errors).double().numpy()
    return found


def _inside_out(subject: Subject, prediction: Prediction, pictures: Pictures, offset: float) -> Float[ndarray, "N"]:
    # In the class's frame, so that a model and its bundle fill the same voxels.
    turned = prediction.vertices.double().numpy() @ rotation_about_y(-offset).T
    faces, shapes = subject.faces.numpy(), turned[:: pictures.views]
    with ThreadPoolExecutor(threads()) as pool:
        shares = np.array(list(pool.map(lambda vertices: inside_out(vertices, faces), shapes)))
    # Pictures that are shown together have one shape.
    return shares.repeat(pictures.views)


def _symmetric_objects(pictures: Pictures) -> dict[str, int]:
    counts = Counter(truth.order for truth in pictures.truth if truth.order > 1)
    return {"continuous" if math.isinf(order) else f"{order:.0f}": counts[order] for order in sorted(counts)}


def _interval(
    values: Float[ndarray, "N *K"],
    pictures: Pictures,
    statistic: Callable[[Float[ndarray, "M *K"]], float] = mean,
) -> Interval:
    # The same objects are drawn for every figure, so that intervals can be compared.
    return bootstrap(values, pictures.objects, np.random.default_rng(0), statistic)
