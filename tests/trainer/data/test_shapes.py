"""Every class: reproducible, closed, of the agreed frame and scale, recognisable from the front, and really varied."""

import hashlib

import numpy as np
import pytest

from tests.trainer.data.test_solid import assert_closed
from trainer.data.shapes.catalogue import CATEGORIES, make_shape
from trainer.data.shapes.solid import Mesh, signed_volume
from trainer.errors import ConfigError
from trainer.evaluation.metrics import iou, mean_shape
from trainer.evaluation.voxels import voxelise

SEEDS = range(150)

# The paper's figures less a margin of 0.10: what a class's own mean shape must not exceed, or the class proves nothing.
MOST_MEAN_SHAPE_IOU = {"car": 0.67, "chair": 0.35}


@pytest.fixture(scope="module", params=sorted(CATEGORIES))
def category(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def shapes(category: str) -> list[Mesh]:
    return [make_shape(category, seed) for seed in SEEDS]


def test_a_seed_names_one_shape(category: str, shapes: list[Mesh]) -> None:
    again = make_shape(category, 7)
    np.testing.assert_array_equal(again.vertices, shapes[7].vertices)
    np.testing.assert_array_equal(again.faces, shapes[7].faces)
    assert len({hashlib.sha256(mesh.vertices.tobytes()).hexdigest() for mesh in shapes}) == len(shapes)


def test_shapes_are_closed_and_look_outward(shapes: list[Mesh]) -> None:
    for mesh in shapes:
        assert_closed(mesh)
        for part in parts(mesh):
            assert signed_volume(part) > 0


def parts(mesh: Mesh) -> list[Mesh]:
    """The building blocks: vertices are never shared between them, and each block's are consecutive."""
    reach = np.maximum.accumulate(mesh.faces.max(1))
    starts = np.flatnonzero(np.append(True, mesh.faces.min(1)[1:] > reach[:-1]))
    return [Mesh(mesh.vertices, faces) for faces in np.split(mesh.faces, starts[1:])]


def test_shapes_are_centred_and_of_unit_diagonal(shapes: list[Mesh]) -> None:
    for mesh in shapes:
        assert np.isfinite(mesh.vertices).all()
        low, high = mesh.vertices.min(0), mesh.vertices.max(0)
        np.testing.assert_allclose(low, -high, atol=1e-12)
        assert np.linalg.norm(high - low) == pytest.approx(1.0)


def test_shapes_stand_upright_and_are_symmetric_from_side_to_side(category: str, shapes: list[Mesh]) -> None:
    grids = np.stack([voxelise(*mesh) for mesh in shapes])
    sides = iou(grids, grids[:, ::-1])
    assert np.median(sides) > 0.99
    heights = np.array([np.ptp(mesh.vertices[:, 1]) for mesh in shapes])
    lengths = np.array([np.ptp(mesh.vertices[:, 2]) for mesh in shapes])
    assert ((heights > lengths).mean() > 0.6) == (category == "chair")


def test_the_front_can_be_told_from_the_back(category: str, shapes: list[Mesh]) -> None:
    grids = np.stack([voxelise(*mesh) for mesh in shapes])
    turned = grids[:, ::-1, :, ::-1]
    same = iou(grids, turned)
    assert (same < 0.97).mean() > 0.97
    assert np.median(same) < (0.5 if category == "chair" else 0.9)
    # Which side is which: most cars' cabins and all chairs' backs stand behind the middle, a pickup's cab does not.
    depth = np.arange(32) - 15.5
    upper = np.array([(grid * _upper_third(grid)[None, :, None]).sum((0, 1)) @ depth for grid in grids])
    assert (upper < 0).mean() > (0.95 if category == "chair" else 0.75)


def _upper_third(grid: np.ndarray) -> np.ndarray:
    levels = np.flatnonzero(grid.any((0, 2)))
    return np.arange(32) > levels[0] + 2 / 3 * (levels[-1] - levels[0])


def test_the_mean_shape_does_not_explain_the_class(category: str, shapes: list[Mesh]) -> None:
    grids = np.stack([voxelise(*mesh) for mesh in shapes])
    training, test = grids[:100], grids[100:]
    assert iou(test, mean_shape(training)[None]).mean() < MOST_MEAN_SHAPE_IOU[category]


def test_an_unknown_class_is_refused_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match="did you mean 'chair'"):
        make_shape("chiar", 0)
    with pytest.raises(ConfigError, match="expected a shape seed of 0 or more, found -1"):
        make_shape("car", -1)
