import base64
from typing import Any

import httpx
import pytest
from playwright.sync_api import Page, Route, expect

from tests.service.page.conftest import Visit, downloaded, payload, send


def asked(
    site: httpx.Client, *pictures: bytes, accept: str = "application/json", category: str = "car", refine: int = 0
) -> Any:
    """What the API itself answers."""
    files = [("image", ("picture.png", one)) for one in pictures]
    fields = {"category": category, "refine": str(refine)}
    response = site.post("/v1/reconstruct", files=files, data=fields, headers={"Accept": accept})
    assert response.status_code == 200, response.text
    return response.json() if accept == "application/json" else response.content


def choose(page: Page, category: str) -> None:
    page.get_by_label("What it shows").select_option(category)


def test_the_result_is_the_services_answer(page: Page, site: httpx.Client, picture: bytes) -> None:
    choose(page, "car")
    send(page, picture)
    answer = asked(site, picture)
    expect(page.get_by_role("heading", name="What was found")).to_be_focused()
    expect(page.locator("#class-words")).to_have_text("Taken for a car.")
    turn = round(answer["azimuth_degrees"])
    expect(page.locator("#pose-words")).to_contain_text(f"{abs(turn)}° to the {'right' if turn > 0 else 'left'}")
    guesses = page.locator("#hypotheses li")
    expect(guesses).to_have_count(3)
    shown = [f"{round(guess['azimuth_degrees'])}°".replace("-", "−") for guess in answer["hypotheses"]]
    assert [text.split("\n")[0] for text in guesses.all_inner_texts()] == shown
    expect(page.locator("#lights li")).to_have_count(len(answer["lights"]))
    expect(page.locator("#timings dt")).to_have_count(len(answer["timings_ms"]))
    assert downloaded(page, "#download") == base64.b64decode(answer["glb_base64"])


def test_the_overlay_is_the_services_picture_and_the_own_picture_can_be_compared(
    page: Page, site: httpx.Client, picture: bytes
) -> None:
    choose(page, "car")
    send(page, picture)
    overlay, original = page.locator("#overlay"), page.locator("#original")
    assert shown_bytes(page, "#overlay") == asked(site, picture, accept="image/png")
    expect(original).to_be_hidden()
    page.get_by_label("Picture alone").check()
    expect(overlay).to_be_hidden()
    expect(original).to_be_visible()
    assert shown_bytes(page, "#original") == picture


def test_a_longer_look_is_refined(page: Page, site: httpx.Client, picture: bytes) -> None:
    choose(page, "car")
    send(page, picture)
    expect(page.locator("#timings")).not_to_contain_text("Refining")
    page.get_by_label("Look longer").check()
    expect(page.locator("#timings")).to_contain_text("Refining")
    answer = asked(site, picture, refine=4)
    assert answer["refinement"]["iterations"] >= 1
    assert downloaded(page, "#download") == base64.b64decode(answer["glb_base64"])
    assert shown_bytes(page, "#overlay") == asked(site, picture, accept="image/png", refine=4)


def shown_bytes(page: Page, image: str) -> bytes:
    """The file that an <img> shows."""
    script = """async (image) => {
      const response = await fetch(image.src);
      return Array.from(new Uint8Array(await response.arrayBuffer()));
    }"""
    return bytes(page.locator(image).evaluate(script))


def test_the_dial_points_where_the_answer_does(page: Page, site: httpx.Client, picture: bytes) -> None:
    choose(page, "car")
    send(page, picture)
    answer = asked(site, picture)
    areas = page.locator("#dial .bin").evaluate_all(
        "bins => bins.map(bin => bin.getBBox().width * bin.getBBox().height)"
    )
    probabilities = [one["probability"] for one in answer["posterior"]["azimuth_bins"]]
    assert len(areas) == len(probabilities)
    assert areas.index(max(areas)) == probabilities.index(max(probabilities))
    expect(page.get_by_role("img", name="Dial, from above")).to_be_visible()


