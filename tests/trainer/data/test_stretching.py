"""Objects of other proportions: how many there are, how far they are stretched, and that a folder knows its own."""

import math
from pathlib import Path

import numpy as np
from PIL import Image

from imaging.srgb import encode
from trainer.config import SceneConfig
from trainer.data.metadata import read_metadata
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings, load_instance, poses, read_settings
from trainer.data.render import render_folder
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, box
from trainer.data.stretching import stretched
from trainer.evaluation.fill import fill
from trainer.evaluation.pictures import from_folder, truth_of

SPREAD = 0.15
CUBE = box((1.0, 1.0, 1.0))


def sides(mesh: Mesh) -> np.ndarray:
    return np.asarray(np.ptp(mesh.vertices, axis=0))


def test_half_of_the_objects_are_stretched_by_lognormal_factors() -> None:
    shapes = [stretched(CUBE, f"cube-{number}", 0, SPREAD) for number in range(2000)]
    others = [mesh for mesh in shapes if mesh is not CUBE]
    # Five standard deviations of a fair coin.
    assert abs(len(others) - 1000) < 5 * math.sqrt(500)
    ratios = np.log([sides(mesh)[[0, 1]] / sides(mesh)[2] for mesh in others])
    np.testing.assert_allclose(ratios.std(0), SPREAD * math.sqrt(2), rtol=0.1)
    np.testing.assert_allclose(ratios.mean(0), 0, atol=0.04)
    np.testing.assert_allclose([np.linalg.norm(sides(mesh)) for mesh in others], 1)


def test_from_where_an_object_is_seen_says_nothing_of_its_stretching() -> None:
    names = [f"cube-{number}" for number in range(2000)]
    stretches = np.array([stretched(CUBE, name, 0, SPREAD) is not CUBE for name in names])
    azimuths = np.array([next(poses(RenderSettings("car"), name, 1)).azimuth_degrees for name in names])
    for quarter in range(4):
        seen = (azimuths + 180) // 90 == quarter
        # Five standard deviations of a fair coin.
        assert abs(stretches[seen].mean() - 0.5) < 2.5 / math.sqrt(seen.sum())


def test_the_same_object_is_always_stretched_alike_and_with_another_seed_otherwise() -> None:
    name = next(name for name in map(str, range(20)) if stretched(CUBE, name, 0, SPREAD) is not CUBE)
    first, again = (stretched(CUBE, name, 0, SPREAD).vertices for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, stretched(CUBE, name, 5, SPREAD).vertices)
    further = stretched(CUBE, name, 0, 2 * SPREAD)
    np.testing.assert_allclose(
        np.log(sides(further) / sides(further)[0]), 2 * np.log(sides(Mesh(first, CUBE.faces)) / np.ptp(first[:, 0]))
    )


def test_nothing_is_stretched_unless_asked() -> None:
    name = "car-0000003"
    np.testing.assert_array_equal(load_instance(RenderSettings("car"), name).vertices, make_shape("car", 3).vertices)


def test_a_folder_shows_and_is_judged_by_its_stretched_objects(tmp_path: Path) -> None:
    settings, scene = RenderSettings("chair", supersampling=2, stretch=SPREAD), SceneConfig(32, 24)
    render_folder(tmp_path, settings, scene, 12, 1, 1, show_progress=False)
    assert read_settings(tmp_path) == settings
    rows = read_metadata(tmp_path)
    assert rows is not None
    changed = []
    for name, row in rows.items():
        mesh = load_instance(settings, row.instance)
        colour, _ = draw(mesh, math.radians(row.azimuth_degrees or 0.0), 0.0, scene, settings.supersampling)
        np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / name)), encode(colour))
        changed.append(not np.array_equal(mesh.vertices, make_shape("chair", int(row.instance[-7:])).vertices))
    assert 0 < sum(changed) < len(changed) == 12
    truth = from_folder(tmp_path, scene).truth
    for row, known in zip(rows.values(), truth, strict=True):
        expected = truth_of(mesh := load_instance(settings, row.instance), fill(mesh.vertices, mesh.faces))
        np.testing.assert_array_equal(known.voxels, expected.voxels)
