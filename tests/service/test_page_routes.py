"""`/`: the page's files where there are any, and nothing else."""

from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from service.http.faults import install_error_handlers
from service.http.routes.page import page_routes
from tests.service.asking import problem
from tests.service.conftest import Serving


def app_with(page: Path) -> FastAPI:
    app = FastAPI(openapi_url=None)
    install_error_handlers(app)
    app.include_router(page_routes(page))
    return app


@pytest.fixture
def page(tmp_path: Path) -> Path:
    (tmp_path / "secret.txt").write_text("secret")
    (tmp_path / "page" / "parts").mkdir(parents=True)
    (tmp_path / "page" / "index.html").write_text("<!doctype html>the page")
    (tmp_path / "page" / "parts" / "a.js").write_text("export {};")
    (tmp_path / "page" / "link.txt").symlink_to(tmp_path / "secret.txt")
    return tmp_path / "page"


def test_the_pages_files_are_served(serving: Serving, page: Path) -> None:
    with serving(app_with(page)) as client:
        response = client.get("/")
        assert response.text == "<!doctype html>the page"
        assert response.headers["content-type"].startswith("text/html")
        assert response.headers["cache-control"] == "no-cache"
        assert "default-src 'none'" in response.headers["content-security-policy"]
        assert client.get("/", headers={"If-None-Match": response.headers["etag"]}).status_code == 304
        script = client.get("/parts/a.js")
        assert script.text == "export {};"
        assert "javascript" in script.headers["content-type"]


@pytest.mark.parametrize(
    "path", ["/absent", "/parts", "/../secret.txt", "/%2e%2e/secret.txt", "/link.txt", "//etc/passwd"]
)
def test_nothing_else_is(serving: Serving, page: Path, path: str) -> None:
    with serving(app_with(page)) as client:
        response = client.get(httpx.URL(str(client.base_url), raw_path=path.encode()))
        assert "secret" not in response.text.replace("secret.txt", "")
        problem(response, 404, "not-found")


def test_files_are_only_read(serving: Serving, page: Path) -> None:
    with serving(app_with(page)) as client:
        problem(client.post("/"), 405, "method-not-allowed")


def test_without_a_page_there_is_the_description(serving: Serving, tmp_path: Path) -> None:
    with serving(app_with(tmp_path)) as client:
        response = client.get("/")
        assert (response.status_code, response.headers["location"]) == (307, "docs")
        problem(client.get("/index.html"), 404, "not-found")
