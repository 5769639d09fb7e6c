"""Pictures of one object, several models, and what no model explains: without HTTP."""

import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

import service.reconstruction
from imaging.framing import Frame
from imaging.preparation import Prepared
from imaging.srgb import decode_table
from service.bundle import read_bundle
from service.errors import ImageError, ImageTooLargeError, StrangeImageError
from service.image import read_picture, read_pictures
from service.inference import Engine, decode, encode, load_engine, pool
from service.manifest import Errors, HeldOut
from service.reconstruction import reconstruct
from service.rendering.picture import draw
from service.rendering.projection import project
from service.rendering.shading import shade
from tests.imaging.photographs import before, boards, cutout, photographed
from tests.service.reading import document_of, vertices_of
from trainer.evaluation.refinement import Inference
from trainer.evaluation.subject import pooled_means

MANY = 10**7


@pytest.fixture(scope="module")
def other(second_bundle_directory: Path) -> Engine:
    return load_engine(read_bundle(second_bundle_directory))


@pytest.fixture(scope="module")
def views(encoded: Callable[..., bytes]) -> list[bytes]:
    """Three discs on black, shaded from different sides."""
    rows, columns = np.mgrid[-1:1:96j, -1.33:1.33:128j]
    inside = (rows**2 + columns**2 < 0.5)[..., None]
    shades = [
        np.stack((0.5 + x * rows, 0.5 + y * columns, 0.5 - x * y * rows), -1)
        for x, y in ((0.5, 0.3), (-0.6, 0.5), (0.1, -0.6))
    ]
    return [encoded(Image.fromarray((255 * (shade * inside).clip(0, 1)).astype(np.uint8))) for shade in shades]


def test_the_shape_of_several_pictures_is_pooled(engine: Engine, views: list[bytes]) -> None:
    posteriors = [encode(engine, read_picture(view, 64, 48, MANY).picture) for view in views]
    mean, deviation = pool(posteriors, 1)
    answer = reconstruct([engine], views, MANY)
    assert answer.report.shape_code == pytest.approx(mean, abs=1e-6)
    assert answer.report.views is not None
    alone = [reconstruct([engine], [view], MANY).report for view in views]
    assert [view.azimuth_degrees for view in answer.report.views] == [one.azimuth_degrees for one in alone]
    assert [view.hypotheses for view in answer.report.views] == [one.hypotheses for one in alone]
    assert answer.report.azimuth_degrees == alone[0].azimuth_degrees
    assert answer.report.posterior is not None
    assert answer.report.posterior.shape_deviation == pytest.approx(deviation, abs=1e-6)
    np.testing.assert_array_equal(vertices_of(answer.content), decode(engine, mean).vertices)


def test_shapes_are_pooled_as_the_judge_pools_them(engine: Engine, views: list[bytes]) -> None:
    posteriors = [encode(engine, read_picture(view, 64, 48, MANY).picture) for view in views]
    means = np.stack([posterior.shape_mean for posterior in posteriors])
    deviations = np.stack([posterior.shape_deviation for posterior in posteriors])
    nothing = torch.empty(0)
    said = Inference(torch.from_numpy(means), torch.from_numpy(deviations), nothing, nothing, None)
    for trained_on in (1, 3):
        (judged,) = pooled_means(said, len(views), trained_on).numpy()
        np.testing.assert_allclose(pool(posteriors, trained_on)[0], judged, atol=1e-6)
    np.testing.assert_array_equal(pool(posteriors, 3)[1], deviations.max(0))
    np.testing.assert_allclose(pool(posteriors, 1)[1] ** -2, (deviations**-2.0).mean(0), rtol=1e-5)


def test_one_picture_is_pooled_with_none(engine: Engine, views: list[bytes]) -> None:
    posterior = encode(engine, read_picture(views[0], 64, 48, MANY).picture)
    mean, deviation = pool([posterior], 1)
    np.testing.assert_array_equal(mean, posterior.shape_mean)
    np.testing.assert_array_equal(deviation, posterior.shape_deviation)


