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
    """A route for each file of the page as it is now; without a page, `/` leads to the description."""
    router = APIRouter(include_in_schema=False)
    if not (page / "index.html").is_file():

        @router.get("/")
        async def get_root() -> RedirectResponse:
            return RedirectResponse("docs")

        return router
    files = StaticFiles(directory=page)

    def add(path: str, name: str) -> None:
        async def get_file(request: Request) -> Response:
            response = await files.get_response(name, request.scope)
            response.headers["Cache-Control"] = "no-cache"
            response.headers["Content-Security-Policy"] = _POLICY
            response.headers["X-Content-Type-Options"] = "nosniff"
            return response

        router.add_api_route(path, get_file, methods=["GET", "HEAD"])

    # No route for any path: it would answer for those that exist with another method only, and hide 404 and 405.
    for file in sorted(page.rglob("*")):
        if file.is_file():
            name = file.relative_to(page).as_posix()
            add(f"/{name}", name)
    add("/", "index.html")
    return router
