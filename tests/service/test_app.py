"""The service through real HTTP: `python -m service` in a process of its own."""

import base64
import io
import json
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import httpx
import numpy as np
import pytest
from PIL import Image

from service.generation import sample
from service.inference import Engine
from service.reconstruction import reconstruct
from service.symmetry import symmetry_order
from tests.service.asking import post, problem

JSON = {"Accept": "application/json"}
Encoded = Callable[..., bytes]


def test_a_picture_becomes_a_glb(client: httpx.Client, engine: Engine, picture: bytes) -> None:
    response = post(client, picture)
    expected = reconstruct([engine], [picture], 10**6)
    assert response.status_code == 200
    assert response.headers["content-type"] == "model/gltf-binary"
    assert response.content == expected.content
    assert float(response.headers["chiaro-azimuth-degrees"]) == expected.report.azimuth_degrees
    assert expected.report.posterior is not None
    confidence = expected.report.posterior.azimuth_confidence
    assert float(response.headers["chiaro-azimuth-confidence"]) == pytest.approx(confidence, abs=1e-4)
    assert response.headers["chiaro-category"] == "car"
    assert response.headers["chiaro-model"] == engine.manifest.identity
    lights = json.loads(response.headers["chiaro-lights"])
    assert [light["azimuth_degrees"] for light in lights] == [30, 150, 270]
    assert json.loads(response.headers["chiaro-ambient"]) == [0, 0, 0]
    stages = [stage.partition(";")[0] for stage in response.headers["server-timing"].split(", ")]
    assert stages == ["picture", "encoder", "decoder", "render", "glb"]


def test_the_same_as_json(client: httpx.Client, engine: Engine, picture: bytes) -> None:
    glb = post(client, picture).content
    response = post(client, picture, JSON, category="car")
    assert response.headers["content-type"] == "application/json"
    content = response.json()
    assert base64.b64decode(content["glb_base64"]) == glb
    assert content["category"] == "car"
    assert content["model"] == engine.manifest.identity
    assert len(content["shape_code"]) == 12
    assert content["camera"]["elevation_degrees"] == 30
    assert set(content["timings_ms"]) == {"picture", "encoder", "decoder", "render", "glb"}
    posterior = content["posterior"]
    probabilities = np.array([entry["probability"] for entry in posterior["azimuth_bins"]])
    assert probabilities.sum() == pytest.approx(1, abs=1e-5)
    assert posterior["azimuth_confidence"] == pytest.approx(probabilities.max(), abs=1e-6)
    assert posterior["azimuth_entropy_nats"] == pytest.approx(-(probabilities * np.log(probabilities)).sum(), abs=1e-4)
    assert posterior["azimuth_symmetry"] == content["views"][0]["azimuth_symmetry"] == symmetry_order(probabilities)
    best = posterior["azimuth_bins"][int(probabilities.argmax())]["azimuth_degrees"]
    difference = best + posterior["azimuth_fine_mean_degrees"] - content["azimuth_degrees"]
    assert math.remainder(difference, 360) == pytest.approx(0, abs=1e-3)


def test_the_same_as_a_picture(client: httpx.Client, picture: bytes) -> None:
    response = post(client, picture, {"Accept": "image/png"})
    assert response.headers["content-type"] == "image/png"
    assert response.headers["content-disposition"] == 'inline; filename="car.png"'
    assert response.headers["chiaro-azimuth-degrees"] == post(client, picture).headers["chiaro-azimuth-degrees"]
    assert response.headers["cache-control"] == "no-store"
    with Image.open(io.BytesIO(response.content)) as shown:
        assert shown.size == (512, 384)


def test_a_seed_gives_the_same_bytes_every_time(client: httpx.Client, engine: Engine) -> None:
    first, again, other = (client.get("/sample", params={"seed": seed}) for seed in (7, 7, 8))
    assert first.headers["content-type"] == "model/gltf-binary"
    assert first.content == again.content == sample(engine, 7).content
    assert first.content != other.content
    assert first.headers["cache-control"] == "public, max-age=3600"
    assert first.headers["vary"] == "Accept"
    as_json = client.get("/sample", params={"seed": 7, "category": "car"}, headers=JSON)
    assert as_json.content == client.get("/sample", params={"seed": 7}, headers=JSON).content
    assert base64.b64decode(as_json.json()["glb_base64"]) == first.content
    assert as_json.headers["etag"] != first.headers["etag"]


