"""The judge against predictors whose figures are known: a perfect one, one with a frame of its own, a wrong one."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from tests.trainer.evaluation.conftest import knowing, subject_of
from trainer.data.shapes.solid import Mesh
from trainer.errors import CheckpointError
from trainer.evaluation.pictures import Pictures, Validation
from trainer.evaluation.protocol import fit_alignment, judge
from trainer.evaluation.refinement import Inference
from trainer.evaluation.subject import predict


@pytest.mark.parametrize("frame_degrees", [0.0, 70.0, -160.0])
def test_a_perfect_predictor_scores_perfectly_whatever_its_frame(
    tested: Pictures, validation: Validation, shapes: list[Mesh], frame_degrees: float
) -> None:
    frame = math.radians(frame_degrees)
    subject = subject_of(knowing(shapes, frame, tested, validation))
    assert fit_alignment(subject, validation).offset == pytest.approx(frame, abs=1e-5)
    judgement = judge(subject, tested, validation)
    report, aligned = judgement.report, judgement.report.aligned
    assert aligned is not None
    assert (report.objects, report.pictures, report.skipped_meshes) == (3, 24, 0)
    # To the rounding of vertices in single precision, which may move a surface over the centre of a voxel.
    assert aligned.iou.value == pytest.approx(1, abs=0.003)
    assert aligned.iou.low <= aligned.iou.value <= aligned.iou.high
    assert aligned.azimuth_error_degrees.value < 1e-3
    assert aligned.azimuth_accuracy == (1.0, 1.0, 1.0)
    assert aligned.flipped.value == 0
    assert aligned.azimuth_calibration_error.value < 1e-6
    assert aligned.chamfer_distance.value < 0.012
    assert aligned.normal_consistency.value > 0.85
    assert report.azimuth_offset_degrees == pytest.approx(frame_degrees, abs=1e-3)
    assert judgement.offset == pytest.approx(frame, abs=1e-5)
    # Corner normals of the data are sharp at creases, those of a model are smooth: shading differs, outlines do not.
    assert report.picture_error.value < 0.02
    assert report.inside_out.value == 0
    # A frame of one's own costs all that depends on it, and nothing else.
    away = abs(frame_degrees)
    assert report.unaligned.azimuth_error_degrees.value == pytest.approx(away, abs=1e-3)
    assert report.unaligned.azimuth_accuracy.value == (1 if away == 0 else 0)
    assert report.unaligned.flipped.value == (1 if away > 150 else 0)
    if away:
        assert report.unaligned.iou.value < 0.6 * aligned.iou.value
        assert report.unaligned.chamfer_distance.value > 2 * aligned.chamfer_distance.value


def test_without_validation_pictures_nothing_is_fitted(tested: Pictures, shapes: list[Mesh]) -> None:
    judgement = judge(subject_of(knowing(shapes, 0.0, tested)), tested, None)
    report = judgement.report
    assert report.aligned is report.baselines is report.azimuth_offset_degrees is report.azimuth_temperature is None
    assert report.unaligned.iou.value == pytest.approx(1, abs=0.003)
    assert judgement.offset == 0


def test_a_wrong_sign_of_the_offset_would_show(tested: Pictures, validation: Validation, shapes: list[Mesh]) -> None:
    frame = math.radians(35)
    oracle = knowing(shapes, frame, tested, validation)
    # On the validation pictures it errs the other way.
    oracle.azimuths[len(tested.codes) :] += 2 * frame
    wrong = judge(subject_of(oracle), tested, validation).report
    assert wrong.aligned is not None
    assert wrong.azimuth_offset_degrees == pytest.approx(-35, abs=1e-3)
    assert wrong.aligned.azimuth_error_degrees.value == pytest.approx(70, abs=1e-3)
    assert wrong.aligned.azimuth_accuracy.value == 0
    assert wrong.aligned.iou.value < 0.6


def test_errors_are_counted_in_azimuth_and_shape_apart(tested: Pictures, shapes: list[Mesh]) -> None:
    """A quarter of the pictures is taken for their own backs; every shape is right."""
    oracle = knowing(shapes, 0.0, tested)
    oracle.azimuths[::4] += math.pi
    figures = judge(subject_of(oracle), tested, None).report.unaligned
    assert figures.flipped.value == 0.25
    # It was as sure of those as of the others.
    assert figures.azimuth_calibration_error.value == pytest.approx(0.25, abs=1e-6)
    assert figures.azimuth_accuracy.value == 0.75
    assert figures.azimuth_error_degrees.value < 1e-3
    assert figures.iou.value == pytest.approx(1, abs=0.003)
    assert figures.symmetric_azimuth_accuracy == figures.azimuth_accuracy


def test_half_a_turn_is_no_error_where_nobody_can_tell(tested: Pictures, shapes: list[Mesh]) -> None:
    """Two of three objects are declared symmetric: one of order 2, one a solid of revolution."""
    orders = (1.0, 2.0, math.inf)
    pictures = replace(
        tested, truth=tuple(truth._replace(order=order) for truth, order in zip(tested.truth, orders, strict=True))
    )
    oracle = knowing(shapes, 0.0, pictures)
    oracle.azimuths += math.radians(170)
    report = judge(subject_of(oracle), pictures, None).report
    assert report.symmetric_objects == {"2": 1, "continuous": 1}
    assert report.unaligned.azimuth_error_degrees.value == pytest.approx(170, abs=1e-3)
    assert report.unaligned.symmetric_azimuth_error_degrees.value == pytest.approx(10, abs=1e-3)
    assert report.unaligned.symmetric_azimuth_accuracy.value == pytest.approx(2 / 3)
    assert report.unaligned.azimuth_accuracy.value == 0


def test_another_shape_is_a_worse_one(tested: Pictures, validation: Validation, shapes: list[Mesh]) -> None:
    pictures = replace(tested, objects=np.roll(tested.objects, 8))
    oracle = knowing(shapes, 0.0, pictures, validation)
    report = judge(subject_of(oracle), tested, validation).report
    assert report.aligned is not None
    a, b, c = (truth.voxels for truth in tested.truth)
    expected = (overlap(a, b) + overlap(b, c) + overlap(c, a)) / 3
    assert report.aligned.iou.value == pytest.approx(expected, abs=0.003)
    assert report.aligned.iou.value < 0.7
    assert report.aligned.azimuth_accuracy.value == 1


def overlap(first: np.ndarray, second: np.ndarray) -> float:
    return float((first & second).sum() / (first | second).sum())


def test_baselines_know_the_validation_objects(tested: Pictures, validation: Validation, shapes: list[Mesh]) -> None:
    subject = subject_of(knowing(shapes, 0.0, tested, validation))
    known = replace(validation, voxels=np.stack([tested.truth[0].voxels] * 3))
    baselines = judge(subject, tested, known).report.baselines
    assert baselines is not None
    a, b, c = (truth.voxels for truth in tested.truth)
    expected = (1 + overlap(a, b) + overlap(a, c)) / 3
    assert baselines.mean_shape_iou.value == baselines.nearest_neighbour_iou.value == pytest.approx(expected)
    assert baselines.mean_shape_iou.low < expected < baselines.mean_shape_iou.high
    # The objects that are judged, in other pictures: the nearest one is mostly the right one.
    baselines = judge(subject, tested, validation).report.baselines
    assert baselines is not None
    assert baselines.nearest_neighbour_iou.value > 0.7
    assert judge(subject, tested, replace(validation, voxels=None)).report.baselines is None


def test_the_light_is_judged_where_it_turns_and_the_model_tells(tested: Pictures, shapes: list[Mesh]) -> None:
    lights = np.radians(np.linspace(0, 170, len(tested.codes)))
    subject = subject_of(knowing(shapes, 0.0, tested))

    def infer(images: Tensor) -> Inference:
        found = subject.infer(images)
        return found._replace(light_azimuths=torch.tensor(lights, dtype=torch.float32) + math.radians(7))

    turning, telling = replace(tested, light_azimuths=lights), replace(subject, infer=infer)
    found = judge(telling, turning, None).report.light_error_degrees
    assert found is not None
    assert found.value == pytest.approx(7, abs=1e-3)
    assert judge(telling, tested, None).report.light_error_degrees is None
    assert judge(subject, turning, None).report.light_error_degrees is None


def test_numbers_that_are_not_finite_are_refused(tested: Pictures, shapes: list[Mesh]) -> None:
    oracle = knowing(shapes, 0.0, tested)
    oracle.vertices[3, 5, 1] = math.nan
    with pytest.raises(CheckpointError, match=r"found numbers that are not finite\. Train again"):
        predict(subject_of(oracle), tested.codes)


def test_figures_do_not_depend_on_how_the_work_is_shared(
    tested: Pictures, shapes: list[Mesh], monkeypatch: pytest.MonkeyPatch
) -> None:
    subject = subject_of(knowing(shapes, 0.3, tested))
    found = []
    for count in (1, 4):
        monkeypatch.setattr("trainer.evaluation.protocol.threads", lambda count=count: count)
        found.append(judge(subject, tested, None).report)
    assert found[0] == found[1]