def test_several_pictures_are_of_one_object(page: Page, site: httpx.Client, picture: bytes) -> None:
    choose(page, "car")
    mirrored = asked(site, picture, accept="image/png")
    send(page, picture, mirrored)
    answer = asked(site, picture, mirrored)
    expect(page.locator("#views")).to_contain_text("The shape is that of 2 pictures together")
    assert downloaded(page, "#download") == base64.b64decode(answer["glb_base64"])


def test_the_models_tell_the_class(page: Page, site: httpx.Client, picture: bytes) -> None:
    page.locator("#files").set_input_files(payload("a.png", picture))
    bars = page.locator("#classes li")
    expect(bars).to_have_count(2)
    probabilities = asked(site, picture, category="auto")["category_probabilities"]
    assert [text.split("\n")[0] for text in bars.all_inner_texts()] == list(probabilities)
    widths = bars.evaluate_all("bars => bars.map((bar) => parseFloat(bar.style.getPropertyValue('--share')))")
    assert widths == pytest.approx([100 * value for value in probabilities.values()])


@pytest.mark.parametrize("way", ["drop", "paste"])
def test_pictures_can_be_dropped_and_pasted(page: Page, picture: bytes, way: str) -> None:
    choose(page, "car")
    script = """([way, numbers]) => {
      const data = new DataTransfer();
      data.items.add(new File([new Uint8Array(numbers)], "picture.png", { type: "image/png" }));
      const event = way === "drop"
        ? new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true })
        : new ClipboardEvent("paste", { clipboardData: data, bubbles: true, cancelable: true });
      document.body.dispatchEvent(event);
    }"""
    page.evaluate(script, [way, list(picture)])
    expect(page.locator("p#status")).to_have_text("Found a car.")


def test_who_has_no_picture_gets_an_example(page: Page) -> None:
    choose(page, "car")
    page.get_by_role("button", name="Try an example").click()
    expect(page.locator("p#status")).to_have_text("Found a car.")
    expect(page.locator("#overlay")).to_be_visible()


def test_a_problem_is_told_in_the_services_words_and_takes_the_old_result_away(
    upload: Page, site: httpx.Client, picture: bytes
) -> None:
    files = {"image": ("notes.txt", b"no picture")}
    sentence: str = site.post("/v1/reconstruct", files=files, data={"category": "auto"}).json()["detail"]
    upload.locator("#files").set_input_files(payload("notes.txt", b"no picture"))
    alert = upload.get_by_role("alert")
    expect(alert).to_be_in_viewport()
    assert alert.inner_text().casefold().rstrip(".") == sentence.casefold().rstrip(".")
    expect(upload.locator("#result")).to_be_hidden()
    send(upload, picture)
    expect(alert).to_be_hidden()


def test_a_service_that_is_gone_is_told(page: Page, picture: bytes) -> None:
    page.route("**/v1/reconstruct", lambda route: route.abort())
    page.locator("#files").set_input_files(payload("a.png", picture))
    expect(page.get_by_role("alert")).to_have_text(
        "Expected an answer of the service, found no connection; see whether it still runs."
    )


@pytest.mark.parametrize(("score", "doubted"), [(0.4, False), (1.8, True), (None, False)])
def test_what_the_model_explains_badly_is_doubted(
    visit: Visit, picture: bytes, score: float | None, doubted: bool
) -> None:
    def answer(route: Route) -> None:
        response = route.fetch()
        if response.headers["content-type"] == "application/json":
            route.fulfill(response=response, json={**response.json(), "out_of_class_score": score})
        else:
            route.fulfill(response=response)

    page = visit(prepare=lambda page: page.route("**/v1/reconstruct", answer))
    choose(page, "car")
    send(page, picture)
    doubt = page.locator("#doubt")
    expect(doubt).to_be_visible() if doubted else expect(doubt).to_be_hidden()
    expect(page.locator("#fit")).to_contain_text("score 0.4") if score == 0.4 else expect(
        page.locator("#fit")
    ).to_be_empty()
