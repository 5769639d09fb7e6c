"""The description of the service, for machines and for people."""

from collections.abc import Callable
from typing import Any

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, JSONResponse

from service.http.documentation import CONTENT_SECURITY_POLICY, documentation_page


def document_routes(schema: Callable[[], dict[str, Any]]) -> APIRouter:
    """The routes of the OpenAPI description, which `schema` returns."""
    router = APIRouter(include_in_schema=False)

    @router.get("/openapi.json")
    async def get_description() -> JSONResponse:
        return JSONResponse(schema())

    @router.get("/docs")
    async def get_documentation() -> HTMLResponse:
        return HTMLResponse(documentation_page(schema()), headers={"Content-Security-Policy": CONTENT_SECURITY_POLICY})

    return router
