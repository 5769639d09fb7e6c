"""Clients that are slow, leave, or speak no HTTP."""

import time

import pytest

from tests.service.hostile.target import IMAGE_PART, Target


def test_a_slow_body_is_given_up(target: Target) -> None:
    """A byte now and then would keep a connection and its body for ever."""
    with target.connect() as connection:
        head = b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n"
        connection.sendall(head + b"Content-Type: multipart/form-data; boundary=x\r\n\r\n" + IMAGE_PART)
        started = time.monotonic()
        connection.settimeout(0.1)
        answer = b""
        while not answer:
            assert time.monotonic() - started < 15
            connection.sendall(b"a")
            try:
                answer = connection.recv(65536)
            except TimeoutError:
                continue
        assert time.monotonic() - started > 1
        connection.settimeout(10)
        while piece := connection.recv(65536):
            answer += piece
    assert answer.startswith(b"HTTP/1.1 408 ")
    assert b"application/problem+json" in answer
    assert b"expected a whole body within 1.5 s, found " in answer


def test_a_client_that_leaves_while_it_sends_is_no_fault(target: Target) -> None:
    with target.connect() as connection:
        head = b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n"
        connection.sendall(head + b"Content-Type: multipart/form-data; boundary=x\r\n\r\n" + IMAGE_PART)
    expected = 'chiaro_requests_total{method="POST",route="/reconstruct",status="499"} 1.0'
    deadline = time.monotonic() + 10
    while expected not in target.client.get("/metrics").text:
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize(
    "head",
    [
        b"GET / HTTP/1.1\r\nHost: x\r\nA: " + b"a" * 200000,
        b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 50000,
        b"GET /" + b"a" * 200000,
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(500) + b"\r\n\r\n",
        b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n",
        b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\nContent-Length: 30\r\n\r\nabc",
        b"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Type: multipart/form-data; boundary=x\r\n"
        b"Transfer-Encoding: chunked\r\n\r\nnonsense\r\n",
    ],
    ids=["huge header", "many headers", "huge path", "TLS", "negative length", "two lengths", "wrong chunk"],
)
def test_what_is_no_http_is_cut_off(target: Target, head: bytes) -> None:
    """The server of HTTP itself answers these, in its own words, and closes."""
    answer = b""
    with target.connect() as connection:
        try:
            connection.sendall(head)
            while piece := connection.recv(65536):
                answer += piece
        except (ConnectionResetError, BrokenPipeError):
            # Closed before all was sent: the answer is lost on its way.
            return
    assert answer.startswith(b"HTTP/1.1 400 ")
