"""Answers that follow the picture downhill: on pictures of the model's own shapes, whose truth is known."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import httpx
import numpy as np
import pytest
import torch
from PIL import Image

from imaging.framing import frame_of
from imaging.preparation import Method, Prepared
from imaging.srgb import encode as to_srgb
from service.inference import Engine, Posterior, decode, encode, sample_shape_code
from service.reconstruction import reconstruct
from service.refinement import Effort, improve
from service.rendering.picture import draw
from service.rendering.projection import project
from service.rendering.shading import shade
from tests.service.reading import document_of, vertices_of
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.refinement import refined

WIDTH, HEIGHT = 64, 48
AZIMUTH = 0.4
ENOUGH = Effort(15)
METHODS: tuple[Method, ...] = ("framed", "background")


def drawn(engine: Engine, code: np.ndarray, azimuth: float, framing: bool = False) -> np.ndarray:
    """A picture of a model's own shape; as large as framing makes it, or as its camera sees it."""
    manifest = engine.manifest
    surface = decode(engine, code)
    screen = project(surface.vertices, azimuth, manifest.camera, WIDTH, HEIGHT)
    if framing:
        frame = frame_of(WIDTH, HEIGHT, manifest.camera.distance, manifest.camera.field_of_view_degrees)
        low, high = screen[:, :2].min(0), screen[:, :2].max(0)
        scale = frame.diagonal / np.hypot(*(high - low))
        screen[:, :2] = (screen[:, :2] - (low + high) / 2) * scale + (WIDTH / 2, HEIGHT / 2 + frame.drop)
    colours = shade(surface.normals, azimuth, 0.0, manifest.lights, manifest.ambient)
    return draw(screen, colours, engine.faces, WIDTH, HEIGHT, 4).colour.astype(np.float32)


@pytest.fixture(scope="module")
def code(engine: Engine) -> np.ndarray:
    return sample_shape_code(3, engine.manifest.latent, 0.5)


def near(engine: Engine, picture: np.ndarray, code: np.ndarray, azimuth: float) -> Posterior:
    """The encoder's answer with another shape and pose."""
    centres = np.radians(engine.manifest.azimuth_bin_centres_degrees)
    away = (azimuth - centres + math.pi) % (2 * math.pi) - math.pi
    best = int(np.abs(away).argmin())
    probabilities = np.full(len(centres), 0.5 / (len(centres) - 1), np.float32)
    probabilities[best] = 0.5
    return replace(
        encode(engine, picture),
        shape_mean=code,
        azimuth_probabilities=probabilities,
        azimuth_fine_mean=float(away[best]),
        azimuth=azimuth,
    )


def test_the_pose_and_the_shape_that_were_drawn_are_found(engine: Engine, code: np.ndarray) -> None:
    prepared = Prepared(drawn(engine, code, AZIMUTH), "framed")
    posterior = near(engine, prepared.picture, code / 2, AZIMUTH + 0.12)
    better = improve(engine, [prepared], [posterior], posterior.shape_mean, ENOUGH)
    (found,) = better.posteriors
    assert found.azimuth == pytest.approx(AZIMUTH, abs=0.03)
    before, after = (
        np.abs(decode(engine, one).vertices - decode(engine, code).vertices).mean()
        for one in (posterior.shape_mean, better.shape_code)
    )
    assert after < 0.7 * before
    centres = np.radians(engine.manifest.azimuth_bin_centres_degrees)
    best = found.azimuth_probabilities.argmax()
    assert math.cos(centres[best] + found.azimuth_fine_mean - found.azimuth) == pytest.approx(1)
    assert found.azimuth_probabilities.sum() == pytest.approx(1, abs=1e-5)


def test_how_probable_poses_are_stays_the_encoders_word(engine: Engine, code: np.ndarray) -> None:
    prepared = Prepared(drawn(engine, code, AZIMUTH), "framed")
    posterior = near(engine, prepared.picture, code, AZIMUTH + 0.1)
    (found,) = improve(engine, [prepared], [posterior], code, ENOUGH).posteriors
    np.testing.assert_array_equal(found.azimuth_probabilities, posterior.azimuth_probabilities)


def test_what_was_cut_out_has_no_size_of_its_own(engine: Engine, code: np.ndarray) -> None:
    """Framing decided its size and place: taken for the camera's, they would be explained by another shape."""
    picture = drawn(engine, code, AZIMUTH, framing=True)
    posterior = near(engine, picture, code, AZIMUTH + 0.1)
    moved = []
    for method in METHODS:
        better = improve(engine, [Prepared(picture, method)], [posterior], code, ENOUGH)
        moved.append(float(np.linalg.norm(better.shape_code - code)))
        if method == "background":
            assert better.posteriors[0].azimuth == pytest.approx(AZIMUTH, abs=0.03)
    assert moved[1] < 0.7 * moved[0]


