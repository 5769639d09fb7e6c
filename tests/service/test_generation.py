"""Shapes that no picture shows, through real HTTP: samples, decoded codes, interpolations."""

import base64
import io
import math
from itertools import pairwise

import httpx
import numpy as np
import pytest
import trimesh
from PIL import Image

from service.generation import consecutive, decode_shape, interpolate, sample
from service.inference import Engine, decode, sample_shape_code
from tests.service.asking import post, problem
from tests.service.reading import document_of, vertices_of

JSON, PNG = {"Accept": "application/json"}, {"Accept": "image/png"}


@pytest.mark.parametrize("path", ["sample", "decode", "interpolate", "categories", "healthz", "readyz", "docs"])
def test_every_path_is_there_with_its_version_and_without(client: httpx.Client, path: str) -> None:
    query = {"decode": {"z": ",".join("0" * 12)}, "interpolate": {"from_seed": 1, "to_seed": 2}}.get(path, {})
    versioned, plain = (client.get(f"{prefix}/{path}", params=query) for prefix in ("/v1", ""))
    assert versioned.status_code == plain.status_code == 200
    assert versioned.content == plain.content


def test_temperature_scales_the_draw(client: httpx.Client, engine: Engine) -> None:
    codes = [
        np.array(client.get("/v1/sample", params={"seed": 7, "temperature": t}, headers=JSON).json()["shape_code"])
        for t in (0, 0.5, 1, 2)
    ]
    np.testing.assert_allclose(codes[2], sample_shape_code(7, engine.manifest.latent), atol=1e-6)
    for code, temperature in zip(codes, (0, 0.5, 1, 2), strict=True):
        np.testing.assert_allclose(code, temperature * codes[2], atol=1e-6)
    coldest = client.get("/v1/sample?seed=7&temperature=0", headers=JSON).json()
    assert (coldest["temperature"], coldest["seed"]) == (0, 7)
    assert client.get("/v1/sample?temperature=0&seed=9").content != client.get("/v1/sample?seed=9").content


def test_several_samples_stand_side_by_side(client: httpx.Client, engine: Engine) -> None:
    glb = client.get("/v1/sample?seed=4294967294&count=5&temperature=0.5").content
    seeds = [4294967294, 4294967295, 0, 1, 2]
    assert consecutive(4294967294, 5) == seeds
    document = document_of(glb)
    stands = [
        document["nodes"][root] for root in document["scenes"][0]["nodes"] if "children" in document["nodes"][root]
    ]
    assert [node["name"] for node in stands] == [f"sample {seed}" for seed in seeds]
    places = np.array([node["translation"] for node in stands])
    for one, other in pairwise(places):
        assert np.linalg.norm(one - other) > 1.1
    distances = np.linalg.norm(places[:, None] - places[None], axis=-1) + 9 * np.eye(5)
    assert distances.min() == pytest.approx(1.15)
    assert (places[:3, 2] < places[3:, 2].min()).all()
    for number, (node, seed) in enumerate(zip(stands, seeds, strict=True)):
        (child,) = node["children"]
        assert document["nodes"][child]["mesh"] == number
        code = sample_shape_code(seed, engine.manifest.latent, 0.5)
        np.testing.assert_array_equal(vertices_of(glb, number), decode(engine, code).vertices)
    extras = document["scenes"][0]["extras"]["samples"]
    assert [one["seed"] for one in extras] == seeds
    scene = trimesh.load(trimesh.util.wrap_as_stream(glb), file_type="glb", process=False)
    assert len(scene.geometry) == 5
    assert len(scene.graph.nodes_geometry) == 5


def test_all_of_several_samples_are_before_the_camera(client: httpx.Client) -> None:
    """Objects of unit diagonal in their places are inside of the picture."""
    for count in (2, 5, 64):
        document = document_of(client.get(f"/v1/sample?count={count}&temperature=0").content)
        camera = next(node for node in document["nodes"] if "camera" in node)
        lens = document["cameras"][0]["perspective"]
        x, y, z, w = camera["rotation"]
        forward = -np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])
        right = np.array([1.0, 0.0, 0.0])
        up = np.cross(right, forward)
        half = math.tan(lens["yfov"] / 2)
        for node in document["nodes"]:
            if "translation" in node and "children" in node:
                seen = np.array(node["translation"]) - camera["translation"]
                depth = seen @ forward
                assert lens["znear"] < depth < lens["zfar"]
                assert abs(seen @ up) + 0.5 < half * depth * 1.3
                assert abs(seen @ right) + 0.5 < half * lens["aspectRatio"] * depth * 1.3


def test_several_samples_as_a_list_are_what_each_seed_gives(client: httpx.Client, engine: Engine) -> None:
    response = client.get("/v1/sample?seed=3&count=3", headers=JSON)
    content = response.json()
    assert set(content) == {"category", "model", "samples"}
    assert content["model"] == engine.manifest.identity
    for seed, one in zip((3, 4, 5), content["samples"], strict=True):
        assert one == client.get(f"/v1/sample?seed={seed}", headers=JSON).json()
        assert base64.b64decode(one["glb_base64"]) == sample(engine, seed).content
    again = client.get("/v1/sample?seed=3&count=3", headers={**JSON, "If-None-Match": response.headers["etag"]})
    assert again.status_code == 304


