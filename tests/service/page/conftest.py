"""A real browser, and a service of two models that it visits."""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal, Protocol

import httpx
import pytest
import torch
from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Error,
    FilePayload,
    Page,
    Playwright,
    Request,
    Response,
    expect,
    sync_playwright,
)

from exporter.export import export
from service.app import create_app
from service.catalogue import read_catalogue
from service.settings import Settings
from tests.service.conftest import Serving, lively_checkpoint

TURNTABLE = Path(__file__).parents[3] / "service/page/turntable/model-viewer.min.js"
Scheme = Literal["light", "dark"]
Motion = Literal["reduce", "no-preference"]
# WebGL without a GPU.
_OPTIONS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory, serving: Serving) -> Iterator[httpx.Client]:
    """A client of a service that knows cars and chairs."""
    models = tmp_path_factory.mktemp("models")
    for seed, category in enumerate(("car", "chair")):
        checkpoint = lively_checkpoint(category, seed)
        with torch.no_grad():
            # Meshes that fit into their picture.
            checkpoint.model.decoder.displacements.weight.mul_(0.1)
        export(checkpoint, models / category, 0.0, {})
    with serving(create_app(read_catalogue(models), Settings(models=models))) as client:
        while client.get("/readyz").status_code != 200:
            time.sleep(0.02)
        yield client


# A package's fixture: what it starts runs an event loop of its own, and the rest of the tests may want to.
@pytest.fixture(scope="package")
def playwright() -> Iterator[Playwright]:
    with sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="package")
def browser(playwright: Playwright) -> Iterator[Browser]:
    # Patience for machines that are busy, and draw WebGL on the processor.
    expect.set_options(timeout=30_000)
    browser = launch(playwright, _OPTIONS)
    yield browser
    browser.close()


def launch(playwright: Playwright, options: list[str]) -> Browser:
    """A Chromium of the machine's, or else playwright's own."""
    names = ("chromium", "chromium-headless-shell", "google-chrome")
    path = next(filter(None, map(shutil.which, names)), None)
    try:
        return playwright.chromium.launch(executable_path=path, args=options)
    except Error as error:
        pytest.skip(
            f"no Chromium ({error.message.splitlines()[0]}); tests/service/page/install_browser.sh installs one"
        )


class Visit(Protocol):
    def __call__(
        self,
        width: int = 1280,
        height: int = 900,
        color_scheme: Scheme | None = None,
        reduced_motion: Motion | None = None,
        turntable: bool = False,
        prepare: Callable[[Page], object] = ...,
    ) -> Page: ...


@pytest.fixture
def visit(browser: Browser, site: httpx.Client) -> Iterator[Visit]:
    """visit(width, height, …): the page, once its gallery is there. Afterwards: nothing failed, nothing was refused by
    the policy, and no other host was asked. The turntable takes long without a GPU, and stays away unless wanted."""
    faults: list[str] = []
    contexts = []

    def on_console(message: ConsoleMessage) -> None:
        # A refusal of the API is told to the visitor; what else fails to load is found below.
        if message.type == "error" and not message.text.startswith("Failed to load resource"):
            faults.append(message.text)

    def on_response(response: Response) -> None:
        if response.status >= 400 and "/v1/" not in response.url:
            faults.append(f"{response.status} {response.url}")

    def on_request(request: Request) -> None:
        home = str(site.base_url).rstrip("/")
        if not request.url.startswith((home, f"blob:{home}", "data:")):
            faults.append(request.url)

    def visit(
        width: int = 1280,
        height: int = 900,
        color_scheme: Scheme | None = None,
        reduced_motion: Motion | None = None,
        turntable: bool = False,
        prepare: Callable[[Page], object] = lambda page: None,
    ) -> Page:
        context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme=color_scheme, reduced_motion=reduced_motion
        )
        contexts.append(context)
        page = context.new_page()
        page.on("console", on_console)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("response", on_response)
        page.on("request", on_request)
        if not turntable:
            page.route("**/turntable/*", lambda route: route.abort())
        prepare(page)
        page.goto(f"{site.base_url}/")
        expect(page.locator("#bench-words")).to_have_text("Sample 0")
        return page

    yield visit
    for context in contexts:
        context.close()
    assert faults == []


@pytest.fixture
def page(visit: Visit) -> Page:
    return visit()


@pytest.fixture
def upload(page: Page, picture: bytes) -> Page:
    """The page after a picture of a car was chosen."""
    page.get_by_label("What it shows").select_option("car")
    send(page, picture)
    return page


def send(page: Page, *pictures: bytes) -> None:
    """Choose pictures, and wait for the result."""
    page.locator("#files").set_input_files([payload(f"{number}.png", one) for number, one in enumerate(pictures)])
    expect(page.locator("p#status")).to_have_text("Found a car.")


def payload(name: str, content: bytes) -> FilePayload:
    """A file for the browser's file chooser."""
    return {"name": name, "mimeType": "application/octet-stream", "buffer": content}


def downloaded(page: Page, button: str) -> bytes:
    """The file behind a download button, once the page shows what was last asked for."""
    expect(page.locator("[aria-busy]")).to_have_count(0)
    with page.expect_download() as download:
        page.locator(button).click()
    assert download.value.suggested_filename.endswith(".glb")
    return download.value.path().read_bytes()
