"""The re-render error and what follows from it: the out-of-class score and the category."""

import math
from dataclasses import replace

import numpy as np
import pytest

from imaging.decoding import Picture
from imaging.framing import box_around, frame_of
from imaging.preparation import Method, Prepared
from service.explanation import category_probabilities, out_of_class_score, unexplained
from service.inference import Engine, Posterior, Surface, decode, encode, sample_shape_code
from service.manifest import Errors, HeldOut
from service.rendering.picture import draw
from service.rendering.projection import project
from service.rendering.shading import shade


@pytest.fixture(scope="module")
def surface(engine: Engine) -> Surface:
    return decode(engine, sample_shape_code(5, engine.manifest.latent, 0.3))


@pytest.fixture(scope="module")
def posterior(engine: Engine) -> Posterior:
    found = encode(engine, np.zeros((3, 48, 64), np.float32))
    return replace(found, azimuth=0.6)


def taken(engine: Engine, surface: Surface, scale: float, shift: tuple[float, float], method: Method) -> Prepared:
    """A picture of the surface at azimuth 0.6, larger and aside of where the camera sees it."""
    manifest = engine.manifest
    screen = project(surface.vertices, 0.6, manifest.camera, 64, 48)
    middle = (screen[:, :2].min(0) + screen[:, :2].max(0)) / 2
    screen[:, :2] = (screen[:, :2] - middle) * scale + middle + shift
    colours = shade(surface.normals, 0.6, 0.0, manifest.lights, manifest.ambient)
    return Prepared(draw(screen, colours, engine.faces, 64, 48, 4).colour.astype(np.float32), method)


def test_what_is_drawn_alike_is_explained(engine: Engine, surface: Surface, posterior: Posterior) -> None:
    # The picture has sixteen points a pixel, the drawing one: they differ at edges.
    assert unexplained(engine, taken(engine, surface, 1.0, (0, 0), "framed"), posterior, surface) < 0.004


def test_what_is_turned_or_elsewhere_is_not(engine: Engine, surface: Surface, posterior: Posterior) -> None:
    turned = replace(posterior, azimuth=0.6 + math.pi / 2)
    seen = taken(engine, surface, 1.0, (0, 0), "framed")
    assert unexplained(engine, seen, turned, surface) > 0.1
    errors = [
        unexplained(engine, taken(engine, surface, 1.0, (shift, 0), "framed"), posterior, surface)
        for shift in (0, 1, 3, 9)
    ]
    assert errors == sorted(errors)
    assert errors[-1] > 0.1


def test_a_picture_without_the_object_costs_all_its_light_and_the_drawings(
    engine: Engine, surface: Surface, posterior: Posterior
) -> None:
    """A surface that is nowhere to be seen explains nothing: the error is 1."""
    nowhere = replace(surface, vertices=np.zeros_like(surface.vertices))
    seen = taken(engine, surface, 1.0, (0, 0), "framed")
    assert unexplained(engine, seen, posterior, nowhere) == pytest.approx(1)
    black = Prepared(np.zeros((3, 48, 64), np.float32), "framed")
    assert unexplained(engine, black, posterior, nowhere) == 0
    assert 1 < unexplained(engine, black, posterior, surface) < math.inf


@pytest.mark.parametrize("light", [0.25, 0.5, 3.0])
def test_a_picture_in_other_light_is_explained_at_a_price(
    engine: Engine, surface: Surface, posterior: Posterior, light: float
) -> None:
    seen = taken(engine, surface, 1.0, (0, 0), "framed")
    exposed = seen._replace(picture=light * seen.picture)
    assert unexplained(engine, exposed, posterior, surface) == pytest.approx(
        2 * unexplained(engine, seen, posterior, surface), rel=0.01
    )
    turned = replace(posterior, azimuth=0.6 + math.pi / 2)
    assert unexplained(engine, exposed, turned, surface) > 0.1


def test_where_the_frame_is_a_guess_size_and_place_do_not_count(
    engine: Engine, surface: Surface, posterior: Posterior
) -> None:
    """The object is brought where the surface is, whatever the surface's own size is."""
    camera = engine.manifest.camera
    frame = frame_of(64, 48, camera.distance, camera.field_of_view_degrees)
    edges = np.arange(65.0), np.arange(49.0)
    screen = project(surface.vertices, 0.6, camera, 64, 48)
    low, high = screen[:, :2].min(0), screen[:, :2].max(0)
    scale = frame.diagonal / np.hypot(*(high - low))
    centre = (low + high) / 2
    shift = (32 - centre[0], 24 + frame.drop - centre[1])
    seen = taken(engine, surface, scale, shift, "background")
    box = box_around(Picture(seen.picture, None, *edges, 1), (seen.picture.max(0) > 0.02).astype(np.float32))
    assert box.diagonal == pytest.approx(frame.diagonal, abs=2)
    smaller = replace(surface, vertices=surface.vertices * np.float32(0.8))
    assert unexplained(engine, seen, posterior, surface) < 0.004
    assert unexplained(engine, seen, posterior, smaller) < 0.01
    assert unexplained(engine, seen._replace(method="framed"), posterior, smaller) > 0.05


def test_the_score_counts_from_the_median_to_the_worst_of_twenty() -> None:
    held_out = HeldOut(pictures=99, framed=Errors(0.04, 0.12), fitted=Errors(0.1, 0.3))
    scores = [out_of_class_score(held_out, "framed", error) for error in (0.0, 0.04, 0.08, 0.12, 0.28)]
    assert scores == pytest.approx([0, 0, 0.5, 1, 3])
    for method in ("background", "alpha"):
        assert out_of_class_score(held_out, method, 0.5) == pytest.approx(2)
    assert out_of_class_score(replace(held_out, framed=None), "framed", 0.5) is None
    assert out_of_class_score(None, "framed", 0.5) is None


def test_probabilities_of_categories_in_closed_form() -> None:
    found = category_probabilities({"a": [0.2], "b": [0.1], "c": [0.2]})
    assert list(found) == ["b", "a", "c"]
    assert found == pytest.approx({"b": 32 / 34, "a": 1 / 34, "c": 1 / 34})
    assert category_probabilities({"only": [7.0]}) == {"only": 1.0}
    pooled = category_probabilities({"a": [0.2, 0.1], "b": [0.1, 0.1]})
    assert pooled == pytest.approx({"a": 1 / 33, "b": 32 / 33})
    assert category_probabilities({"a": [0.0], "b": [1e300]})["a"] == 1
    assert category_probabilities({"a": [0.1], "b": [0.1]}, {"a": math.log(3)}) == pytest.approx({"a": 0.75, "b": 0.25})
