from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.service.page.conftest import TURNTABLE, Scheme, Visit, send

AXE = Path(__file__).parent / "node_modules/axe-core/axe.min.js"


@pytest.mark.skipif(not AXE.exists(), reason="there is no axe-core; npm ci --prefix tests/service/page installs it")
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(visit: Visit, picture: bytes, width: int, scheme: Scheme) -> None:
    page = visit(width=width, color_scheme=scheme, turntable=TURNTABLE.exists())
    page.get_by_label("What it shows").select_option("car")
    send(page, picture)
    page.locator("#problem").evaluate("alert => { alert.textContent = 'A problem.'; alert.hidden = false; }")
    page.locator("#doubt").evaluate("doubt => { doubt.textContent = 'A doubt.'; doubt.hidden = false; }")
    page.evaluate(AXE.read_text("utf-8"))
    found: dict[str, Any] = page.evaluate("axe.run()")
    assert [(one["id"], [node["html"] for node in one["nodes"]]) for one in found["violations"]] == []
    assert len(found["passes"]) > 30


def test_everything_is_reached_by_tab_in_the_order_of_reading(upload: Page) -> None:
    upload.locator(".skip").focus()
    reached = ["Skip to the content"]
    for _ in range(50):
        upload.keyboard.press("Tab")
        reached.append(upload.evaluate("document.activeElement.id || document.activeElement.textContent.trim()"))
        if reached[-1] == "The API":
            break
    wanted = ["Skip to the content", "Reconstruct", "files", "category", "example", "bare", "download", "vary", "kind"]
    wanted += ["seed", "temperature", "reseed", "0", "7", "bench-download", "direction-1", "direction-6", "from", "way"]
    assert [name for name in reached if name in wanted] == wanted


def test_the_whole_way_is_gone_by_keyboard(page: Page) -> None:
    page.get_by_role("button", name="Try an example").press("Enter")
    expect(page.get_by_role("heading", name="What was found")).to_be_focused()
    page.get_by_role("button", name="Sample 2").press("Space")
    expect(page.locator("#bench-words")).to_have_text("Sample 2")
    slider = page.get_by_label("Direction 1")
    before = float(slider.input_value())
    slider.press("ArrowLeft" if before > 0 else "ArrowRight")
    assert abs(float(slider.input_value()) - before) == pytest.approx(0.05, abs=0.03)
    expect(page.locator("#bench-words")).to_have_text("A shape of your own")


def test_focus_shows(page: Page) -> None:
    for selector in ("#example", ".tile", "#seed", "nav a"):
        element = page.locator(selector).first
        element.focus()
        page.keyboard.press("Shift+Tab")
        page.keyboard.press("Tab")
        assert element.evaluate("element => getComputedStyle(element).outlineStyle") == "solid"
    page.locator("#files").focus()
    assert page.locator("label[for=files]").evaluate("label => getComputedStyle(label).outlineStyle") == "solid"


def test_what_happens_is_announced(upload: Page) -> None:
    expect(upload.get_by_role("status").filter(has_text="Found a car.")).to_have_count(1)
    name = upload.locator("#overlay").get_attribute("alt")
    assert name is not None
    assert name.startswith("The mesh of a car, drawn over the picture; its front points")
