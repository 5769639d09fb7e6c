"""Before the probes agreed, and where they do not: the application in process."""

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import httpx
import numpy as np
import pytest
from fastapi import FastAPI

import service.catalogue
import service.inference
from service.app import create_app
from service.bundle import Bundle, read_bundle
from service.catalogue import Catalogue
from service.errors import InferenceError
from service.inference import Engine, load_engine
from service.manifest import Errors, HeldOut
from service.settings import Settings
from tests.service.asking import problem

Serving = Callable[[FastAPI], AbstractContextManager[httpx.Client]]


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 10
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_nothing_but_health_is_answered_before_the_probes_agree(
    serving: Serving, bundle: Bundle, picture: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    go = threading.Event()

    def load_later(bundle: Bundle) -> Engine:
        assert go.wait(10)
        return load_engine(bundle)

    monkeypatch.setattr(service.catalogue, "load_engine", load_later)
    with serving(create_app(Catalogue((bundle,)), Settings())) as client:
        try:
            assert client.get("/healthz").json() == {"status": "alive", "categories": []}
            for response in (
                client.get("/readyz"),
                client.get("/sample"),
                client.post("/reconstruct", files={"image": ("a", picture)}),
            ):
                assert response.status_code == 503
                assert response.headers["content-type"] == "application/problem+json"
                assert response.headers["retry-after"] == "1"
                assert "try again in a second" in response.json()["detail"]
        finally:
            go.set()
        wait_until(lambda: client.get("/readyz").status_code == 200)
        assert client.get("/sample").status_code == 200


def test_a_bundle_that_fails_its_probe_never_serves(
    serving: Serving, bundle: Bundle, second_bundle_directory: Path
) -> None:
    altered = {**bundle.probe, "vertices": bundle.probe["vertices"] + np.float32(0.01)}
    catalogue = Catalogue((replace(bundle, probe=altered), read_bundle(second_bundle_directory)))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: client.get("/healthz").json()["categories"] == ["chair"])
        response = client.get("/readyz")
        assert response.status_code == 503
        assert "vertices: expected the probe's numbers to within 0.001" in response.json()["detail"]
        assert client.get("/sample?category=car").status_code == 503
        assert client.get("/sample?category=chair").status_code == 200


@pytest.mark.parametrize("fault", [InferenceError("vertices: expected finite numbers, found others"), MemoryError()])
def test_a_bundle_that_fails_otherwise_lets_the_others_serve(
    serving: Serving,
    bundle: Bundle,
    second_bundle_directory: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    fault: Exception,
) -> None:
    def measure(engine: Engine) -> tuple[float, ...]:
        if engine.manifest.category == "car":
            raise fault
        return (0.0,)

    monkeypatch.setattr(service.inference, "_latent_activity", measure)
    with serving(create_app(Catalogue((bundle, read_bundle(second_bundle_directory))), Settings())) as client:
        wait_until(lambda: client.get("/healthz").json()["categories"] == ["chair"])
        assert "expected" in client.get("/readyz").json()["detail"]
        assert client.get("/sample?category=chair").status_code == 200
    assert any("car is not served" in message for message in caplog.messages)


def test_of_several_bundles_the_one_that_explains_a_picture_best_answers(
    serving: Serving, bundle: Bundle, second_bundle_directory: Path, picture: bytes
) -> None:
    catalogue = Catalogue((bundle, read_bundle(second_bundle_directory)))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: client.get("/readyz").status_code == 200)
        response = client.get("/sample")
        assert response.status_code == 422
        assert response.json()["detail"] == "expected a category, one of car, chair, found none; name one"
        answers = {
            category: client.post("/reconstruct", files={"image": ("a", picture)}, data={"category": category})
            for category in ("car", "chair")
        }
        for category, answer in answers.items():
            assert answer.headers["chiaro-category"] == category
        assert answers["car"].content != answers["chair"].content
        chosen = client.post("/reconstruct", files={"image": ("a", picture)}).headers
        asked = client.post("/reconstruct", files={"image": ("a", picture)}, data={"category": "auto"}).headers
        assert chosen["chiaro-category"] == asked["chiaro-category"]
        assert 0.5 <= float(chosen["chiaro-category-probability"]) <= 1
        assert "chiaro-category-probability" not in answers["car"].headers


def test_a_mesh_that_is_not_finite_is_a_problem_and_no_glb(serving: Serving, bundle: Bundle, picture: bytes) -> None:
    class Broken:
        def run(self, outputs: list[str], feed: dict[str, np.ndarray]) -> list[np.ndarray]:
            return [np.full((1, 98, 3), np.nan, np.float32)] * 2

    catalogue = Catalogue((bundle,))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: catalogue.ready)
        catalogue.engines["car"] = replace(catalogue.engines["car"], decoder=Broken())
        response = client.post("/reconstruct", files={"image": ("a", picture)})
        assert response.status_code == 500
        assert response.json()["detail"].startswith("vertices: expected finite numbers, found others")


def test_a_picture_that_no_model_explains_is_422(serving: Serving, bundle: Bundle, picture: bytes) -> None:
    held_out = HeldOut(pictures=20, framed=Errors(0.0, 1e-6), fitted=None)
    catalogue = Catalogue((replace(bundle, manifest=replace(bundle.manifest, held_out=held_out)),))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: catalogue.ready)
        for form in ("model/gltf-binary", "application/json", "image/png"):
            response = client.post("/v1/reconstruct", files={"image": ("a", picture)}, headers={"Accept": form})
            assert "expected a picture that the model of car can explain" in problem(response, 422, "unexplained-image")


def test_models_that_are_not_there_choose_nothing(serving: Serving, bundle: Bundle, picture: bytes) -> None:
    """A bundle that failed is left out where the service chooses, and its own sentence is told where it is named."""
    altered = {**bundle.probe, "vertices": bundle.probe["vertices"] + np.float32(0.01)}
    catalogue = Catalogue((replace(bundle, probe=altered),))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: bool(catalogue.failures))
        for response in (
            client.post("/v1/reconstruct", files={"image": ("a", picture)}),
            client.post("/v1/reconstruct", files={"image": ("a", picture)}, data={"category": "car"}),
            client.get("/v1/categories"),
        ):
            assert "vertices: expected the probe's numbers" in problem(response, 503, "not-ready")


def test_a_bundles_bytes_are_let_go_once_its_engine_has_them(bundle: Bundle) -> None:
    catalogue = Catalogue((bundle,))
    assert catalogue.names == ("car",)
    catalogue.load()
    assert catalogue.bundles == ()
    assert (catalogue.names, list(catalogue.engines)) == (("car",), ["car"])


def test_a_fault_of_our_own_is_a_problem_without_details(serving: Serving, bundle: Bundle) -> None:
    catalogue = Catalogue((bundle,))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: catalogue.ready)
        catalogue.engines["car"] = replace(catalogue.engines["car"], manifest=None)
        response = client.get("/sample")
        assert response.status_code == 500
        assert response.headers["content-type"] == "application/problem+json"
        assert "NoneType" not in response.text
