"""What OpenAPI says of requests and answers: bodies, media types, headers, problems."""

from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, Final

from service.http.examples import DETAILS
from service.http.media import GLB, PNG
from service.http.problem import MEDIA_TYPE as PROBLEM
from service.http.problem import Problem
from service.http.upload import AUTOMATIC, MOST_HYPOTHESES, MOST_ITERATIONS, MOST_PICTURES
from service.report import Report


@dataclass(frozen=True)
class AnswerBody(Report):
    """The JSON form of an answer: what the GLB's extras say, and the GLB itself."""

    glb_base64: str
    """The GLB file, base64."""
    timings_ms: dict[str, float] | None
    """Milliseconds of each stage; null where the answer depends on nothing but the request."""


@dataclass(frozen=True)
class SamplesBody:
    """The JSON form of several samples."""

    category: str
    model: str
    samples: tuple[AnswerBody, ...]


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
                            "type": "array",
                            "minItems": 1,
                            "maxItems": MOST_PICTURES,
                            "items": {
                                "type": "string",
                                "format": "binary",
                                "contentMediaType": "application/octet-stream",
                            },
                            "description": "PNG, JPEG, WebP, BMP or GIF files, all of one object, each before a plain "
                            "or transparent background; one file suffices.",
                        },
                        "category": {
                            "type": "string",
                            "description": f"What the pictures show; {AUTOMATIC}, or none: the service finds out.",
                            "default": AUTOMATIC,
                            "examples": ["car"],
                        },
                        "hypotheses": {
                            "type": "integer",
                            "minimum": 1,
                            "maximum": MOST_HYPOTHESES,
                            "default": 3,
                            "description": "How many turns of the object to tell, the most probable first.",
                        },
                        "refine": {
                            "type": "integer",
                            "minimum": 0,
                            "maximum": MOST_ITERATIONS,
                            "default": 0,
                            "description": "Iterations in which shape, pose and light follow the pictures, a few "
                            "milliseconds each.",
                        },
                        "blocks": {
                            "type": "string",
                            "enum": ["all", "used"],
                            "default": "all",
                            "description": "Of a model of blocks: whether a GLB holds those, too, that other blocks "
                            "hide or that are next to nothing.",
                        },
                    },
                }
            }
        },
    }
}

_IDENTITY: Final[dict[str, Any]] = {
    "Chiaro-Category": {"description": "Whose model answered.", "schema": {"type": "string"}},
    "Chiaro-Model": {"description": "The model's identity.", "schema": {"type": "string"}},
    "Server-Timing": {"description": "Milliseconds of each stage.", "schema": {"type": "string"}},
}
_HEADERS: Final[dict[str, Any]] = {
    **_IDENTITY,
    "Chiaro-Azimuth-Degrees": {"description": "The object's turn about +Y.", "schema": {"type": "number"}},
    "Chiaro-Lights": {"description": "The lights, as JSON.", "schema": {"type": "string"}},
    "Chiaro-Ambient": {"description": "The ambient light, linear RGB as JSON.", "schema": {"type": "string"}},
}
_CONFIDENCE: Final[dict[str, Any]] = {
    "Chiaro-Azimuth-Confidence": {"description": "Probability of the azimuth's bin.", "schema": {"type": "number"}},
    "Chiaro-Out-Of-Class-Score": {
        "description": "0: explained as well as pictures of the class; where the model knows.",
        "schema": {"type": "number"},
    },
    "Chiaro-Category-Probability": {
        "description": "Of the category that answered, where the service chose it.",
        "schema": {"type": "number"},
    },
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
                    "example": {**example, "detail": DETAILS[status]},
                }
            },
        }
    return described


def _answer(model: Any, description: str, headers: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    return {
        200: {
            "model": model,
            "description": description,
            "headers": headers,
            "content": {
                media_type: {"schema": {"type": "string", "format": "binary", "contentMediaType": media_type}}
                for media_type in (GLB, PNG)
            },
        }
    }


_UNCHANGED: Final[dict[int | str, dict[str, Any]]] = {
    304: {"description": "Not modified: the body is the one whose ETag If-None-Match names."}
}

RECONSTRUCT: Final = _answer(
    AnswerBody,
    "The object as a GLB with the picture's camera and lights, the same as JSON, or as a PNG that shows the mesh over "
    "the first picture.",
    {**_HEADERS, **_CONFIDENCE},
)
SAMPLE: Final = {
    **_answer(
        AnswerBody | SamplesBody,
        "A new object as a GLB, as JSON, or as a PNG that its camera takes; several in one file, or as a list.",
        {**_HEADERS, **_CACHING},
    ),
    **_UNCHANGED,
}
SHAPE: Final = {
    **_answer(AnswerBody, "The object as a GLB, as JSON, or as a PNG that its camera takes.", {**_HEADERS, **_CACHING}),
    **_UNCHANGED,
}
METRICS: Final[dict[int | str, dict[str, Any]]] = {
    200: {"description": "The figures.", "content": {"text/plain": {"schema": {"type": "string"}}}}
}
