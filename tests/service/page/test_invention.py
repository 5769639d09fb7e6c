import base64
from typing import Any

import httpx
from playwright.sync_api import Page, expect

from tests.service.page.conftest import downloaded


def made(site: httpx.Client, path: str, **query: str | int | float) -> Any:
    """What the API itself answers."""
    wanted = {"category": "car", "azimuth_degrees": 40, **query}
    response = site.get(path, params=wanted, headers={"Accept": "application/json"})
    assert response.status_code == 200, response.text
    return response.json()


def glb(answer: Any) -> bytes:
    return base64.b64decode(answer["glb_base64"])


def move(page: Page, label: str, value: float) -> None:
    """Move a slider as a hand does."""
    page.get_by_label(label, exact=True).evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input'));"
        " slider.dispatchEvent(new Event('change')); }",
        value,
    )


def test_the_gallery_shows_samples_of_consecutive_seeds(page: Page) -> None:
    page.get_by_label("First seed").fill("4294967292")
    page.get_by_label("First seed").press("Tab")
    tiles = page.locator(".tile")
    expect(tiles).to_have_text(["4294967292", "4294967293", "4294967294", "4294967295", "0", "1", "2", "3"])
    pictures = page.locator(".tile img")
    for number in range(8):
        expect(pictures.nth(number)).to_have_js_property("complete", True)
    assert all(pictures.evaluate_all("pictures => pictures.map((picture) => picture.naturalWidth > 0)"))


def test_a_pressed_sample_is_shown_and_can_be_downloaded(page: Page, site: httpx.Client) -> None:
    page.get_by_role("button", name="Sample 3").click()
    expect(page.locator("#bench-words")).to_have_text("Sample 3")
    expect(page.get_by_role("button", name="Sample 3")).to_have_attribute("aria-pressed", "true")
    expect(page.locator(".tile[aria-pressed=true]")).to_have_count(1)
    assert downloaded(page, "#bench-download") == glb(made(site, "/v1/sample", seed=3))


def test_without_temperature_all_samples_are_the_mean(page: Page, site: httpx.Client) -> None:
    move(page, "Temperature", 0)
    page.get_by_role("button", name="Sample 5").click()
    expect(page.locator("#bench-words")).to_have_text("Sample 5")
    expect(page.locator("#sliders output")).to_have_text(["0.0"] * 6)


def test_sliders_move_the_shape_code_and_go_back(page: Page, site: httpx.Client) -> None:
    before = downloaded(page, "#bench-download")
    code = made(site, "/v1/sample", seed=0)["shape_code"]
    model = next(one for one in site.get("/v1/categories").json()["categories"] if one["category"] == "car")
    undo = page.get_by_role("button", name="Back to where it began")
    expect(undo).to_be_disabled()
    move(page, "Direction 2", -1.5)
    expect(page.locator("#bench-words")).to_have_text("A shape of your own")
    code[model["latent_order"][1]] = -1.5
    spelled = ",".join(f"{value:.4f}" for value in code)
    assert downloaded(page, "#bench-download") == glb(made(site, "/v1/decode", z=spelled)) != before
    undo.click()
    expect(undo).to_be_disabled()
    expect(page.get_by_label("Direction 1")).to_be_focused()


def test_the_way_leads_from_one_sample_to_another(page: Page, site: httpx.Client) -> None:
    page.get_by_label("From seed").fill("4")
    page.get_by_label("To seed").fill("7")
    for t in (0.0, 0.5, 1.0):
        move(page, "Way", t)
        expect(page.locator("#way-value")).to_have_text(f"{round(100 * t)} %")
        expect(page.locator("#bench-words")).to_have_text("Between sample 4 and 7")
        page.wait_for_load_state("networkidle")
        assert downloaded(page, "#bench-download") == glb(made(site, "/v1/interpolate", from_seed=4, to_seed=7, t=t))


def test_the_shape_of_a_picture_can_be_varied(upload: Page) -> None:
    upload.get_by_role("button", name="Vary this shape").click()
    expect(upload.locator("#bench-words")).to_have_text("The shape from the picture")
    expect(upload.get_by_label("Direction 1")).to_be_focused()
    expect(upload.locator(".tile[aria-pressed=true]")).to_have_count(0)


def test_another_kind_has_its_own_samples(page: Page) -> None:
    page.get_by_label("Kind").select_option("chair")
    picture = page.locator(".tile img").first
    expect(picture).to_have_attribute("src", "v1/sample?category=chair&seed=0&temperature=1&azimuth_degrees=40")
