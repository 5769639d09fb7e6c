"""The OpenAPI description of the application."""

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import TypeAdapter

from service.http.examples import INTERPOLATION, RECONSTRUCTION, SAMPLE, SHAPE
from service.http.media import JSON
from service.http.metrics import VERSION_PREFIX
from service.http.problem import Problem


def describe(app: FastAPI) -> dict[str, Any]:
    """FastAPI's own description, with our problems in the place of its validation errors, and our examples."""
    schema = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
    components = schema["components"]["schemas"]
    for unused in ("HTTPValidationError", "ValidationError"):
        components.pop(unused, None)
    components[Problem.__name__] = TypeAdapter(Problem).json_schema()
    # Set here, because FastAPI drops every null, and a null in an answer means something.
    for path, method, example in (
        ("/reconstruct", "post", RECONSTRUCTION),
        ("/sample", "get", SAMPLE),
        ("/decode", "get", SHAPE),
        ("/interpolate", "get", INTERPOLATION),
    ):
        schema["paths"][VERSION_PREFIX + path][method]["responses"]["200"]["content"][JSON]["example"] = example
    return schema
