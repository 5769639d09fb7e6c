"""What the service says of itself is true, complete, and asks no other host."""

import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import httpx
import pytest
from fastapi import FastAPI
from pydantic import TypeAdapter

from service.app import create_app
from service.bundle import Bundle
from service.catalogue import Catalogue
from service.http.schema import AnswerBody
from service.settings import Settings

Serving = Callable[[FastAPI], AbstractContextManager[httpx.Client]]


@pytest.fixture(scope="module")
def app(bundle: Bundle) -> FastAPI:
    return create_app(Catalogue((bundle,)), Settings())


@pytest.fixture(scope="module")
def client(app: FastAPI, serving: Serving) -> Iterator[httpx.Client]:
    with serving(app) as client:
        yield client


@pytest.fixture(scope="module")
def schema(client: httpx.Client) -> dict[str, Any]:
    content: dict[str, Any] = client.get("/openapi.json").json()
    return content


def test_every_path_is_described_and_there_without_its_version(client: httpx.Client, schema: dict[str, Any]) -> None:
    assert schema["openapi"].startswith("3.1")
    names = ("reconstruct", "sample", "decode", "interpolate", "categories", "healthz", "readyz", "metrics")
    assert set(schema["paths"]) == {f"/v1/{name}" for name in names}
    for name in (*names, "docs", "openapi.json"):
        versioned, plain = (client.options(f"{prefix}/{name}") for prefix in ("/v1", ""))
        assert versioned.status_code == plain.status_code == 405
        assert versioned.headers["allow"] == plain.headers["allow"]
    assert "also there without /v1" in schema["info"]["description"]


def test_answers_are_described_in_both_forms_with_an_example_that_fits(schema: dict[str, Any]) -> None:
    body = {"$ref": "#/components/schemas/AnswerBody"}
    for method, path in (("post", "reconstruct"), ("get", "sample"), ("get", "decode"), ("get", "interpolate")):
        answer = schema["paths"][f"/v1/{path}"][method]["responses"]["200"]
        assert set(answer["content"]) == {"model/gltf-binary", "application/json", "image/png"}
        described = answer["content"]["application/json"]
        assert body in (described["schema"], *described["schema"].get("anyOf", ()))
        TypeAdapter(AnswerBody).validate_python(described["example"])
        assert set(described["example"]) == set(schema["components"]["schemas"]["AnswerBody"]["properties"])


def test_every_reference_leads_somewhere(schema: dict[str, Any]) -> None:
    for name in re.findall(r"#/components/schemas/(\w+)", str(schema)):
        assert name in schema["components"]["schemas"]


def test_problems_are_described(schema: dict[str, Any]) -> None:
    expected = {"406", "408", "413", "415", "422", "429", "503"}
    assert expected <= set(schema["paths"]["/v1/reconstruct"]["post"]["responses"])
    for status in expected:
        content = schema["paths"]["/v1/reconstruct"]["post"]["responses"][status]["content"]
        assert set(content) == {"application/problem+json"}
        assert content["application/problem+json"]["example"]["status"] == int(status)


def test_the_page_names_everything_and_asks_no_other_host(client: httpx.Client, schema: dict[str, Any]) -> None:
    response = client.get("/docs")
    assert response.headers["content-type"].startswith("text/html")
    for path in schema["paths"]:
        assert f"{path}</code>" in response.text
    assert "seed" in response.text
    assert "model/gltf-binary" in response.text
    assert "//" not in response.text.replace("<!doctype", "")
    assert "<script" not in response.text
    assert "default-src 'none'" in response.headers["content-security-policy"]
