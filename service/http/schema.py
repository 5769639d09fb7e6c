"""What OpenAPI says of the answers: the JSON body, the media types, the problems, and an example of each."""

from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, Final

from service.http.problem import MEDIA_TYPE as PROBLEM
from service.http.problem import Problem
from service.report import Report

GLB: Final = "model/gltf-binary"
JSON: Final = "application/json"
REPRESENTATIONS: Final = (GLB, JSON)


@dataclass(frozen=True)
class AnswerBody(Report):
    """The JSON form of an answer: what the GLB's extras say, and the GLB itself."""

    glb_base64: str
    """The GLB file, base64."""
    timings_ms: dict[str, float] | None
    """Milliseconds of each stage; null where the answer depends on nothing but the request."""


@dataclass(frozen=True)
class Status:
    """That the service lives, or that it is ready, and what it serves."""

    status: str
    categories: tuple[str, ...]


UPLOAD: Final[dict[str, Any]] = {
    "requestBody": {
        "required": True,
        "content": {
            "multipart/form-data": {
                "schema": {
                    "type": "object",
                    "required": ["image"],
                    "properties": {
                        "image": {
                            "type": "string",
                            "format": "binary",
                            "contentMediaType": "application/octet-stream",
                            "description": "A PNG, JPEG, WebP, BMP or GIF file: one object before a black or "
                            "transparent background.",
                        },
                        "category": {
                            "type": "string",
                            "description": "What the picture shows; needed where several models are served.",
                            "examples": ["car"],
                        },
                    },
                }
            }
        },
    }
}

RECONSTRUCTION_EXAMPLE: Final[dict[str, Any]] = {
    "category": "car",
    "model": "5f1c…",
    "azimuth_degrees": 34.2181,
    "camera": {"elevation_degrees": 30.0, "distance": 2.0, "field_of_view_degrees": 30.0, "aspect_ratio": 1.3333333},
    "lights": [{"azimuth_degrees": 30.0, "elevation_degrees": 35.2644, "colour": [1.0, 0.0, 0.0]}],
    "ambient": [0.0, 0.0, 0.0],
    "shape_code": [0.4180934, -1.2067112],
    "posterior": {
        "azimuth_confidence": 0.981,
        "azimuth_bins": [
            {"azimuth_degrees": -150.0, "probability": 0.019},
            {"azimuth_degrees": 30.0, "probability": 0.981},
        ],
        "azimuth_entropy_nats": 0.094,
        "azimuth_fine_mean_degrees": 4.2181,
        "azimuth_fine_deviation_degrees": 2.5,
        "shape_deviation": [0.1021443, 0.3340902],
    },
    "seed": None,
    "glb_base64": "Z2xURgIAAA…",
    "timings_ms": {"picture": 3.1, "encoder": 1.9, "decoder": 0.2, "glb": 0.1},
}
SAMPLE_EXAMPLE: Final[dict[str, Any]] = {
    **RECONSTRUCTION_EXAMPLE,
    "azimuth_degrees": 0.0,
    "posterior": None,
    "seed": 7,
    "timings_ms": None,
}

_DETAILS: Final = {
    HTTPStatus.NOT_ACCEPTABLE: "expected Accept to allow model/gltf-binary or application/json, found “image/png”; "
    "ask for one of those",
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE: "expected at most 25000000 pixels, found 30000 × 30000 = 900000000; "
    "send a smaller picture",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "expected a picture, found 1042 bytes that begin with “%PDF-1.7”; "
    "send a PNG, JPEG, WebP, BMP or GIF file",
    HTTPStatus.UNPROCESSABLE_ENTITY: "expected one of car, chair, found category “boat”; name one of those",
    HTTPStatus.SERVICE_UNAVAILABLE: "the model of car is being loaded; try again in a second",
}

_HEADERS: Final[dict[str, Any]] = {
    "Chiaro-Category": {"description": "Whose model answered.", "schema": {"type": "string"}},
    "Chiaro-Model": {"description": "The model's identity.", "schema": {"type": "string"}},
    "Chiaro-Azimuth-Degrees": {"description": "The object's turn about +Y.", "schema": {"type": "number"}},
    "Chiaro-Lights": {"description": "The lights, as JSON.", "schema": {"type": "string"}},
    "Chiaro-Ambient": {"description": "The ambient light, linear RGB as JSON.", "schema": {"type": "string"}},
    "Server-Timing": {"description": "Milliseconds of each stage.", "schema": {"type": "string"}},
}
_CONFIDENCE: Final[dict[str, Any]] = {
    "Chiaro-Azimuth-Confidence": {"description": "Probability of the azimuth's bin.", "schema": {"type": "number"}}
}
_CACHING: Final[dict[str, Any]] = {
    "ETag": {"description": "Digest of the body.", "schema": {"type": "string"}},
    "Cache-Control": {"description": "How long the answer may be kept.", "schema": {"type": "string"}},
}


def problems(*statuses: HTTPStatus) -> dict[int | str, dict[str, Any]]:
    """The responses of an operation that tell of problems."""
    described: dict[int | str, dict[str, Any]] = {}
    for status in statuses:
        example = {"type": "urn:chiaro:problem:…", "title": status.phrase, "status": int(status)}
        described[int(status)] = {
            "description": status.phrase,
            "content": {
                PROBLEM: {
                    "schema": {"$ref": f"#/components/schemas/{Problem.__name__}"},
                    "example": {**example, "detail": _DETAILS[status]},
                }
            },
        }
    return described


def _answer(description: str, headers: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    return {
        200: {
            "model": AnswerBody,
            "description": description,
            "headers": headers,
            "content": {
                GLB: {"schema": {"type": "string", "format": "binary", "contentMediaType": GLB}},
            },
        }
    }


RECONSTRUCT: Final = _answer(
    "The object as a GLB with the picture's camera and lights, or the same as JSON.",
    {**_HEADERS, **_CONFIDENCE},
)
SAMPLE: Final = {
    **_answer("A new object as a GLB, or the same as JSON.", {**_HEADERS, **_CACHING}),
    304: {"description": "Not modified: the body is the one whose ETag If-None-Match names."},
}