def test_a_darker_picture_is_refined_alike(engine: Engine, code: np.ndarray) -> None:
    """Taken for what the usual light shows, it would be explained by a smaller shape."""
    picture = drawn(engine, code, AZIMUTH)
    posterior = near(engine, picture, code / 2, AZIMUTH + 0.1)
    usual, dark = (
        improve(engine, [Prepared(np.float32(light) * picture, "framed")], [posterior], posterior.shape_mean, ENOUGH)
        for light in (1.0, 0.4)
    )
    assert dark.posteriors[0].azimuth == pytest.approx(usual.posteriors[0].azimuth, abs=0.03)
    ends = (decode(engine, one.shape_code).vertices for one in (usual, dark))
    assert np.abs(np.subtract(*ends)).mean() < 0.005


def test_the_trainer_refines_alike(engine: Engine, bundle_directory: Path, code: np.ndarray) -> None:
    """Two renderers, one of them antialiased, and one search."""
    prepared = Prepared(drawn(engine, code, AZIMUTH), "framed")
    subject = from_bundle(bundle_directory)
    images = torch.tensor(prepared.picture[None])
    inference = subject.infer(images)
    posterior = encode(engine, prepared.picture)
    ours = improve(engine, [prepared], [posterior], posterior.shape_mean, Effort(8))
    theirs, codes = refined(
        inference, inference.shape_mean, images, subject.bin_centres, subject.decode, subject.faces, subject.scene, 8
    )
    bins = theirs.probabilities.argmax(1)
    azimuth = float(subject.bin_centres[bins] + theirs.azimuth_fine_mean)
    away = (azimuth - ours.posteriors[0].azimuth + math.pi) % (2 * math.pi) - math.pi
    assert away == pytest.approx(0, abs=0.05)
    ends = decode(engine, ours.shape_code).vertices, decode(engine, codes[0].numpy()).vertices
    assert np.abs(ends[0] - ends[1]).mean() < 0.02


def test_the_answer_tells_what_was_gained(engine: Engine, code: np.ndarray, encoded: Callable[..., bytes]) -> None:
    picture = encoded(Image.fromarray(to_srgb(drawn(engine, code, AZIMUTH)).transpose(1, 2, 0)))
    plain, better = (reconstruct([engine], [picture], 10**6, effort=effort) for effort in (Effort(), Effort(10)))
    assert plain.report.refinement is None
    gain = better.report.refinement
    assert gain is not None
    assert 1 <= gain.iterations <= 10
    assert gain.rerender_error_after < 0.8 * gain.rerender_error_before
    assert "refine" in better.timings_ms
    assert "refine" not in plain.timings_ms
    # How strange a picture is rests on the encoder's word.
    assert better.report.out_of_class_score == plain.report.out_of_class_score
    extras = document_of(better.content)["scenes"][0]["extras"]
    assert extras["refinement"]["iterations"] == gain.iterations
    shape = decode(engine, np.array(better.report.shape_code, np.float32))
    np.testing.assert_allclose(vertices_of(better.content), shape.vertices, atol=1e-5)


def test_no_time_leaves_the_guess(engine: Engine, code: np.ndarray) -> None:
    prepared = Prepared(drawn(engine, code, AZIMUTH), "framed")
    posterior = near(engine, prepared.picture, code, AZIMUTH)
    better = improve(engine, [prepared], [posterior], code, Effort(10, 0.0))
    assert better.iterations == 0
    np.testing.assert_array_equal(better.shape_code, code)


def test_over_http(client: httpx.Client, picture: bytes) -> None:
    def ask(**fields: str) -> httpx.Response:
        headers = {"Accept": "application/json"}
        return client.post("/v1/reconstruct", files={"image": picture}, data=fields, headers=headers)

    assert ask().json()["refinement"] is None
    assert ask(refine="0").json()["refinement"] is None
    first, second = ask(refine="3").json(), ask(refine="3").json()
    assert first["refinement"]["iterations"] in (1, 2, 3)
    assert first["refinement"]["rerender_error_after"] <= first["refinement"]["rerender_error_before"] * 1.05
    assert first["glb_base64"] == second["glb_base64"]
    for wrong in ("51", "-1", "two"):
        refused = ask(refine=wrong)
        assert refused.status_code == 422
        assert f"expected refine from 0 to 50, found “{wrong}”" in refused.json()["detail"]
