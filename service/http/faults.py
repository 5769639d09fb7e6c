"""Which error is which status."""

import logging
from http import HTTPStatus
from typing import Final

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from service.errors import (
    CategoryError,
    ImageError,
    ImageFormatError,
    ImageTooLargeError,
    InferenceError,
    NotReadyError,
    ServiceError,
    ShapeCodeError,
    StrangeImageError,
)
from service.http.problem import HttpError, problem_response

CLIENT_CLOSED_REQUEST: Final = 499
"""No status of HTTP's own: nginx's, for requests whose clients went away."""


logger = logging.getLogger(__name__)


def install_error_handlers(app: FastAPI) -> None:
    """Makes a problem of every error."""

    @app.exception_handler(ServiceError)
    async def on_service_error(_: Request, error: ServiceError) -> Response:
        status, kind = _status(error)
        if status == HTTPStatus.INTERNAL_SERVER_ERROR:
            logger.error("%s", error)
        headers = {"Retry-After": "1"} if status == HTTPStatus.SERVICE_UNAVAILABLE else None
        return problem_response(status, kind, str(error), headers)

    @app.exception_handler(HttpError)
    async def on_http_error(_: Request, error: HttpError) -> Response:
        return problem_response(error.status, error.kind, str(error), error.headers)

    @app.exception_handler(ClientDisconnect)
    async def on_departure(_: Request, __: ClientDisconnect) -> Response:
        # Nobody reads it; it stands in the figures.
        return Response(status_code=CLIENT_CLOSED_REQUEST)

    @app.exception_handler(HTTPException)
    async def on_routing_error(request: Request, error: HTTPException) -> Response:
        status = HTTPStatus(error.status_code)
        detail = f"{request.method} {request.url.path[:100]}: {error.detail}; see /docs for what there is"
        return problem_response(status, status.phrase.lower().replace(" ", "-"), detail, error.headers)

    @app.exception_handler(RequestValidationError)
    async def on_validation_error(_: Request, error: RequestValidationError) -> Response:
        sentences = (
            f"{'.'.join(str(part) for part in fault['loc'])}: {fault['msg']}, found “{str(fault['input'])[:60]}”"
            for fault in error.errors()
        )
        detail = f"{'; '.join(sentences)}; see /docs for what is expected"
        return problem_response(HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-parameter", detail)

    @app.exception_handler(Exception)
    async def on_fault(_: Request, __: Exception) -> Response:
        detail = "the service failed where it should not; the operator finds the cause in its log"
        return problem_response(HTTPStatus.INTERNAL_SERVER_ERROR, "internal-error", detail)


def _status(error: ServiceError) -> tuple[HTTPStatus, str]:
    status = HTTPStatus.INTERNAL_SERVER_ERROR, "internal-error"
    match error:
        case ImageTooLargeError():
            status = HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "image-too-large"
        case ImageFormatError():
            status = HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "unsupported-image"
        case StrangeImageError():
            status = HTTPStatus.UNPROCESSABLE_ENTITY, "unexplained-image"
        case ImageError():
            status = HTTPStatus.UNPROCESSABLE_ENTITY, "broken-image"
        case CategoryError():
            status = HTTPStatus.UNPROCESSABLE_ENTITY, "unknown-category"
        case ShapeCodeError():
            status = HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-shape-code"
        case NotReadyError():
            status = HTTPStatus.SERVICE_UNAVAILABLE, "not-ready"
        case InferenceError():
            status = HTTPStatus.INTERNAL_SERVER_ERROR, "inference-failed"
    return status
