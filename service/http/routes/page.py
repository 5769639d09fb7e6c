"""The web page at `/` and the files beside it."""

from pathlib import Path
from typing import Final

from fastapi import APIRouter, Request, Response
from fastapi.responses import RedirectResponse
from starlette.staticfiles import StaticFiles

PAGE: Final = Path(__file__).parents[2] / "page"

# The turntable unpacks meshes with WebAssembly, holds what it draws in blobs, and brings one style element of its own.
_POLICY: Final = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; "
    "style-src 'self' 'sha256-PXtZZkJMMyc18o/DN1ZEFOJ2qEGq95IQbVaJFMOXOb0='; img-src 'self' blob:; "
    "connect-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


def page_routes(page: Path = PAGE) -> APIRouter:
    """The routes of the page; without one, `/` leads to the description. They come last: they match any path."""
    router = APIRouter(include_in_schema=False)
    if not (page / "index.html").is_file():

        @router.get("/")
        async def get_root() -> RedirectResponse:
            return RedirectResponse("docs")

        return router
    files = StaticFiles(directory=page, html=True)

    @router.get("/{path:path}")
    async def get_file(path: str, request: Request) -> Response:
        response = await files.get_response(path or ".", request.scope)
        response.headers["Cache-Control"] = "no-cache"
        response.headers["Content-Security-Policy"] = _POLICY
        response.headers["X-Content-Type-Options"] = "nosniff"
        return response

    return router