@pytest.mark.parametrize("deviation", [0.0, -1.0, 3e38])
def test_deviations_that_no_training_gives_leave_numbers(engine: Engine, views: list[bytes], deviation: float) -> None:
    first, second, _ = (encode(engine, read_picture(view, 64, 48, MANY).picture) for view in views)
    strange = replace(first, shape_deviation=np.full_like(first.shape_deviation, deviation))
    for posteriors in ([strange, second], [strange, strange]):
        assert all(np.isfinite(told).all() for told in pool(posteriors, 1))


def test_each_picture_has_its_camera(engine: Engine, views: list[bytes]) -> None:
    cameras = [node for node in document_of(reconstruct([engine], views, MANY).content)["nodes"] if "camera" in node]
    assert [node["name"] for node in cameras] == ["camera", "camera 2", "camera 3"]
    for node, view in zip(cameras, views, strict=True):
        alone = document_of(reconstruct([engine], [view], MANY).content)["nodes"]
        assert {**next(one for one in alone if "camera" in one), "name": node["name"]} == node


def test_hypotheses_are_the_best_bins_in_order(engine: Engine, views: list[bytes]) -> None:
    report = reconstruct([engine], views[:1], MANY, hypotheses=5).report
    assert report.hypotheses is not None
    assert report.posterior is not None
    probabilities = [one.probability for one in report.hypotheses]
    assert len(probabilities) == 5
    assert probabilities == sorted((entry.probability for entry in report.posterior.azimuth_bins), reverse=True)[:5]
    assert report.hypotheses[0].azimuth_degrees == pytest.approx(report.azimuth_degrees, abs=2e-3)
    for one in report.hypotheses:
        nearest = min(
            abs(
                (one.azimuth_degrees - report.posterior.azimuth_fine_mean_degrees - entry.azimuth_degrees + 180) % 360
                - 180
            )
            for entry in report.posterior.azimuth_bins
        )
        assert nearest < 1e-3
        assert -180 <= one.azimuth_degrees <= 180
    everything = reconstruct([engine], views[:1], MANY, hypotheses=360).report.hypotheses
    assert everything is not None
    assert len(everything) == 12


def test_the_model_that_explains_the_picture_answers(engine: Engine, other: Engine, views: list[bytes]) -> None:
    """With random weights nobody knows which that is; but both orders of asking must agree, and so must the mesh."""
    for view in views:
        first, second = reconstruct([engine, other], [view], MANY), reconstruct([other, engine], [view], MANY)
        assert first.content == second.content
        probabilities = first.report.category_probabilities
        assert probabilities is not None
        assert sum(probabilities.values()) == pytest.approx(1, abs=1e-6)
        assert list(probabilities.values()) == sorted(probabilities.values(), reverse=True)
        assert first.report.category == next(iter(probabilities))
        chosen = engine if first.report.category == "car" else other
        assert reconstruct([chosen], [view], MANY).report.shape_code == first.report.shape_code


def test_what_no_model_explains_is_refused(engine: Engine, views: list[bytes]) -> None:
    strict = HeldOut(pictures=20, framed=Errors(0.0, 1e-6), fitted=None)
    lenient = HeldOut(pictures=20, framed=Errors(0.0, 1e6), fitted=None)
    judged = [replace(engine, manifest=replace(engine.manifest, held_out=held_out)) for held_out in (strict, lenient)]
    with pytest.raises(
        StrangeImageError, match=r"model of car can explain, found .* score of [\d.]+, where 2 is the most"
    ):
        reconstruct(judged[:1], views, MANY)
    report = reconstruct(judged[1:], views, MANY).report
    assert report.out_of_class_score == 0
    assert report.views is not None
    assert [view.out_of_class_score for view in report.views] == [0, 0, 0]
    assert reconstruct([engine], views, MANY).report.out_of_class_score is None


def test_where_the_most_probable_model_explains_nothing_the_next_one_that_does_answers(
    engine: Engine, other: Engine, views: list[bytes]
) -> None:
    (first, second) = reconstruct([engine, other], views, MANY).report.category_probabilities or {}
    strict, lenient = (HeldOut(pictures=20, framed=Errors(0.0, worst), fitted=None) for worst in (1e-6, 1e6))
    judged = [
        replace(one, manifest=replace(one.manifest, held_out=strict if one.manifest.category == first else lenient))
        for one in (engine, other)
    ]
    assert reconstruct(judged, views, MANY).report.category == second


