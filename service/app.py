"""The HTTP interface: routes, and which error is which status. It and `service.http` are all that knows HTTP."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import Annotated

from anyio import CapacityLimiter, to_thread
from fastapi import FastAPI, Header, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse
from starlette.exceptions import HTTPException

from service.answer import reconstruct, sample
from service.catalogue import Catalogue
from service.errors import (
    CategoryError,
    ImageError,
    ImageFormatError,
    ImageTooLargeError,
    InferenceError,
    NotReadyError,
    ServiceError,
)
from service.http.body import BodyLimit
from service.http.description import describe
from service.http.documentation import CONTENT_SECURITY_POLICY, documentation_page
from service.http.negotiation import negotiate
from service.http.problem import HttpError, problem_response
from service.http.response import answer_response, cacheable_response
from service.http.schema import RECONSTRUCT, REPRESENTATIONS, SAMPLE, UPLOAD, Status, problems
from service.http.upload import read_upload
from service.settings import Settings

_DESCRIPTION = (
    "Send a picture, get the object in it as a 3D scene: a GLB file with the mesh, the picture's camera and lights. "
    "Every error is application/problem+json, and its detail says what was expected, what was found and what to do."
)
_UNAVAILABLE = problems(HTTPStatus.SERVICE_UNAVAILABLE)


def create_app(catalogue: Catalogue, settings: Settings) -> FastAPI:
    """The application. It answers at once, and is ready once the probes of all bundles agreed."""
    limiter = CapacityLimiter(settings.threads)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        loading = asyncio.create_task(asyncio.to_thread(catalogue.load))
        yield
        await loading

    # The description and its page are our own: FastAPI's page would fetch its scripts from another host.
    app = FastAPI(title="chiaro", description=_DESCRIPTION, version="1.0.0", lifespan=lifespan, openapi_url=None)
    app.add_middleware(BodyLimit, limit=settings.max_upload_bytes)
    _install_error_handlers(app)

    @app.post(
        "/reconstruct",
        summary="The object in a picture",
        response_class=JSONResponse,
        responses={
            **RECONSTRUCT,
            **problems(
                HTTPStatus.NOT_ACCEPTABLE,
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
                HTTPStatus.UNPROCESSABLE_ENTITY,
            ),
            **_UNAVAILABLE,
        },
        openapi_extra=UPLOAD,
    )
    async def post_reconstruct(request: Request, accept: Annotated[str | None, Header()] = None) -> Response:
        """Reads the picture upright, sets it on black, fits it into the model's frame, reconstructs what it shows."""
        media_type = negotiate(accept, REPRESENTATIONS)
        upload = await read_upload(request, settings.max_upload_bytes)
        engine = catalogue.engine(upload.category)
        answer = await to_thread.run_sync(reconstruct, engine, upload.image, settings.max_pixels, limiter=limiter)
        return answer_response(answer, media_type)

    @app.get(
        "/sample",
        summary="A new object",
        response_class=JSONResponse,
        responses={
            **SAMPLE,
            **problems(HTTPStatus.NOT_ACCEPTABLE, HTTPStatus.UNPROCESSABLE_ENTITY),
            **_UNAVAILABLE,
        },
    )
    async def get_sample(
        seed: Annotated[
            int, Query(ge=0, lt=2**32, description="Which object; the same seed gives the same bytes.")
        ] = 0,
        category: Annotated[
            str | None, Query(description="Of which kind; needed where several models are served.", examples=["car"])
        ] = None,
        accept: Annotated[str | None, Header()] = None,
        if_none_match: Annotated[
            str | None, Header(description="The ETag of the answer that is known already.")
        ] = None,
    ) -> Response:
        """Draws a shape code from the model's prior and decodes it; the object stands with its front to the camera."""
        media_type = negotiate(accept, REPRESENTATIONS)
        engine = catalogue.engine(category)
        answer = await to_thread.run_sync(sample, engine, seed, limiter=limiter)
        return cacheable_response(answer, media_type, if_none_match)

    @app.get("/healthz", summary="Does the service live?")
    async def get_health() -> Status:
        """Answers as long as the process does."""
        return Status("alive", tuple(sorted(catalogue.engines)))

    @app.get("/readyz", summary="Is the service ready?", responses=_UNAVAILABLE)
    async def get_readiness() -> Status:
        """Answers 200 once every bundle gave the numbers that it gave where it was exported."""
        if not catalogue.ready:
            raise NotReadyError(catalogue.failure or "the models are being loaded; try again in a second")
        return Status("ready", tuple(sorted(catalogue.engines)))

    @app.get("/openapi.json", include_in_schema=False)
    async def get_description() -> JSONResponse:
        return JSONResponse(schema)

    @app.get("/docs", include_in_schema=False)
    async def get_documentation() -> HTMLResponse:
        return HTMLResponse(documentation_page(schema), headers={"Content-Security-Policy": CONTENT_SECURITY_POLICY})

    schema = describe(app)
    return app


def _install_error_handlers(app: FastAPI) -> None:
    @app.exception_handler(ServiceError)
    async def on_service_error(_: Request, error: ServiceError) -> Response:
        status, kind = _status(error)
        headers = {"Retry-After": "1"} if status == HTTPStatus.SERVICE_UNAVAILABLE else None
        return problem_response(status, kind, str(error), headers)

    @app.exception_handler(HttpError)
    async def on_http_error(_: Request, error: HttpError) -> Response:
        return problem_response(error.status, error.kind, str(error))

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
        case ImageError():
            status = HTTPStatus.UNPROCESSABLE_ENTITY, "broken-image"
        case CategoryError():
            status = HTTPStatus.UNPROCESSABLE_ENTITY, "unknown-category"
        case NotReadyError():
            status = HTTPStatus.SERVICE_UNAVAILABLE, "not-ready"
        case InferenceError():
            status = HTTPStatus.INTERNAL_SERVER_ERROR, "inference-failed"
    return status
