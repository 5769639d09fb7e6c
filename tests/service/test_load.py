"""More requests than threads: who waits, who is refused, who is given up."""

import re
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from urllib.parse import urlsplit

import httpx
import pytest
from fastapi import FastAPI
from PIL import Image

import service.http.routes.reconstruction as route
from service.answer import Answer
from service.app import create_app
from service.bundle import Bundle
from service.catalogue import Catalogue
from service.errors import SettingsError
from service.reconstruction import reconstruct
from service.settings import Settings, check_settings
from tests.service.asking import post, problem

Serving = Callable[[FastAPI], AbstractContextManager[httpx.Client]]


class Gate:
    """Work that begins, and goes on only when it is told to."""

    def __init__(self) -> None:
        self.begun = threading.Semaphore(0)
        self.begins = 0
        self.open = threading.Event()

    def reconstruct(self, *arguments: object) -> Answer:
        self.begins += 1
        self.begun.release()
        assert self.open.wait(20)
        return reconstruct(*arguments)  # type: ignore[arg-type]


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Iterator[Gate]:
    gate = Gate()
    monkeypatch.setattr(route, "reconstruct", gate.reconstruct)
    yield gate
    gate.open.set()


def application(bundle: Bundle, queue: int, deadline: float = 0) -> FastAPI:
    return create_app(loaded(bundle), Settings(threads=1, queue=queue, deadline=deadline))


@pytest.mark.parametrize(
    ("name", "value", "bounds"),
    [
        ("queue", -1, "0 to 65536"),
        ("deadline", -0.5, "0 to 3600"),
        ("deadline", float("nan"), "0 to 3600"),
        ("upload_seconds", 0, "1 to 3600"),
        ("workers", 0, "1 to 256"),
    ],
)
def test_limits_have_bounds(name: str, value: float, bounds: str) -> None:
    option = f"--{name.replace('_', '-')} (or CHIARO_{name.upper()})"
    with pytest.raises(SettingsError, match=re.escape(f"{option}: expected {bounds}, found {value}")):
        check_settings(Settings().model_copy(update={name: value}))


def loaded(bundle: Bundle) -> Catalogue:
    catalogue = Catalogue((bundle,))
    catalogue.load()
    return catalogue


def figure(client: httpx.Client, name: str) -> float:
    lines = client.get("/metrics").text.splitlines()
    return float(next(line.rpartition(" ")[2] for line in lines if line.startswith(f"{name} ")))


def wait_for(client: httpx.Client, name: str, value: float) -> None:
    deadline = time.monotonic() + 15
    while figure(client, name) != value:
        assert time.monotonic() < deadline, f"{name}: expected {value}, found {figure(client, name)}"
        time.sleep(0.02)


@contextmanager
def asking(client: httpx.Client, picture: bytes, gate: Gate) -> Iterator[Callable[[], Future[httpx.Response]]]:
    """A function that posts in the background; the gate is open at the end."""
    with ThreadPoolExecutor(8) as pool:
        try:
            yield lambda: pool.submit(post, client, picture)
        finally:
            gate.open.set()


def test_beyond_the_queue_requests_are_refused_and_the_others_answered(
    serving: Serving, bundle: Bundle, picture: bytes, gate: Gate
) -> None:
    with serving(application(bundle, queue=2)) as client, asking(client, picture, gate) as ask:
        first = ask()
        assert gate.begun.acquire(timeout=15)
        waiting = [ask(), ask()]
        wait_for(client, "chiaro_requests_waiting", 2)
        refused = post(client, picture)
        detail = problem(refused, 429, "too-busy")
        assert detail == "expected at most 2 requests to wait, found that many already; try again in a second"
        assert refused.headers["retry-after"] == "1"
        assert client.get("/sample").status_code == 429
        # What needs no thread is answered all the same.
        assert client.get("/healthz").status_code == 200
        gate.open.set()
        answers = {answer.result(20).content for answer in (first, *waiting)}
        assert len(answers) == 1
        assert next(iter(answers)).startswith(b"glTF")
        assert figure(client, 'chiaro_refusals_total{reason="full"}') == 2
        assert figure(client, "chiaro_requests_waiting") == 0
        assert gate.begins == 3


def test_work_that_does_not_begin_in_time_is_never_done(
    serving: Serving, bundle: Bundle, picture: bytes, gate: Gate
) -> None:
    with serving(application(bundle, queue=2, deadline=0.3)) as client, asking(client, picture, gate) as ask:
        first = ask()
        assert gate.begun.acquire(timeout=15)
        late = post(client, picture)
        detail = problem(late, 503, "too-late")
        assert detail.startswith("expected the work to begin within 0.3 s, found others before it")
        assert late.headers["retry-after"] == "1"
        gate.open.set()
        # What had begun is finished, however long that took.
        assert first.result(20).status_code == 200
        assert post(client, picture).status_code == 200
        assert gate.begins == 2
        assert figure(client, 'chiaro_refusals_total{reason="late"}') == 1


def test_nothing_is_done_for_a_client_that_left(serving: Serving, bundle: Bundle, picture: bytes, gate: Gate) -> None:
    with serving(application(bundle, queue=1)) as client, asking(client, picture, gate) as ask:
        first = ask()
        assert gate.begun.acquire(timeout=15)
        address = urlsplit(str(client.base_url))
        with socket.create_connection((str(address.hostname), address.port or 0), timeout=20) as departing:
            departing.sendall(b"GET /sample HTTP/1.1\r\nHost: x\r\n\r\n")
            wait_for(client, "chiaro_requests_waiting", 1)
        # Its place is free before the thread is.
        wait_for(client, "chiaro_requests_waiting", 0)
        second = ask()
        wait_for(client, "chiaro_requests_waiting", 1)
        gate.open.set()
        assert first.result(20).status_code == second.result(20).status_code == 200
        assert figure(client, 'chiaro_refusals_total{reason="departed"}') == 1
        assert figure(client, 'chiaro_requests_total{method="GET",route="/sample",status="499"}') == 1
        assert "chiaro_stage_seconds_count" in client.get("/metrics").text


def test_answers_belong_to_their_own_pictures(serving: Serving, bundle: Bundle, encoded: Callable[..., bytes]) -> None:
    """Sixteen clients, different pictures and forms, three threads: each gets what it would get alone."""
    pictures = []
    for number in range(16):
        image = Image.new("RGB", (96, 72))
        image.paste((255 - 12 * number, 40 + 12 * number, 130), (10 + number, 12, 50 + 2 * number, 60))
        pictures.append(encoded(image))
    with serving(create_app(loaded(bundle), Settings(threads=3, queue=64))) as client:
        alone = [post(client, content).content for content in pictures]
        assert len(set(alone)) == len(alone)
        order = [index for _ in range(4) for index in range(16)]
        with ThreadPoolExecutor(16) as pool:
            together = list(pool.map(lambda index: post(client, pictures[index]), order))
    assert {answer.status_code for answer in together} == {200}
    assert [answer.content for answer in together] == [alone[index] for index in order]
