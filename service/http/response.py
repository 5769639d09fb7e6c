"""An answer as an HTTP response: a file or JSON, with the pose, the lights and the timings in headers."""

import base64
import hashlib
import json
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

from fastapi import Response
from pydantic_core import to_jsonable_python

from service.answer import Answer, Gallery
from service.http.media import JSON, PNG
from service.manifest import Manifest
from service.report import Report


def answer_response(answer: Answer, media_type: str) -> Response:
    """The response to pictures."""
    body = _json(_body(answer, answer.timings_ms)) if media_type == JSON else answer.content
    headers = {**_headers(answer.report, media_type), **_timing(answer.timings_ms), "Cache-Control": "no-store"}
    return Response(body, media_type=media_type, headers=headers)


def cacheable_answer(answer: Answer, media_type: str, if_none_match: str | None) -> Response:
    """The response to a request that always has the same answer; 304 where the client holds it already."""
    body = _json(_body(answer, None)) if media_type == JSON else answer.content
    headers = {**_headers(answer.report, media_type), **_timing(answer.timings_ms)}
    return _cacheable(body, media_type, headers, if_none_match)


def cacheable_gallery(gallery: Gallery, media_type: str, if_none_match: str | None) -> Response:
    """The response with several objects in one file."""
    report = gallery.reports[0]
    headers = {**_identity(report.category, report.model, media_type), **_timing(gallery.timings_ms)}
    return _cacheable(gallery.content, media_type, headers, if_none_match)


def list_body(answers: Sequence[Answer]) -> bytes:
    """Several objects as JSON; some milliseconds of work."""
    report = answers[0].report
    samples = [_body(answer, None) for answer in answers]
    return _json({"category": report.category, "model": report.model, "samples": samples})


def cacheable_list(manifest: Manifest, body: bytes, if_none_match: str | None) -> Response:
    """The response with several objects as JSON, which `list_body` has made."""
    return _cacheable(body, JSON, _identity(manifest.category, manifest.identity, JSON), if_none_match)


def _cacheable(body: bytes, media_type: str, headers: dict[str, str], if_none_match: str | None) -> Response:
    etag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
    headers = {**headers, "ETag": etag, "Cache-Control": "public, max-age=3600"}
    known = [tag.strip().removeprefix("W/") for tag in (if_none_match or "").split(",")]
    if etag in known or "*" in known:
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
    return Response(body, media_type=media_type, headers=headers)


def _body(answer: Answer, timings_ms: dict[str, float] | None) -> dict[str, Any]:
    glb = base64.b64encode(answer.content).decode("ascii")
    return {**to_jsonable_python(answer.report), "glb_base64": glb, "timings_ms": timings_ms}


def _json(content: dict[str, Any]) -> bytes:
    return json.dumps(content, separators=(",", ":"), allow_nan=False).encode()


def _headers(report: Report, media_type: str) -> dict[str, str]:
    headers = {
        **_identity(report.category, report.model, media_type),
        "Chiaro-Azimuth-Degrees": f"{report.azimuth_degrees:.4f}",
        "Chiaro-Lights": _json_text(to_jsonable_python(report.lights)),
        "Chiaro-Ambient": _json_text(report.ambient),
    }
    if report.posterior is not None:
        headers["Chiaro-Azimuth-Confidence"] = f"{report.posterior.azimuth_confidence:.4f}"
    if report.out_of_class_score is not None:
        headers["Chiaro-Out-Of-Class-Score"] = f"{report.out_of_class_score:.4f}"
    if report.category_probabilities is not None:
        headers["Chiaro-Category-Probability"] = f"{report.category_probabilities[report.category]:.4f}"
    return headers


def _identity(category: str, model: str, media_type: str) -> dict[str, str]:
    suffix = "png" if media_type == PNG else "glb"
    return {
        "Vary": "Accept",
        "Content-Disposition": f'inline; filename="{category}.{suffix}"',
        "Chiaro-Category": category,
        "Chiaro-Model": model,
    }


def _timing(timings_ms: dict[str, float]) -> dict[str, str]:
    return {"Server-Timing": ", ".join(f"{stage};dur={value}" for stage, value in timings_ms.items())}


def _json_text(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"))