def test_the_pixels_of_all_pictures_count(engine: Engine, views: list[bytes]) -> None:
    one = 128 * 96
    assert reconstruct([engine], views[:3], 3 * one).report.category == "car"
    with pytest.raises(ImageTooLargeError, match=f"at most {3 * one - 1} pixels in all .* together, found {3 * one}"):
        reconstruct([engine], views[:3], 3 * one - 1)


def test_the_score_of_several_pictures_is_their_mean(engine: Engine, views: list[bytes]) -> None:
    held_out = HeldOut(pictures=20, framed=Errors(0.0, 5.0), fitted=None)
    judged = replace(engine, manifest=replace(engine.manifest, held_out=held_out))
    report = reconstruct([judged], views, MANY).report
    assert report.views is not None
    scores = [view.out_of_class_score for view in report.views]
    assert len(set(scores)) == 3
    assert report.out_of_class_score == pytest.approx(np.mean([score or 0 for score in scores]), abs=1e-4)


def test_a_busy_background_is_refused_whichever_model_is_asked(engine: Engine, other: Engine) -> None:
    with pytest.raises(ImageError, match="expected a plain background, found many colours"):
        reconstruct([engine, other], [photographed(before(cutout("car", 2, 0.9, 0.7), boards()), 2, 85)], MANY)


def test_one_bad_picture_of_several_is_named(engine: Engine, views: list[bytes]) -> None:
    with pytest.raises(ImageError, match="found 4 bytes"):
        reconstruct([engine], [views[0], b"what"], MANY)


def test_the_overlay_shows_the_mesh_over_the_picture(engine: Engine, views: list[bytes]) -> None:
    """Where the mesh is not, the picture at half its light; where it is, more of the mesh than of the picture."""
    camera = engine.manifest.camera
    answer = reconstruct([engine], views[:1], MANY, "png")
    with Image.open(io.BytesIO(answer.content)) as shown:
        assert (shown.format, shown.mode, shown.size) == ("PNG", "RGB", (512, 384))
        found = decode_table()[np.asarray(shown)].transpose(2, 0, 1)
    given = read_picture(views[0], 512, 384, MANY, camera.distance, camera.field_of_view_degrees).picture
    posterior = encode(engine, read_picture(views[0], 64, 48, MANY).picture)
    surface = decode(engine, posterior.shape_mean)
    screen = project(surface.vertices, posterior.azimuth, camera, 512, 384)
    colours = shade(surface.normals, posterior.azimuth, 0.0, engine.manifest.lights, engine.manifest.ambient)
    drawn = draw(screen, colours, engine.faces, 512, 384, 2)
    beside, inside = drawn.coverage == 0, drawn.coverage == 1
    assert beside.mean() > 0.2
    assert inside.mean() > 0.05
    np.testing.assert_allclose(found[:, beside], 0.5 * given[:, beside], atol=0.01)
    expected = 0.65 * drawn.colour + 0.35 * 0.5 * given
    np.testing.assert_allclose(found[:, inside], expected.clip(0, 1)[:, inside], atol=0.01)
    assert list(answer.timings_ms) == ["picture", "encoder", "decoder", "render", "png"]


def test_a_picture_that_is_only_plain_from_afar_is_shown_as_the_model_saw_it(
    engine: Engine, views: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_small(content: bytes, frames: Sequence[Frame], max_pixels: int) -> list[Prepared]:
        if any(frame.width > 64 for frame in frames):
            raise ImageError("expected a plain background, found many colours")
        return read_pictures(content, frames, max_pixels)

    monkeypatch.setattr(service.reconstruction, "read_pictures", read_small)
    with Image.open(io.BytesIO(reconstruct([engine], views[:1], MANY, "png").content)) as shown:
        assert shown.size == (512, 384)
        assert max(high for _, high in shown.getextrema()) > 50
