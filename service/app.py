"""The application: its routes, what wraps them, and what happens at its start and its end."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import cache
from typing import Any, Final

from fastapi import FastAPI

from service.catalogue import Catalogue
from service.http.backend import make_backend
from service.http.body import BodyLimit
from service.http.description import describe
from service.http.faults import install_error_handlers
from service.http.metrics import VERSION_PREFIX, Measured
from service.http.routes.documents import document_routes
from service.http.routes.generation import generation_routes
from service.http.routes.page import page_routes
from service.http.routes.reconstruction import reconstruction_routes
from service.http.routes.status import status_routes
from service.settings import Settings

_DESCRIPTION: Final = (
    "Send a picture, get the object in it as a 3D scene: a GLB file with the mesh, the picture's camera and lights. "
    "Every path is also there without /v1, and says the same. "
    "Every error is application/problem+json, and its detail says what was expected, what was found and what to do."
)


def create_app(catalogue: Catalogue, settings: Settings) -> FastAPI:
    """The application. It answers at once, and is ready once the probes of all bundles agreed."""
    backend = make_backend(catalogue, settings)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        loading = asyncio.create_task(asyncio.to_thread(catalogue.load))
        yield
        await loading

    # The description and its page are our own: FastAPI's page would fetch its scripts from another host.
    app = FastAPI(title="chiaro", description=_DESCRIPTION, version="1.0.0", lifespan=lifespan, openapi_url=None)
    # As many as may wait or be worked on can be as large as is allowed.
    total = (settings.queue + settings.threads) * settings.max_upload_bytes
    app.add_middleware(BodyLimit, limit=settings.max_upload_bytes, seconds=settings.upload_seconds, total=total)
    app.add_middleware(Measured, metrics=backend.metrics)
    install_error_handlers(app)

    @cache
    def schema() -> dict[str, Any]:
        return describe(app)

    for routes in (
        reconstruction_routes(backend),
        generation_routes(backend),
        status_routes(backend),
        document_routes(schema),
    ):
        app.include_router(routes, prefix=VERSION_PREFIX)
        app.include_router(routes, include_in_schema=False)
    app.include_router(page_routes())
    return app
