"""Parameters that no route knows, through real HTTP: refused, as nobody should believe in one that does nothing."""

import httpx
import pytest

from tests.service.asking import problem

KIND = "unknown-parameter"


@pytest.mark.parametrize("path", ["/reconstruct", "/v1/reconstruct"])
def test_a_category_in_the_url_of_a_picture_is_refused(client: httpx.Client, path: str, picture: bytes) -> None:
    files = {"image": ("car.png", picture)}
    sentence = problem(client.post(f"{path}?category=car", files=files), 422, KIND)
    assert "in the form (curl -F category=car), found “category” in the URL" in sentence
    assert client.post(path, files=files, data={"category": "car"}).status_code == 200


@pytest.mark.parametrize(
    ("path", "unknown", "hint"),
    [
        ("sample?tempreature=2&seed=3", "tempreature", "(did you mean temperature?)"),
        ("decode?seed=1", "seed", "no parameters but z, category, azimuth_degrees, "),
        ("interpolate?from_seed=1&to_seed=2&count=3", "count", "from_seed, to_seed, t, category"),
        ("sample?" + "a" * 5000 + "=1", "a" * 40, "; see /docs"),
        ("sample?=1", "", "no parameters but seed"),
        ("sample?%ff%00=1", "\ufffd\0", "no parameters but seed"),
    ],
)
def test_a_misspelt_parameter_is_told_with_what_there_is(
    client: httpx.Client, path: str, unknown: str, hint: str
) -> None:
    sentence = problem(client.get(f"/v1/{path}"), 422, KIND)
    assert f"found “{unknown}” in the URL" in sentence
    assert hint in sentence
    assert len(sentence) < 300
