"""Examples of answers, for the description."""

from http import HTTPStatus
from typing import Any, Final

RECONSTRUCTION: Final[dict[str, Any]] = {
    "category": "car",
    "model": "5f1c…",
    "azimuth_degrees": 34.2181,
    "camera": {"elevation_degrees": 30.0, "distance": 2.0, "field_of_view_degrees": 30.0, "aspect_ratio": 1.3333333},
    "light_azimuth_degrees": 0.0,
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
        "azimuth_symmetry": 1,
        "azimuth_fine_mean_degrees": 4.2181,
        "azimuth_fine_deviation_degrees": 2.5,
        "shape_deviation": [0.1021443, 0.3340902],
        "light": None,
    },
    "hypotheses": [
        {"azimuth_degrees": 34.2181, "probability": 0.981},
        {"azimuth_degrees": -145.7819, "probability": 0.019},
    ],
    "out_of_class_score": 0.3127,
    "category_probabilities": {"car": 0.994, "chair": 0.006},
    "views": [
        {
            "azimuth_degrees": 34.2181,
            "azimuth_confidence": 0.981,
            "azimuth_entropy_nats": 0.094,
            "azimuth_symmetry": 1,
            "hypotheses": [
                {"azimuth_degrees": 34.2181, "probability": 0.981},
                {"azimuth_degrees": -145.7819, "probability": 0.019},
            ],
            "light_azimuth_degrees": 0.0,
            "out_of_class_score": 0.3127,
        }
    ],
    "refinement": None,
    "seed": None,
    "temperature": None,
    "interpolation": None,
    "glb_base64": "Z2xURgIAAA…",
    "timings_ms": {"picture": 3.1, "encoder": 1.9, "decoder": 0.2, "render": 0.5, "glb": 0.1},
}
SHAPE: Final[dict[str, Any]] = {
    **RECONSTRUCTION,
    "azimuth_degrees": 0.0,
    "posterior": None,
    "hypotheses": None,
    "out_of_class_score": None,
    "category_probabilities": None,
    "views": None,
    "timings_ms": None,
}
SAMPLE: Final[dict[str, Any]] = {**SHAPE, "seed": 7, "temperature": 1.0}
INTERPOLATION: Final[dict[str, Any]] = {**SHAPE, "interpolation": {"from_seed": 7, "to_seed": 8, "t": 0.5}}

DETAILS: Final = {
    HTTPStatus.NOT_ACCEPTABLE: "expected Accept to allow model/gltf-binary or application/json or image/png, found "
    "“image/gif”; ask for one of those",
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE: "expected at most 25000000 pixels, found 30000 × 30000 = 900000000; "
    "send a smaller picture",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "expected a picture, found 1042 bytes that begin with “%PDF-1.7”; "
    "send a PNG, JPEG, WebP, BMP or GIF file",
    HTTPStatus.UNPROCESSABLE_ENTITY: "expected one of car, chair, found category “boat”; name one of those",
    HTTPStatus.REQUEST_TIMEOUT: "expected a whole body within 60 s, found 1042 bytes by then; "
    "send it faster, or a smaller picture",
    HTTPStatus.TOO_MANY_REQUESTS: "expected at most 64 requests to wait, found that many already; "
    "try again in a second",
    HTTPStatus.SERVICE_UNAVAILABLE: "the model of car is being loaded; try again in a second",
}
"""A problem's sentence for each status."""
