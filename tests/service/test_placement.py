"""Where cut-out objects belong: the search itself, what it mends, and what it leaves alone."""

import io
import math
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

import service.placement
from imaging.framing import USUAL, Placement
from imaging.preparation import Prepared, placed
from imaging.srgb import decode_table
from imaging.srgb import encode as encode_srgb
from service.bundle import read_bundle
from service.explanation import unexplained
from service.image import read_picture
from service.inference import Engine, Posterior, Surface, decode, encode, load_engine
from service.placement import place
from service.reconstruction import reconstruct
from service.rendering.picture import draw as draw_mesh
from service.rendering.projection import project
from tests.service.asking import post, problem
from trainer.config import SceneConfig
from trainer.data.picture import draw
from trainer.data.shapes.catalogue import make_shape

CARS = Path(__file__).parents[2] / "models" / "car"
MANY = 10**6


@pytest.fixture(scope="module")
def cars() -> Engine:
    return load_engine(read_bundle(CARS))


def photograph(category: str, seed: int, azimuth: float) -> bytes:
    """A PNG of an object before white, larger than its frame."""
    colour, alpha = draw(make_shape(category, seed), azimuth, 0.0, SceneConfig(width=256, height=192), 2)
    picture = np.ones((240, 320, 3), np.float32)
    picture[24:216, 32:288] = colour + (1 - alpha)[..., None]
    buffer = io.BytesIO()
    Image.fromarray(encode_srgb(picture)).save(buffer, "PNG")
    return buffer.getvalue()


def prepared_for(engine: Engine, content: bytes, scale: int = 1) -> Prepared:
    size, camera = engine.manifest.picture, engine.manifest.camera
    width, height, lens = scale * size.width, scale * size.height, camera.field_of_view_degrees
    return read_picture(content, width, height, MANY, camera.distance, lens, zoom=size.zoom)


def error(engine: Engine, prepared: Prepared, posterior: Posterior) -> float:
    return unexplained(engine, prepared, posterior, decode(engine, posterior.shape_mean))


def test_unseen_cars_are_explained_and_turned_better(cars: Engine) -> None:
    before, after, turns = [], [], []
    for seed in range(8):
        azimuth = 2 * math.pi * (0.618 * seed % 1)
        prepared = prepared_for(cars, photograph("car", 7_000_000 + seed, azimuth))
        assert prepared.guessed
        usual = encode(cars, prepared.picture)
        found = place(cars, prepared, 2)
        assert not found.prepared.guessed
        before.append(error(cars, placed(prepared, USUAL), usual))
        after.append(error(cars, found.prepared, found.posterior))
        turns.append(
            [
                abs((posterior.azimuth - azimuth + math.pi) % (2 * math.pi) - math.pi)
                for posterior in (usual, found.posterior)
            ]
        )
    assert np.mean(after) < 0.75 * np.mean(before)
    right = (np.array(turns) < math.radians(30)).sum(0)
    print(f"re-render error {np.mean(before):.3f} → {np.mean(after):.3f}, within 30°: {right[0]} → {right[1]} of 8")
    assert right[1] >= right[0]
    assert right[1] >= 6