def test_what_the_client_holds_is_not_sent_again(client: httpx.Client) -> None:
    etag = client.get("/sample?seed=7").headers["etag"]
    for known in (etag, f'"other", W/{etag}', "*"):
        response = client.get("/sample?seed=7", headers={"If-None-Match": known})
        assert response.status_code == 304
        assert response.content == b""
        assert response.headers["etag"] == etag
    assert client.get("/sample?seed=8", headers={"If-None-Match": etag}).status_code == 200


def test_health_and_readiness(client: httpx.Client) -> None:
    assert client.get("/healthz").json() == {"status": "alive", "categories": ["car"]}
    assert client.get("/readyz").json() == {"status": "ready", "categories": ["car"]}


@pytest.mark.parametrize(
    ("accept", "media_type"),
    [
        ("*/*", "model/gltf-binary"),
        ("model/*;q=0.5, application/json;q=0.9", "application/json"),
        ("application/json;q=0.1, */*;q=0.2", "model/gltf-binary"),
        ("text/html, application/*", "application/json"),
        ("model/gltf-binary;q=0, */*", "application/json"),
    ],
)
def test_the_client_chooses_the_form(client: httpx.Client, accept: str, media_type: str) -> None:
    assert client.get("/sample", headers={"Accept": accept}).headers["content-type"] == media_type


@pytest.mark.parametrize(
    "accept", ["image/gif", "model/gltf-binary;q=0, application/json;q=x, image/png;q=0", "text/*"]
)
def test_a_form_that_is_not_there_is_406(client: httpx.Client, picture: bytes, accept: str) -> None:
    for response in (
        client.get("/sample", headers={"Accept": accept}),
        post(client, picture, {"Accept": accept}),
    ):
        detail = problem(response, 406, "not-acceptable")
        assert (
            f"expected Accept to allow model/gltf-binary or application/json or image/png, found “{accept}”" in detail
        )


def test_an_unknown_category_is_422(client: httpx.Client, picture: bytes) -> None:
    sentence = "expected one of car, found category “boat”; name one of those"
    assert problem(post(client, picture, category="boat"), 422, "unknown-category") == sentence
    assert problem(client.get("/sample?category=boat"), 422, "unknown-category") == sentence


@pytest.mark.parametrize("seed", ["x", "-1", str(2**32), "1.5", ""])
def test_a_wrong_seed_is_422(client: httpx.Client, seed: str) -> None:
    detail = problem(client.get("/sample", params={"seed": seed}), 422, "invalid-parameter")
    assert detail.startswith("query.seed: ")
    assert f"found “{seed}”" in detail


def test_unknown_paths_and_methods(client: httpx.Client) -> None:
    assert problem(client.get("/nothing"), 404, "not-found") == "GET /nothing: Not Found; see /docs for what there is"
    for method, path, allowed in (("DELETE", "/sample", "GET"), ("GET", "/v1/reconstruct", "POST")):
        response = client.request(method, path)
        assert f"{method} {path}" in problem(response, 405, "method-not-allowed")
        assert response.headers["allow"] == allowed
    problem(client.post("/v1/reconstrct"), 404, "not-found")
    assert client.head("/").headers["content-type"].startswith("text/html")


def on_black(colour: tuple[int, int, int]) -> Image.Image:
    picture = Image.new("RGB", (64, 48))
    picture.paste(colour, (20, 12, 44, 36))
    return picture


def test_each_of_many_clients_gets_its_own_answer(client: httpx.Client, encoded: Encoded) -> None:
    colours = [(255 - 10 * i, 20 * i, 100) for i in range(12)]
    pictures = [encoded(on_black(colour)) for colour in colours]
    alone = [post(client, content).content for content in pictures]
    assert len(set(alone)) == len(alone)
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda content: post(client, content).content, pictures * 4))
    assert together == alone * 4