def test_a_decoded_code_is_the_sample_that_has_it(client: httpx.Client, engine: Engine) -> None:
    code = sample_shape_code(7, engine.manifest.latent)
    response = client.get("/v1/decode", params={"z": ",".join(map(str, code.tolist())), "category": "car"})
    assert response.status_code == 200
    np.testing.assert_array_equal(vertices_of(response.content), vertices_of(sample(engine, 7).content))
    extras = document_of(response.content)["scenes"][0]["extras"]
    assert (extras["seed"], extras["temperature"], extras["posterior"]) == (None, None, None)
    assert response.content == decode_shape(engine, code.tolist()).content


@pytest.mark.parametrize(
    ("z", "sentence"),
    [
        ("1,2", "expected a shape code of 12 numbers for car, found 2; see /v1/categories"),
        (",".join("1" * 13), "found 13"),
        ("1,x,3", "expected numbers between commas in a shape code, found: could not convert string to float: 'x'"),
        ("", "expected numbers between commas"),
        (",".join(["nan"] * 12), "expected numbers from -10 to 10 in a shape code, found others"),
        (",".join(["1e9"] * 12), "expected numbers from -10 to 10"),
    ],
)
def test_a_wrong_shape_code_is_422(client: httpx.Client, z: str, sentence: str) -> None:
    assert sentence in problem(client.get("/v1/decode", params={"z": z}), 422, "invalid-shape-code")


def test_a_missing_shape_code_is_422(client: httpx.Client) -> None:
    assert "query.z" in problem(client.get("/v1/decode"), 422, "invalid-parameter")


def test_an_interpolation_begins_and_ends_at_its_samples(client: httpx.Client, engine: Engine) -> None:
    def between(t: float) -> np.ndarray:
        response = client.get("/v1/interpolate", params={"from_seed": 7, "to_seed": 8, "t": t}, headers=JSON)
        content = response.json()
        assert content["interpolation"] == {"from_seed": 7, "to_seed": 8, "t": t}
        assert "etag" in response.headers
        return np.array(content["shape_code"])

    start, end = (sample_shape_code(seed, engine.manifest.latent) for seed in (7, 8))
    np.testing.assert_allclose(between(0), start, atol=1e-6)
    np.testing.assert_allclose(between(1), end, atol=1e-6)
    np.testing.assert_allclose(between(0.25), 0.75 * start + 0.25 * end, atol=1e-6)
    halfway = client.get("/v1/interpolate?from_seed=7&to_seed=8").content
    assert halfway == interpolate(engine, 7, 8, 0.5).content
    backwards = client.get("/v1/interpolate?from_seed=8&to_seed=7").content
    np.testing.assert_array_equal(vertices_of(halfway), vertices_of(backwards))


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("sample?temperature=2.1", "temperature"),
        ("sample?temperature=nan", "temperature"),
        ("sample?count=0", "count"),
        ("sample?count=65", "count"),
        ("sample?azimuth_degrees=inf", "azimuth_degrees"),
        ("interpolate?from_seed=1", "to_seed"),
        ("interpolate?from_seed=1&to_seed=2&t=1.01", "t"),
        ("interpolate?from_seed=1&to_seed=2&t=nan", "t"),
    ],
)
def test_parameters_out_of_range_are_422(client: httpx.Client, path: str, name: str) -> None:
    assert f"query.{name}: " in problem(client.get(f"/v1/{path}"), 422, "invalid-parameter")


def test_a_turned_sample_has_a_turned_camera(client: httpx.Client) -> None:
    content = client.get("/v1/sample?seed=7&azimuth_degrees=270", headers=JSON).json()
    assert content["azimuth_degrees"] == -90
    glb = base64.b64decode(content["glb_base64"])
    camera = next(node for node in document_of(glb)["nodes"] if "camera" in node)
    # The object's front (+Z) shows to the left, so the camera stands at its left, which is... +X turned by +90°.
    assert camera["translation"] == pytest.approx([math.sqrt(3), 1, 0], abs=1e-9)
    np.testing.assert_array_equal(vertices_of(glb), vertices_of(client.get("/v1/sample?seed=7").content))


def test_samples_as_pictures(client: httpx.Client) -> None:
    one, same, turned, nine = (
        client.get(f"/v1/sample?seed=7&temperature=0.3&{rest}", headers=PNG)
        for rest in ("", "", "azimuth_degrees=90", "count=9")
    )
    assert one.content == same.content != turned.content
    assert one.headers["content-type"] == "image/png"
    assert "etag" in one.headers
    assert one.headers["content-disposition"] == 'inline; filename="car.png"'
    sizes = []
    for response in (one, turned, nine):
        with Image.open(io.BytesIO(response.content)) as picture:
            assert max(high for _, high in picture.getextrema()) > 100
            sizes.append(picture.size)
    assert sizes == [(512, 384), (512, 384), (3 * 128, 3 * 96)]


def test_a_picture_of_a_sample_can_be_sent_back(client: httpx.Client) -> None:
    picture = client.get("/v1/sample?seed=7&temperature=0.3", headers=PNG).content
    assert post(client, picture).status_code == 200
