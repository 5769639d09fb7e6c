"""Forms and parameters that are made to hurt: each is refused with a sentence, and soon."""

import time

import pytest

from tests.service.asking import problem
from tests.service.hostile.target import IMAGE_PART, Target

FORMS: dict[str, tuple[bytes, str, str]] = {
    "thousands of fields": (
        b'--x\r\nContent-Disposition: form-data; name="a"\r\n\r\n\r\n' * 5000 + b"--x--\r\n",
        "multipart/form-data; boundary=x",
        "Too many fields",
    ),
    "thousands of files": (
        (IMAGE_PART + b"\r\n") * 4000 + b"--x--\r\n",
        "multipart/form-data; boundary=x",
        "Too many files",
    ),
    "another boundary": (IMAGE_PART + b"a\r\n--x--\r\n", "multipart/form-data; boundary=y", "expected"),
    "no end": (IMAGE_PART + b"a" * 1000, "multipart/form-data; boundary=x", "expected"),
    "huge part header": (
        b"--x\r\nContent-Disposition: form-data; name=image; filename=" + b"a" * 300000 + b"\r\n\r\na\r\n--x--\r\n",
        "multipart/form-data; boundary=x",
        "expected",
    ),
    "thousands of part headers": (
        b"--x\r\n" + b"A: b\r\n" * 40000 + b"\r\na\r\n--x--\r\n",
        "multipart/form-data; boundary=x",
        "expected",
    ),
    "huge field": (
        b'--x\r\nContent-Disposition: form-data; name="category"\r\n\r\n' + b"a" * 300000 + b"\r\n--x--\r\n",
        "multipart/form-data; boundary=x",
        "expected",
    ),
    "form in a form": (
        b"--x\r\nContent-Type: multipart/mixed; boundary=y\r\n\r\n--y\r\n\r\na\r\n--y--\r\n--x--\r\n",
        "multipart/form-data; boundary=x",
        "expected",
    ),
    "empty boundary": (b"--\r\n\r\n----\r\n", "multipart/form-data; boundary=", "expected"),
    "boundary of nothing but dashes": (b"-" * 100000, "multipart/form-data; boundary=" + "-" * 70, "expected"),
}


@pytest.mark.parametrize("name", FORMS)
def test_a_hostile_form_is_refused(target: Target, name: str) -> None:
    body, content_type, sentence = FORMS[name]
    started = time.monotonic()
    response = target.client.post("/reconstruct", content=body, headers={"Content-Type": content_type})
    assert sentence in problem(response, 422, "invalid-form")
    assert time.monotonic() - started < 10


@pytest.mark.parametrize(
    "query",
    [
        "/sample?temperature=nan",
        "/sample?temperature=inf",
        "/sample?seed=1e3",
        "/sample?seed=-0x1",
        "/sample?azimuth_degrees=NaN",
        "/sample?count=64000000000000000000000",
        "/sample?category=%00%ff../../etc/passwd",
        "/interpolate?from_seed=1&to_seed=2&t=nan",
        "/decode?z=nan,1",
        "/decode?z=" + ",".join(["1e999"] * 12),
        "/decode?z=" + ",".join(["11"] * 12),
        "/decode?z=" + "1," * 20000,
    ],
)
def test_hostile_parameters_are_refused(target: Target, query: str) -> None:
    response = target.client.get(query)
    assert response.status_code == 422
    assert response.headers["content-type"] == "application/problem+json"
    assert len(response.content) < 10000
