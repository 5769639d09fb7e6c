"""The cup: closed, outward, hollow from above, its own mirror image; and what goes with it."""

import numpy as np
import pytest

from rasteriser.topology import build_topology
from trainer.config import LossConfig, ModelConfig, SceneConfig
from trainer.evaluation.voxels import occupy
from trainer.geometry.cup import subdivided_cup
from trainer.geometry.topology import underside
from trainer.model.vae import Model
from trainer.training.loop import fixed_geometry


@pytest.mark.parametrize("segments", [1, 2, 3, 4, 6, 7])
def test_a_cup_is_closed_and_outward(segments: int) -> None:
    vertices, faces = subdivided_cup(segments, side=0.4)
    topology = build_topology(faces)
    assert (topology.edge_faces >= 0).all()
    assert len(vertices) - len(topology.edges) + len(faces) == 2
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volume = np.einsum("fi,fi->", a, np.cross(b, c)) / 6
    # Of the circles' polygons, outside less inside.
    section = 2 * segments * np.sin(np.pi / (2 * segments))
    assert volume == pytest.approx(section * (0.55**2 - 0.75 * 0.385**2) * 0.4**3)


def test_a_cup_of_four_segments_has_178_vertices_and_is_as_wide_as_told() -> None:
    vertices, faces = subdivided_cup(4)
    assert (len(vertices), len(faces)) == (178, 352)
    np.testing.assert_allclose(np.ptp(vertices, axis=0), (1.1, 1.0, 1.1))
    np.testing.assert_allclose(vertices.min(0) + vertices.max(0), 0, atol=1e-12)


@pytest.mark.parametrize("segments", [1, 2, 3, 4, 7])
def test_a_cup_is_its_own_mirror_image_left_to_right_and_front_to_back(segments: int) -> None:
    vertices, faces = subdivided_cup(segments)
    triangles = {tuple(sorted(map(tuple, np.round(vertices[face], 6) + 0.0))) for face in faces}
    for axis in (0, 2):
        mirror = np.ones(3)
        mirror[axis] = -1
        mirrored = {tuple(sorted(map(tuple, np.round(vertices[face] * mirror, 6) + 0.0))) for face in faces}
        assert mirrored == triangles


def test_a_cup_is_hollow_from_above_and_solid_below() -> None:
    vertices, faces = subdivided_cup(6, side=0.6)
    middle = occupy(vertices, faces).full[15:17, :, 15:17].all((0, 2))
    heights = (np.arange(32) + 0.5) / 32 - 0.5
    np.testing.assert_array_equal(middle, (heights > -0.3) & (heights < -0.15))


def test_the_underside_of_a_cup_is_its_bottom_without_its_foot_and_not_its_floor() -> None:
    vertices, faces = subdivided_cup(4)
    found = vertices[underside(vertices, faces)]
    assert len(found) == 17
    np.testing.assert_allclose(found[:, 1], -0.5)
    geometry = fixed_geometry(Model(ModelConfig(base="cup"), 32, 24), SceneConfig(), LossConfig(laplacian_underside=4))
    assert geometry.laplacian is not None
    assert geometry.laplacian.shape == (178, 178)
    assert sorted(geometry.laplacian.diagonal().tolist()) == [1.0] * 161 + [2.0] * 17