@pytest.mark.parametrize("true", [Placement(1.1, 0.06, -0.04), Placement(0.82, -0.07, 0.0), USUAL])
def test_the_search_ends_near_what_explains_best(
    cars: Engine, true: Placement, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = []

    def misfit(_: Engine, prepared: Prepared, __: Posterior, ___: Surface) -> float:
        looks.append(at := prepared.placement)
        assert at is not None
        away = (math.log(at.size / true.size) / 0.1, (at.right - true.right) / 0.04, (at.down - true.down) / 0.04)
        return 0.02 + 0.1 * math.hypot(*away)

    monkeypatch.setattr(service.placement, "unexplained", misfit)
    prepared = prepared_for(cars, photograph("car", 7_000_000, 0.5))
    found, rounds = place(cars, prepared, 3).prepared, 3
    assert found.placement is not None
    assert abs(math.log(found.placement.size / true.size)) < 0.06
    assert math.hypot(found.placement.right - true.right, found.placement.down - true.down) < 0.04
    assert len(looks) == len(set(looks)) <= 1 + 6 * rounds
    np.testing.assert_array_equal(found.picture, placed(prepared, found.placement).picture)


def test_what_explains_nothing_stays_where_the_rule_sets_it(cars: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service.placement, "unexplained", lambda *_: 0.3)
    prepared = prepared_for(cars, photograph("car", 7_000_000, 0.5))
    found = place(cars, prepared, 2).prepared
    assert found.placement == USUAL
    np.testing.assert_array_equal(found.picture, prepared.picture)


def test_classes_are_told_apart_by_where_each_model_sees_the_object() -> None:
    names = ("car", "chair", "jar", "rifle", "sofa")
    engines = [load_engine(read_bundle(CARS.parent / name)) for name in names]
    right = {0: 0, 2: 0}
    for number, name in enumerate(names):
        for seed in range(3):
            content = photograph(name, 7_000_000 + seed, 2 * math.pi * (0.618 * (3 * number + seed) % 1))
            for rounds in right:
                report = reconstruct(engines, [content], MANY, rounds=rounds).report
                assert report.category_probabilities is not None
                assert report.category_probabilities.keys() == set(names)
                right[rounds] += report.category == name
    print(f"right of 15: {right}")
    assert right[2] > right[0]
    assert right[2] >= 13


def test_framed_pictures_and_no_rounds_are_left_alone(cars: Engine, engine: Engine, picture: bytes) -> None:
    cut_out = prepared_for(cars, photograph("car", 7_000_000, 0.5))
    framed = prepared_for(engine, picture)
    assert (framed.method, framed.cutout, framed.guessed) == ("framed", None, False)
    for model, prepared, rounds in ((cars, cut_out, 0), (engine, framed, 2)):
        found, posterior = place(model, prepared, rounds)
        assert found is prepared
        np.testing.assert_array_equal(posterior.shape_mean, encode(model, prepared.picture).shape_mean)
    assert placed(framed, Placement(1.2)) is framed


def test_an_answer_tells_whether_it_was_looked_for(client: httpx.Client, picture: bytes) -> None:
    content, json = photograph("car", 7_000_000, 0.5), {"Accept": "application/json"}
    looked, unplaced = (post(client, content, json, **fields).json() for fields in ({}, {"place": "0"}))
    assert "place" in looked["timings_ms"]
    assert "place" not in unplaced["timings_ms"]
    assert looked["shape_code"] != unplaced["shape_code"]
    # The score is that of the first sight: so are the figures that it is compared with.
    assert looked["out_of_class_score"] == unplaced["out_of_class_score"]
    assert "place" not in post(client, picture, json).json()["timings_ms"]
    for wrong in ("5", "-1", "some"):
        assert f"expected place from 0 to 4, found “{wrong}”" in problem(
            post(client, content, place=wrong), 422, "invalid-form"
        )


def test_the_overlay_shows_the_object_where_it_was_set(engine: Engine) -> None:
    """Beside the mesh, the picture at half its light."""
    content, camera = photograph("car", 7_000_000, 0.5), engine.manifest.camera
    with Image.open(io.BytesIO(reconstruct([engine], [content], MANY, "png", rounds=3).content)) as shown:
        found = decode_table()[np.asarray(shown)].transpose(2, 0, 1)
    (prepared, posterior), closer = place(engine, prepared_for(engine, content), 3), prepared_for(engine, content, 8)
    assert prepared.placement not in (None, USUAL)
    screen = project(decode(engine, posterior.shape_mean).vertices, posterior.azimuth, camera, 512, 384)
    beside = draw_mesh(screen, np.ones((len(screen), 3)), engine.faces, 512, 384, 2).coverage == 0
    assert beside.mean() > 0.2
    differences = [
        np.abs(found - 0.5 * picture)[:, beside].max()
        for picture in (placed(closer, prepared.placement).picture, closer.picture)
    ]
    assert differences[0] < 0.01
    assert differences[1] > 0.1
