"""Uploads that are broken, wrong or hostile: each gets a status and a sentence, through real HTTP."""

import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import httpx
import pytest
from PIL import Image

from service.app import create_app
from service.bundle import Bundle
from service.catalogue import Catalogue
from service.settings import Settings
from tests.service.asking import post, problem
from tests.service.conftest import Serving
from tests.service.test_readiness import wait_until

Encoded = Callable[..., bytes]


def test_what_is_no_picture_is_415(client: httpx.Client) -> None:
    detail = problem(post(client, b"%PDF-1.7 and so on"), 415, "unsupported-image")
    assert detail.startswith("expected a picture, found 18 bytes that begin with “%PDF-1.7”; send a PNG")


def test_a_damaged_picture_is_422(client: httpx.Client, picture: bytes) -> None:
    detail = problem(post(client, picture[: len(picture) // 2]), 422, "broken-image")
    assert detail.startswith("expected a whole PNG picture, found one that is damaged or cut off")
    assert "found an empty file" in problem(post(client, b""), 422, "broken-image")


def test_too_many_pixels_are_413(client: httpx.Client, encoded: Encoded) -> None:
    content = encoded(Image.new("1", (5000, 4000)))
    detail = problem(post(client, content), 413, "image-too-large")
    assert detail == "expected at most 1000000 pixels, found 5000 × 4000 = 20000000; send a smaller picture"


@pytest.mark.parametrize("megabytes", [1, 20])
def test_too_many_bytes_are_413_declared_or_not(client: httpx.Client, megabytes: int) -> None:
    detail = problem(post(client, bytes(megabytes * 10**6)), 413, "upload-too-large")
    assert detail.startswith(f"expected a body of at most 200000 bytes, found {megabytes}")

    def endless() -> Iterator[bytes]:
        yield b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n'
        for _ in range(megabytes * 10):
            yield bytes(10**5)

    headers = {"Content-Type": "multipart/form-data; boundary=x"}
    response = client.post("/reconstruct", content=endless(), headers=headers)
    assert "found more" in problem(response, 413, "upload-too-large")


def test_a_chunked_picture_within_the_limit_is_read(client: httpx.Client, picture: bytes) -> None:
    def parts() -> Iterator[bytes]:
        yield b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n'
        yield from (picture[start : start + 1000] for start in range(0, len(picture), 1000))
        yield b"\r\n--x--\r\n"

    headers = {"Content-Type": "multipart/form-data; boundary=x"}
    assert client.post("/reconstruct", content=parts(), headers=headers).content == post(client, picture).content


def go_on(connection: socket.socket) -> None:
    """Sends more, for up to twenty seconds."""
    for _ in range(400):
        connection.sendall(b"1\r\nx\r\n")
        time.sleep(0.05)


def test_an_endless_body_is_answered_too(server: str) -> None:
    """A client that never stops sending is answered and cut off after some seconds, and nobody else waits for it."""
    address = urlsplit(server)
    assert address.hostname is not None
    assert address.port is not None
    with socket.create_connection((address.hostname, address.port), timeout=20) as connection:
        connection.sendall(b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n")
        connection.sendall(b"Content-Type: multipart/form-data; boundary=x\r\n\r\n")
        opening = b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n'
        connection.sendall(b"%x\r\n" % (len(opening) + 0x40000) + opening + bytes(0x40000) + b"\r\n")
        started = time.monotonic()
        assert httpx.get(f"{server}/sample?seed=1").status_code == 200
        assert time.monotonic() - started < 3
        assert connection.recv(1000).startswith(b"HTTP/1.1 413 ")
        with pytest.raises(OSError, match=r"reset|pipe"):
            go_on(connection)


def test_all_bodies_together_are_limited(bundle: Bundle, serving: Serving, picture: bytes) -> None:
    """Of two that are being sent at once there is room for one."""
    limits = Settings(threads=1, queue=0, max_upload_bytes=20_000)
    headers = {"Content-Type": "multipart/form-data; boundary=x"}
    arrived, go = threading.Event(), threading.Event()

    def slow() -> Iterator[bytes]:
        yield b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n' + bytes(15_000)
        arrived.set()
        assert go.wait(20)
        yield b"\r\n--x--\r\n"

    with serving(create_app(Catalogue((bundle,)), limits)) as client, ThreadPoolExecutor(1) as other:
        wait_until(lambda: client.get("/readyz").status_code == 200)
        first = other.submit(client.post, "/reconstruct", content=slow(), headers=headers)
        assert arrived.wait(20)
        try:
            refused = client.post("/reconstruct", files={"image": picture + bytes(15_000 - len(picture))})
            assert "20000 bytes in the bodies of all requests" in problem(refused, 429, "too-busy")
            assert refused.headers["retry-after"] == "1"
            assert post(client, picture).status_code == 200
        finally:
            go.set()
        problem(first.result(20), 415, "unsupported-image")
        # What is answered counts no more.
        assert client.post("/reconstruct", files={"image": bytes(15_000)}).status_code == 415


def test_who_asks_before_sending_is_refused_at_once(server: str) -> None:
    address = urlsplit(server)
    assert address.hostname is not None
    assert address.port is not None
    with socket.create_connection((address.hostname, address.port), timeout=20) as connection:
        connection.sendall(
            b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\nExpect: 100-continue\r\n"
        )
        connection.sendall(b"Content-Type: multipart/form-data; boundary=x\r\n\r\n")
        started = time.monotonic()
        assert connection.recv(1000).startswith(b"HTTP/1.1 413 ")
        assert time.monotonic() - started < 3


@pytest.mark.parametrize("charset", ["unicode_escape", "undefined", "idna", "hex", "utf-16", "utf-7", "nonsense"])
def test_strange_charsets_are_no_fault_of_ours(client: httpx.Client, picture: bytes, charset: str) -> None:
    body = (
        b'--x\r\nContent-Disposition: form-data; name="category"\r\n\r\n\\ud800\xff\r\n'
        b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n' + picture + b"\r\n--x--\r\n"
    )
    headers = {"Content-Type": f"multipart/form-data; boundary=x; charset={charset}"}
    response = client.post("/reconstruct", content=body, headers=headers)
    assert response.status_code == 422
    assert response.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize(
    ("body", "content_type", "status", "kind", "sentence"),
    [
        (
            b"{}",
            "application/json",
            415,
            "unsupported-media-type",
            "expected multipart/form-data, found application/json",
        ),
        (b"x", None, 415, "unsupported-media-type", "found no Content-Type"),
        (b"x", "multipart/form-data", 422, "invalid-form", "Missing boundary"),
        (b"junk", "multipart/form-data; boundary=x", 422, "invalid-form", "expected 1 to 16 files named image"),
        (
            b"--x--\r\n",
            "multipart/form-data; boundary=x",
            422,
            "invalid-form",
            "expected a file named image, found none",
        ),
        (
            b'--x\r\nContent-Disposition: form-data; name="image"\r\n\r\nabc\r\n--x--\r\n',
            "multipart/form-data; boundary=x",
            422,
            "invalid-form",
            "expected a file named image, found a field without a file name",
        ),
    ],
)
def test_a_wrong_form_is_named(
    client: httpx.Client, body: bytes, content_type: str | None, status: int, kind: str, sentence: str
) -> None:
    headers = {"Content-Type": content_type} if content_type else {}
    detail = problem(client.post("/reconstruct", content=body, headers=headers), status, kind)
    assert sentence in detail
    assert "curl -F image=@" in detail


def test_wrong_fields_are_named(client: httpx.Client, picture: bytes) -> None:
    many = [("image", ("a", picture))] * 17
    assert "Too many files" in problem(client.post("/reconstruct", files=many), 422, "invalid-form")
    stranger = client.post("/reconstruct", files={"picture": ("a", picture)})
    assert "expected no fields but image, category, hypotheses, refine, blocks, found picture" in problem(
        stranger, 422, "invalid-form"
    )
    twice = client.post("/reconstruct", files={"image": ("a", picture)}, data={"category": ["car", "car"]})
    assert "expected one category at most, found 2" in problem(twice, 422, "invalid-form")
    as_file = client.post("/reconstruct", files={"image": ("a", picture), "category": ("a", b"car")})
    assert "expected category to be text, found a file" in problem(as_file, 422, "invalid-form")
    half = client.post("/reconstruct", files={"image": ("a", picture)}, data={"image": "text"})
    assert "found a field without a file name" in problem(half, 422, "invalid-form")
    category = client.post("/reconstruct", files={"category": ("a", b"car")})
    assert "expected a file named image" in problem(category, 422, "invalid-form")


@pytest.mark.parametrize("blocks", ["some", "USED", "0", "used "])
def test_other_blocks_than_all_or_used_are_422(client: httpx.Client, picture: bytes, blocks: str) -> None:
    detail = problem(post(client, picture, blocks=blocks), 422, "invalid-form")
    assert f"expected blocks to be all or used, found “{blocks}”" in detail


def test_an_object_of_one_part_uses_it(client: httpx.Client, picture: bytes) -> None:
    whole, used, absent = (post(client, picture, **data) for data in ({"blocks": "all"}, {"blocks": "used"}, {}))
    assert whole.status_code == 200
    assert len(whole.content) == len(used.content) == len(absent.content)


@pytest.mark.parametrize("hypotheses", ["0", "361", "-1", "two", "1.5", "٣", "9" * 400, "00000000199999", " 3"])
def test_a_wrong_number_of_hypotheses_is_422(client: httpx.Client, picture: bytes, hypotheses: str) -> None:
    detail = problem(post(client, picture, hypotheses=hypotheses), 422, "invalid-form")
    assert f"expected hypotheses from 1 to 360, found “{hypotheses[:40]}”" in detail


def test_sixteen_pictures_are_looked_at_together(client: httpx.Client, picture: bytes) -> None:
    headers = {"Accept": "application/json"}
    files = [("image", (f"{number}.png", picture)) for number in range(16)]
    content = client.post("/v1/reconstruct", files=files, data={"hypotheses": "2"}, headers=headers).json()
    alone = post(client, picture, headers).json()
    assert len(content["views"]) == 16
    assert content["shape_code"] == alone["shape_code"]
    assert all(view["hypotheses"] == alone["hypotheses"][:2] for view in content["views"])
