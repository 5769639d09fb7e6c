import pytest
from playwright.sync_api import expect

from tests.service.page.conftest import Scheme, Visit, send


@pytest.mark.parametrize("width", [320, 390, 768])
def test_nothing_sticks_out_at_the_width_of_a_phone(visit: Visit, picture: bytes, width: int) -> None:
    page = visit(width=width, height=800)
    page.get_by_label("What it shows").select_option("car")
    send(page, picture)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    boxes = page.locator("button, .button, select, input:not([type=file])").evaluate_all(
        "all => all.map((one) => one.getBoundingClientRect()).filter((box) => box.width > 0)"
        ".map(({ left, right, height }) => [left, right, height])"
    )
    assert len(boxes) > 20
    assert all(left >= 0 and right <= width for left, right, _ in boxes)


@pytest.mark.parametrize(("scheme", "dark"), [("light", False), ("dark", True)])
def test_the_page_is_as_dark_as_the_visitor_likes(visit: Visit, scheme: Scheme, dark: bool) -> None:
    page = visit(color_scheme=scheme)
    colours = page.evaluate("[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]")
    paper, ink = (sum(map(int, colour[4:-1].split(","))) / 3 for colour in colours)
    assert (paper < ink) is dark
    assert abs(paper - ink) > 150


def test_nothing_moves_for_who_wants_it_still(visit: Visit) -> None:
    page = visit(reduced_motion="reduce")
    assert page.evaluate("getComputedStyle(document.documentElement).scrollBehavior") == "auto"
    assert visit().evaluate("getComputedStyle(document.documentElement).scrollBehavior") == "smooth"
    expect(page.locator("#bench-words")).to_have_text("Sample 0")
