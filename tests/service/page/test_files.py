"""What the page is made of, without a browser."""

import re
from pathlib import Path

import httpx

PAGE = Path(__file__).parents[3] / "service/page"
MARKUP = (PAGE / "index.html").read_text("utf-8")


def test_the_markup_holds_no_script_and_no_style() -> None:
    assert not re.search(r"<style|\sstyle=|\son[a-z]+=|<script(?![^>]*\ssrc=)", MARKUP)


def test_no_file_names_another_host() -> None:
    for path in PAGE.iterdir():
        if path.suffix in {".html", ".css", ".js", ".svg"}:
            found = set(re.findall(r"https?://[^\s\"']+", path.read_text("utf-8")))
            assert found <= {"http://www.w3.org/2000/svg"}, path


def test_every_module_is_fetched_at_once() -> None:
    modules = {path.name for path in PAGE.glob("*.js")}
    preloaded = set(re.findall(r'<link rel="modulepreload" href="([^"]+)"', MARKUP))
    assert preloaded | {"page.js"} == modules


def test_every_element_that_the_scripts_look_for_is_there() -> None:
    identifiers = set(re.findall(r'\sid="([^"]+)"', MARKUP))
    for path in PAGE.glob("*.js"):
        assert set(re.findall(r'find\("([^"]+)"\)', path.read_text("utf-8"))) <= identifiers, path


def test_the_service_serves_the_page_with_types_that_browsers_take(site: httpx.Client) -> None:
    for path, kind in (("/", "text/html"), ("/style.css", "text/css"), ("/page.js", "text/javascript")):
        response = site.get(path)
        assert response.status_code == 200
        assert response.headers["content-type"].startswith(kind)
    assert site.get("/icon.svg").headers["content-type"] == "image/svg+xml"
