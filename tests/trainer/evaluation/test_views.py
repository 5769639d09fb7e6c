"""Several pictures of an object, shown to a model at once: its shape is found from all, its pose from each."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.exporter.conftest import small_checkpoint, trained_on_views
from tests.trainer.evaluation.conftest import knowing, subject_of
from trainer.data.shapes.solid import Mesh
from trainer.errors import DataError
from trainer.evaluation.pictures import Pictures, Validation, grouped, linear_batches
from trainer.evaluation.protocol import judge
from trainer.evaluation.refinement import Inference
from trainer.evaluation.subject import from_checkpoint, pooled_means, predict


def test_the_pictures_of_a_group_show_an_object_from_all_around(tested: Pictures) -> None:
    together = grouped(tested, 4)
    objects, azimuths = together.objects.reshape(-1, 4), together.azimuths.reshape(-1, 4)
    assert (objects == objects[:, :1]).all()
    np.testing.assert_allclose(np.diff(azimuths), math.pi / 2, atol=1e-12)
    order = np.lexsort((together.azimuths, together.objects))
    np.testing.assert_array_equal(together.codes[order], tested.codes)
    assert together.views == 4


def test_one_picture_at_once_is_what_there_was(tested: Pictures) -> None:
    alone = grouped(tested, 1)
    np.testing.assert_array_equal(alone.codes, tested.codes)
    np.testing.assert_array_equal(alone.azimuths, tested.azimuths)


def test_lights_stay_with_their_pictures(tested: Pictures) -> None:
    lights = np.linspace(0, 1, len(tested.azimuths))
    together = grouped(replace(tested, light_azimuths=lights), 2)
    assert together.light_azimuths is not None
    for azimuth, number, light in zip(together.azimuths, together.objects, together.light_azimuths, strict=True):
        (index,) = np.flatnonzero((tested.azimuths == azimuth) & (tested.objects == number))
        assert light == lights[index]


def test_a_number_of_pictures_that_is_no_multiple_is_refused(tested: Pictures) -> None:
    with pytest.raises(DataError, match=r"a multiple of 3 pictures .* found 8 of one, and other numbers for 3 objects"):
        grouped(tested, 3)
    lost = replace(tested, codes=tested.codes[:-1], azimuths=tested.azimuths[:-1], objects=tested.objects[:-1])
    with pytest.raises(DataError, match=r"found 7 of one, and other numbers for 1 objects of 3"):
        grouped(lost, 4)


def test_no_group_is_torn_apart(tested: Pictures) -> None:
    codes = np.concatenate([tested.codes] * 22)
    assert [len(batch) for batch in linear_batches(codes, 3)] == [255, 255, 18]


def test_a_model_sees_a_group_as_it_does_in_training(tested: Pictures) -> None:
    checkpoint = trained_on_views(small_checkpoint(), 4)
    model, subject = checkpoint.model, from_checkpoint(checkpoint)
    codes = np.random.default_rng(0).integers(0, 256, (8, 3, model.height, model.width), np.uint8)
    (images,) = linear_batches(codes)
    together = predict(subject, codes, 4)
    with torch.no_grad():
        shape_means = model.encode(images).shape_mean
        expected = model.decode(torch.stack((shape_means[:4].amax(0), shape_means[4:].amax(0))))
    torch.testing.assert_close(together.vertices, expected.repeat_interleave(4, 0))
    alone = predict(subject, codes)
    torch.testing.assert_close(together.azimuths, alone.azimuths)
    assert not torch.allclose(together.vertices, alone.vertices, atol=1e-6)


def test_of_a_model_of_single_pictures_the_geometric_mean_of_their_densities_is_taken() -> None:
    """The density that is in proportion to the fourth root of the product of four, found on a grid."""
    means = torch.tensor([[0.5, -1.0], [0.7, 2.0], [0.2, 0.0], [0.6, 0.4]], dtype=torch.float64)
    deviations = torch.tensor([[0.1, 1.0], [0.3, 0.2], [0.9, 0.5], [0.1, 1.0]], dtype=torch.float64)
    nothing = torch.empty(0)
    (found,) = pooled_means(Inference(means, deviations, nothing, nothing, None), 4, 1)
    grid = torch.linspace(-8, 8, 160_001, dtype=torch.float64)[:, None, None]
    logarithm = torch.distributions.Normal(means, deviations).log_prob(grid).mean(1)
    weight = logarithm.softmax(0)
    torch.testing.assert_close(found, (weight * grid[:, 0]).sum(0), atol=1e-9, rtol=0)


def test_one_picture_is_pooled_with_none_and_several_in_any_order() -> None:
    subject = from_checkpoint(small_checkpoint())
    codes = np.random.default_rng(0).integers(0, 256, (3, 3, 48, 64), np.uint8)
    together, turned = predict(subject, codes, 3), predict(subject, codes[[2, 0, 1]], 3)
    torch.testing.assert_close(together.vertices, turned.vertices)
    alike = predict(subject, codes[[1, 1, 1]], 3)
    torch.testing.assert_close(alike.vertices[:1], predict(subject, codes[[1]]).vertices)


def test_what_one_picture_does_not_show_another_does(
    tested: Pictures, validation: Validation, shapes: list[Mesh]
) -> None:
    """A predictor that takes the first four pictures of each object for another object: its code, which is lower than
    those of the others, does not count among them."""
    frame = math.radians(50)
    oracle = knowing(shapes, frame, tested, validation)
    count = len(tested.codes)
    fooled = torch.arange(count)[torch.arange(count) % 8 < 4]
    oracle.vertices[fooled] = oracle.vertices[(fooled + 8) % count]
    subject = replace(subject_of(oracle), views_per_instance=2)
    alone = judge(subject, tested, validation).report
    together = judge(subject, grouped(tested, 2), validation).report
    assert alone.aligned is not None
    assert together.aligned is not None
    assert alone.aligned.iou.value < 0.9
    assert together.aligned.iou.value == pytest.approx(1, abs=0.003)
    assert (alone.views_per_instance, together.views_per_instance) == (1, 2)
    # Frame and poses are found picture by picture.
    assert together.azimuth_offset_degrees == pytest.approx(50, abs=1e-3)
    assert together.aligned.azimuth_accuracy.value == 1
