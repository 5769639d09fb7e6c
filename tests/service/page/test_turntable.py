import pytest
from playwright.sync_api import Page, expect

from tests.service.page.conftest import TURNTABLE, Visit

installed = pytest.mark.skipif(
    not TURNTABLE.exists(), reason="there is no turntable; service/page/turntable/install.sh installs it"
)


def bench(page: Page) -> Page:
    page.locator("#bench-stage").scroll_into_view_if_needed()
    return page


def orbit(page: Page) -> tuple[float, float]:
    """Azimuth and polar angle of the turntable's camera, radians."""
    theta, phi = page.locator("#bench-stage model-viewer").evaluate(
        "viewer => [viewer.getCameraOrbit().theta, viewer.getCameraOrbit().phi]"
    )
    return theta, phi


def orbit_at_rest(page: Page) -> tuple[float, float]:
    """Where the camera comes to rest: it moves on for a while, and for long where pictures are drawn slowly."""
    before, now = (0.0, 0.0), orbit(page)
    for _ in range(20):
        page.wait_for_timeout(1000)
        before, now = now, orbit(page)
        if now == pytest.approx(before, abs=1e-4):
            return now
    raise AssertionError(f"the camera still moves after 20 s, from {before} to {now}")


@installed
def test_the_turntable_starts_where_the_picture_was_and_turns_by_keyboard(visit: Visit) -> None:
    page = bench(visit(reduced_motion="reduce", turntable=True))
    expect(page.locator("#bench-stage")).to_have_class("stage turns")
    begun = orbit(page)
    assert begun == pytest.approx((-0.698, 1.047), abs=0.001)
    viewer = page.locator("#bench-stage model-viewer")
    viewer.locator(".userInput").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    turned = orbit_at_rest(page)
    assert turned[0] != pytest.approx(begun[0], abs=0.05)
    # Another shape is seen from the side that was chosen.
    page.get_by_role("button", name="Sample 4").press("Enter")
    expect(viewer).to_have_attribute("alt", "The mesh of a car: Sample 4")
    page.wait_for_timeout(500)
    assert orbit_at_rest(page) == pytest.approx(turned, abs=0.01)
    expect(page.locator(".missing")).to_have_count(0)


def test_without_the_turntable_the_page_says_so_and_turns_the_picture(page: Page) -> None:
    still_and_turned(bench(page))


@installed
def test_without_webgl_the_page_says_so_and_turns_the_picture(visit: Visit) -> None:
    forbidden = "HTMLCanvasElement.prototype.getContext = OffscreenCanvas.prototype.getContext = () => null;"
    page = visit(turntable=True, prepare=lambda page: page.add_init_script(forbidden))
    still_and_turned(bench(page))


def still_and_turned(page: Page) -> None:
    expect(page.locator("#invent .missing")).to_contain_text("The slider turns the picture")
    picture = page.locator("#bench-stage img")
    expect(picture).to_be_visible()
    expect(picture).to_have_attribute("alt", "The mesh of a car: Sample 0")
    slider = page.locator("#bench-stage-turn")
    assert slider.input_value() == "40"
    slider.press("ArrowRight")
    address = picture.get_attribute("src")
    assert address is not None
    assert address.endswith("azimuth_degrees=45")
