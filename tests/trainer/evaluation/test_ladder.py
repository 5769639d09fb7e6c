"""The sanity ladder: guesses from the truth down to a box score in the order in which a person would put them."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box, mirrored, turned
from trainer.evaluation.fill import fill
from trainer.evaluation.metrics import iou, mean_shape
from trainer.evaluation.pictures import Truth, truth_of
from trainer.evaluation.surface import agreement, visible_surface
from trainer.evaluation.voxels import occupy

OBJECTS = 16


class Score(NamedTuple):
    iou: float
    chamfer_distance: float
    normal_consistency: float


def score(guesses: list[Mesh], truths: list[Truth]) -> Score:
    """As the judge compares predictions with truths."""
    found = []
    for guess, truth in zip(guesses, truths, strict=True):
        solid = occupy(*guess)
        surface = visible_surface(*guess, solid.air, start=0.25)
        found.append((float(iou(solid.full, truth.voxels)), *agreement(surface, truth.surface)))
    return Score(*np.mean(found, 0))


def hull(mesh: Mesh) -> Mesh:
    convex = ConvexHull(mesh.vertices)
    outward = np.cross(
        mesh.vertices[convex.simplices[:, 1]] - mesh.vertices[convex.simplices[:, 0]],
        mesh.vertices[convex.simplices[:, 2]] - mesh.vertices[convex.simplices[:, 0]],
    )
    inward = (outward * convex.equations[:, :3]).sum(1) < 0
    return Mesh(mesh.vertices, np.where(inward[:, None], convex.simplices[:, ::-1], convex.simplices).astype(np.int64))


def bounding_box(mesh: Mesh) -> Mesh:
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    return box(high - low, (low + high) / 2)


@pytest.fixture(scope="module", params=["car", "chair"])
def ladder(request: pytest.FixtureRequest) -> dict[str, Score]:
    shapes = [make_shape(request.param, seed) for seed in range(OBJECTS)]
    truths = [truth_of(mesh, fill(*mesh)) for mesh in shapes]
    mean = mean_shape(np.stack([fill(*make_shape(request.param, 100 + seed)).full for seed in range(40)]))
    return {
        "truth": score(shapes, truths),
        "mirror": score([mirrored(mesh) for mesh in shapes], truths),
        "hull": score([hull(mesh) for mesh in shapes], truths),
        "box": score([bounding_box(mesh) for mesh in shapes], truths),
        "other": score(shapes[1:] + shapes[:1], truths),
        "quarter turn": score([turned(mesh, 1, np.pi / 2) for mesh in shapes], truths),
        "mean": Score(float(np.mean([iou(mean, truth.voxels) for truth in truths])), np.nan, np.nan),
        "nothing": score([Mesh(np.zeros((3, 3)), np.array([(0, 1, 2)]))] * OBJECTS, truths),
    }


def test_the_truth_is_perfect(ladder: dict[str, Score]) -> None:
    """IoU is 1 but for walls thinner than a fine voxel; the distance is that of two samples of one surface."""
    assert ladder["truth"].iou > 0.99
    assert ladder["truth"].chamfer_distance < 0.012
    assert ladder["truth"].normal_consistency > 0.9


def test_overlap_falls_from_rung_to_rung(ladder: dict[str, Score]) -> None:
    """Most of these objects are their own mirror images."""
    rungs = {name: value.iou for name, value in ladder.items()}
    assert rungs["truth"] >= rungs["mirror"] > rungs["hull"] > rungs["box"] > rungs["nothing"] == 0
    assert rungs["mirror"] > rungs["mean"] > rungs["other"] > 0
    assert rungs["mirror"] > rungs["quarter turn"] > 0
    assert rungs["truth"] - max(rungs["mean"], rungs["hull"]) > 0.25


def test_surfaces_tell_the_same(ladder: dict[str, Score]) -> None:
    for better, worse in [("truth", "hull"), ("hull", "box"), ("truth", "quarter turn"), ("truth", "other")]:
        assert ladder[better].chamfer_distance < 0.75 * ladder[worse].chamfer_distance
        assert ladder[better].normal_consistency > ladder[worse].normal_consistency
    assert ladder["truth"].chamfer_distance < 0.5 * ladder["hull"].chamfer_distance
    assert ladder["nothing"][1:] == (1.0, 0.0)
