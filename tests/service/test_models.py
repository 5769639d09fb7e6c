"""What the service says of its models and of itself: /categories and /metrics."""

import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace

import httpx
import numpy as np
import pytest
from fastapi import FastAPI

from service.app import create_app
from service.bundle import Bundle
from service.catalogue import Catalogue
from service.inference import Engine, decode
from service.manifest import Errors, HeldOut
from service.models import report_model
from service.settings import Settings
from tests.service.asking import post
from tests.service.test_readiness import wait_until

Serving = Callable[[FastAPI], AbstractContextManager[httpx.Client]]


def test_categories_say_what_each_model_is(client: httpx.Client, engine: Engine) -> None:
    (model,) = client.get("/v1/categories").json()["categories"]
    assert model["category"] == "car"
    assert model["model"] == engine.manifest.identity
    assert model["parameterisation"] == "subdivision"
    assert model["conventions"]["frame"].startswith("right-handed, +Y up")
    assert (model["picture"]["width"], model["picture"]["height"]) == (64, 48)
    assert model["camera"] == {"elevation_degrees": 30.0, "distance": 2.0, "field_of_view_degrees": 30.0}
    assert [light["azimuth_degrees"] for light in model["lights"]] == [30, 150, 270]
    assert (model["vertices"], model["faces"], model["blocks"]) == (98, 192, ["body"])
    assert (model["azimuth_bins"], model["latent"], model["light_varies"]) == (12, 12, False)
    assert model["metrics"] == {"iou": 0.5}
    assert (model["training_step"], model["held_out"]) == (3, None)


def test_the_latent_order_is_that_of_how_far_vertices_move(engine: Engine) -> None:
    moved = []
    for dimension in range(engine.manifest.latent):
        code = np.zeros(engine.manifest.latent, np.float32)
        code[dimension] = 1
        difference = decode(engine, code).vertices.astype(np.float64) - decode(engine, -code).vertices
        moved.append(np.sqrt((difference**2).sum(-1).mean()))
    assert engine.latent_activity == pytest.approx(moved, rel=1e-4)
    report = report_model(engine)
    assert sorted(report.latent_order) == list(range(12))
    assert [moved[dimension] for dimension in report.latent_order] == sorted(moved, reverse=True)


def test_held_out_errors_are_told(engine: Engine) -> None:
    held_out = HeldOut(pictures=30, framed=Errors(0.1, 0.2), fitted=None)
    assert report_model(replace(engine, manifest=replace(engine.manifest, held_out=held_out))).held_out == held_out


@pytest.mark.parametrize("training", [{}, {"config": None}, {"config": {"model": []}}, {"step": "x", "config": {}}])
def test_a_bundle_that_tells_little_of_its_training_is_described(engine: Engine, training: dict[str, object]) -> None:
    report = report_model(replace(engine, manifest=replace(engine.manifest, training=training)))
    assert (report.parameterisation, report.training_step) == ("subdivision", None)


def figure(text: str, name: str, **labels: str) -> float:
    """A figure of that name whose labels are those, in any order."""
    for line in text.splitlines():
        found = re.fullmatch(rf"{name}(?:\{{(.*)\}})? (\S+)", line)
        if found and dict(re.findall(r'(\w+)="([^"]*)"', found[1] or "")) == labels:
            return float(found[2])
    return 0.0


def test_metrics_count_requests_stages_and_models(
    serving: Serving, bundle: Bundle, engine: Engine, picture: bytes
) -> None:
    catalogue = Catalogue((bundle,))
    with serving(create_app(catalogue, Settings())) as client:
        wait_until(lambda: catalogue.ready)
        for path in ("/v1/sample", "/sample", "/nothing", "/v1/sample?seed=x"):
            client.get(path)
        post(client, picture)
        post(client, b"no picture")
        client.request("BREW", "/sample")
        response = client.get("/v1/metrics")
        text = response.text
        assert response.headers["content-type"].startswith("text/plain")
        count = "chiaro_requests_total"
        assert figure(text, count, method="GET", route="/sample", status="200") == 2
        assert figure(text, count, method="GET", route="/sample", status="422") == 1
        assert figure(text, count, method="POST", route="/reconstruct", status="200") == 1
        assert figure(text, count, method="POST", route="/reconstruct", status="415") == 1
        assert figure(text, count, method="other", route="/sample", status="405") == 1
        assert "nothing" not in text
        assert figure(text, "chiaro_request_seconds_count", route="/reconstruct") == 2
        for stage in ("picture", "encoder", "render"):
            assert figure(text, "chiaro_stage_seconds_count", stage=stage) == 1
        assert figure(text, "chiaro_stage_seconds_count", stage="decoder") == 3
        assert figure(text, "chiaro_models_loaded") == figure(text, "chiaro_models") == 1
        assert figure(text, "chiaro_requests_in_progress") == 1
        assert figure(text, "process_resident_memory_bytes") > 10**7
        broken = replace(engine, manifest=None)
        catalogue.engines["car"] = broken
        assert client.get("/sample").status_code == 500
        assert figure(client.get("/metrics").text, count, method="GET", route="/sample", status="500") == 1
