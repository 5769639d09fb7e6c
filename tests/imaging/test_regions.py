"""Regions and neighbourhoods of masks, against scipy's."""

import numpy as np
import pytest
from scipy import ndimage

from imaging.neighbourhood import highest, lowest, total
from imaging.regions import flooded, regions_of, selected, sums_over


def masks() -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    random = [rng.random(rng.integers(1, 40, 2)) < rng.uniform(0.1, 0.95) for _ in range(60)]
    spiral = np.zeros((15, 15), bool)
    for inset in range(0, 7, 2):
        spiral[inset : 15 - inset, [inset, 14 - inset]] = True
        spiral[[inset, 14 - inset], inset : 15 - inset] = True
        spiral[inset + 1, inset] = False
        spiral[inset + 2, inset : inset + 2] = True
    return [*random, spiral, np.zeros((4, 5), bool), np.ones((4, 5), bool)]


@pytest.mark.parametrize("mask", masks())
def test_regions_are_those_of_scipy(mask: np.ndarray) -> None:
    labels, count = ndimage.label(mask)
    regions = regions_of(mask)
    assert len(regions.areas) == count
    values = np.random.default_rng(1).uniform(size=mask.shape).astype(np.float32)
    found = set()
    for number, area in enumerate(regions.areas):
        region = selected(regions, np.arange(count) == number)
        (label,) = set(labels[region])
        np.testing.assert_array_equal(region, labels == label)
        assert area == region.sum()
        assert regions.at_border[number] == (region[[0, -1]].any() or region[:, [0, -1]].any())
        assert sums_over(regions, values)[number] == pytest.approx(values[region].sum(), rel=1e-5)
        found.add(label)
    assert found == set(range(1, count + 1))


def test_a_flood_comes_from_the_border_only() -> None:
    mask = np.array([[0, 0, 0, 0, 0], [0, 1, 0, 1, 1], [0, 0, 0, 0, 0]], bool)
    np.testing.assert_array_equal(flooded(mask), mask & (np.arange(5) > 2))


@pytest.mark.parametrize("radius", [1, 2, 3, 9])
def test_neighbourhoods_are_those_of_scipy(radius: int) -> None:
    rng = np.random.default_rng(radius)
    plane, size = rng.uniform(size=(9, 13)).astype(np.float32), 2 * radius + 1
    mask = plane > 0.8
    np.testing.assert_array_equal(highest(plane, radius), ndimage.maximum_filter(plane, size, mode="constant"))
    np.testing.assert_array_equal(highest(mask, radius), ndimage.maximum_filter(mask, size, mode="constant"))
    inside = ndimage.minimum_filter(~mask, size, mode="constant", cval=True)
    np.testing.assert_array_equal(lowest(~mask, radius), inside)
    sums = ndimage.uniform_filter(plane.astype(float), size, mode="constant") * size**2
    np.testing.assert_allclose(total(plane[None], radius)[0], sums, rtol=1e-5)
