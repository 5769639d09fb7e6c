"""An answer as an HTTP response: GLB or JSON, with the pose, the lights and the timings in headers."""

import base64
import hashlib
import json
from dataclasses import asdict
from http import HTTPStatus

from fastapi import Response

from service.answer import Answer
from service.http.schema import GLB


def answer_response(answer: Answer, media_type: str) -> Response:
    """The response to a picture."""
    body = answer.glb if media_type == GLB else _json(answer, answer.timings_ms)
    return Response(body, media_type=media_type, headers={**_headers(answer), "Cache-Control": "no-store"})


def cacheable_response(answer: Answer, media_type: str, if_none_match: str | None) -> Response:
    """The response to a request that always has the same answer; 304 where the client holds it already."""
    body = answer.glb if media_type == GLB else _json(answer, None)
    etag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
    headers = {**_headers(answer), "ETag": etag, "Cache-Control": "public, max-age=3600"}
    known = [tag.strip().removeprefix("W/") for tag in (if_none_match or "").split(",")]
    if etag in known or "*" in known:
        return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=headers)
    return Response(body, media_type=media_type, headers=headers)


def _json(answer: Answer, timings_ms: dict[str, float] | None) -> bytes:
    glb = base64.b64encode(answer.glb).decode("ascii")
    content = {**asdict(answer.report), "glb_base64": glb, "timings_ms": timings_ms}
    return json.dumps(content, separators=(",", ":"), allow_nan=False).encode()


def _headers(answer: Answer) -> dict[str, str]:
    report = answer.report
    lights = [asdict(light) for light in report.lights]
    headers = {
        "Vary": "Accept",
        "Content-Disposition": f'inline; filename="{report.category}.glb"',
        "Chiaro-Category": report.category,
        "Chiaro-Model": report.model,
        "Chiaro-Azimuth-Degrees": f"{report.azimuth_degrees:.4f}",
        "Chiaro-Lights": json.dumps(lights, separators=(",", ":")),
        "Chiaro-Ambient": json.dumps(report.ambient, separators=(",", ":")),
        "Server-Timing": ", ".join(f"{stage};dur={value}" for stage, value in answer.timings_ms.items()),
    }
    if report.posterior is not None:
        headers["Chiaro-Azimuth-Confidence"] = f"{report.posterior.azimuth_confidence:.4f}"
    return headers
