"""Errors as application/problem+json (RFC 9457)."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from http import HTTPStatus
from typing import Final

from fastapi.responses import JSONResponse

MEDIA_TYPE: Final = "application/problem+json"


@dataclass(frozen=True)
class Problem:
    """Why a request was not answered: what was expected, what was found, and what to do."""

    type: str
    title: str
    status: int
    detail: str


RETRY_AFTER: Final = {"Retry-After": "1"}
"""The header of a refusal that holds for a moment only."""


class HttpError(Exception):
    """A request that is refused before any work is done; `kind` names the reason in the problem's type."""

    def __init__(self, status: HTTPStatus, kind: str, detail: str, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(detail)
        self.status = status
        self.kind = kind
        self.headers = headers


def problem_response(
    status: HTTPStatus, kind: str, detail: str, headers: Mapping[str, str] | None = None
) -> JSONResponse:
    """The response that tells of a problem."""
    # A detail quotes what was sent, and that may hold what UTF-8 cannot (lone surrogates).
    encodable = detail.encode("utf-8", "replace").decode("utf-8")
    problem = Problem(f"urn:chiaro:problem:{kind}", status.phrase, int(status), encodable)
    return JSONResponse(asdict(problem), int(status), headers, media_type=MEDIA_TYPE)
