"""Guesses that know other objects of the class."""

import numpy as np

from imaging.srgb import encode
from trainer.evaluation.baselines import mean_shape_overlaps, nearest_neighbour_overlaps, nearest_pictures
from trainer.evaluation.pictures import Pictures, Truth, Validation
from trainer.evaluation.surface import Surface

NOWHERE = Surface(np.empty((0, 3)), np.empty((0, 3)))


def slabs(*thicknesses: int) -> np.ndarray:
    return np.stack([np.broadcast_to(np.arange(32) < thickness, (32, 32, 32)) for thickness in thicknesses])


def pictures_of(codes: np.ndarray, objects: list[int], voxels: np.ndarray) -> Pictures:
    truth = tuple(Truth(grid, NOWHERE, 1.0) for grid in voxels)
    return Pictures(codes, np.zeros(len(codes)), None, np.array(objects), truth, ())


def test_the_nearest_picture_is_the_one_with_the_least_squared_difference_in_linear_light() -> None:
    rng = np.random.default_rng(0)
    others = rng.integers(0, 256, (40, 3, 48, 64)).astype(np.uint8)
    order = rng.permutation(40)
    noisy = np.clip(others[order].astype(int) + rng.integers(-30, 31, others.shape), 0, 255).astype(np.uint8)
    np.testing.assert_array_equal(nearest_pictures(noisy, others), order)
    # Half the light is nearer to none than half the code is: 188 is half the light.
    dark, grey, light = (np.full((1, 3, 48, 64), code, np.uint8) for code in (0, 170, 255))
    assert encode(np.float32(0.5)) == 188
    assert nearest_pictures(grey, np.concatenate((dark, light))) == [0]


def test_pictures_are_compared_reduced_to_the_same_size() -> None:
    rng = np.random.default_rng(1)
    coarse = rng.integers(0, 256, (10, 3, 48, 64)).astype(np.uint8)
    fine = coarse.repeat(2, 2).repeat(2, 3)
    np.testing.assert_array_equal(nearest_pictures(fine[::-1], coarse), np.arange(10)[::-1])


def test_the_nearest_neighbour_is_the_object_of_the_nearest_picture() -> None:
    rng = np.random.default_rng(2)
    codes = rng.integers(0, 256, (4, 3, 48, 64)).astype(np.uint8)
    known = slabs(8, 16)
    validation = Validation(codes, np.zeros(4), np.array([0, 1, 1, 0]), known)
    pictures = pictures_of(codes[[2, 0, 3]], [0, 1, 1], slabs(16, 16))
    np.testing.assert_allclose(nearest_neighbour_overlaps(pictures, validation, known), [1.0, 0.5, 0.5])


def test_the_mean_shape_is_the_same_guess_for_every_picture() -> None:
    codes = np.zeros((3, 3, 48, 64), np.uint8)
    pictures = pictures_of(codes, [0, 1, 1], slabs(16, 4))
    np.testing.assert_allclose(mean_shape_overlaps(pictures, slabs(8, 8, 8, 24)), [0.5, 0.5, 0.5])
    np.testing.assert_allclose(mean_shape_overlaps(pictures, slabs(16)), [1.0, 0.25, 0.25])
