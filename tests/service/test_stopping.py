"""`python -m service` as one process and as several: how it stops, asked or not."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import pytest


@contextmanager
def process(bundle_directory: Path, *options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """python -m service, and its address."""
    command = [sys.executable, "-m", "service", "--port", "0", "--models", str(bundle_directory), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as started:
        assert started.stdout is not None
        try:
            yield started, started.stdout.readline().split()[3]
        finally:
            started.terminate()
            started.wait(20)


def until_ready(address: str) -> None:
    deadline = time.monotonic() + 60
    while httpx.get(f"{address}/readyz", timeout=60).status_code != 200:
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_what_has_begun_is_finished_before_the_service_stops(bundle_directory: Path, picture: bytes) -> None:
    body = b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n' + picture + b"\r\n--x--\r\n"
    with process(bundle_directory) as (service, address):
        until_ready(address)
        host, port = str(urlsplit(address).hostname), urlsplit(address).port or 0
        with socket.create_connection((host, port), timeout=20) as connection:
            head = f"POST /reconstruct HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n"
            connection.sendall(head.encode() + b"Content-Type: multipart/form-data; boundary=x\r\n\r\n" + body[:100])
            # The service has this connection once another one after it was answered.
            assert httpx.get(f"{address}/healthz").status_code == 200
            service.send_signal(signal.SIGTERM)
            deadline = time.monotonic() + 15
            while accepts(host, port):
                assert time.monotonic() < deadline
                time.sleep(0.02)
            assert service.poll() is None
            connection.sendall(body[100:])
            answer = b"".join(iter(lambda: connection.recv(65536), b""))
        _, log = service.communicate(timeout=20)
    head_of_answer, _, content = answer.partition(b"\r\n\r\n")
    assert head_of_answer.startswith(b"HTTP/1.1 200 ")
    assert content.startswith(b"glTF")
    assert len(content) == int.from_bytes(content[8:12], "little")
    assert (service.returncode, log) == (0, "")


def accepts(host: str, port: int) -> bool:
    try:
        with socket.create_connection((host, port), timeout=5):
            return True
    except ConnectionRefusedError:
        return False


def workers_of(pid: int) -> list[int]:
    """The processes that a service began; Linux tells."""
    children = Path(f"/proc/{pid}/task/{pid}/children")
    if not children.exists():
        pytest.skip("expected the kernel to tell a process's children, found that this one does not")
    return [
        int(child)
        for child in children.read_text().split()
        if "spawn_main" in Path(f"/proc/{child}/cmdline").read_text()
    ]


def test_several_processes_share_the_port_and_stop_together(bundle_directory: Path) -> None:
    with process(bundle_directory, "--workers", "2", "--threads", "1") as (service, address):
        until_ready(address)
        workers = workers_of(service.pid)
        assert len(workers) == 2
        # Whichever sleeps, the other one answers.
        for sleeper in workers:
            until_ready(address)
            os.kill(sleeper, signal.SIGSTOP)
            try:
                until_ready(address)
            finally:
                os.kill(sleeper, signal.SIGCONT)
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=30)
    assert (service.returncode, log) == (0, "")


def test_where_one_of_several_processes_dies_the_service_stops_and_says_so(bundle_directory: Path) -> None:
    with process(bundle_directory, "--workers", "2", "--threads", "1") as (service, address):
        until_ready(address)
        workers = workers_of(service.pid)
        os.kill(workers[0], signal.SIGKILL)
        _, log = service.communicate(timeout=30)
    assert service.returncode == 1
    # The other process may not have begun to serve yet, and be warned of that as it stops.
    assert "--workers 2: expected all processes to live, found that one ended; start the service again\n" in log
    assert not any(Path(f"/proc/{worker}").exists() for worker in workers)


def test_processes_do_not_outlive_the_one_that_began_them(bundle_directory: Path) -> None:
    with process(bundle_directory, "--workers", "2", "--threads", "1") as (service, address):
        until_ready(address)
        workers = workers_of(service.pid)
        service.kill()
        deadline = time.monotonic() + 20
        while any(running(worker) for worker in workers):
            assert time.monotonic() < deadline
            time.sleep(0.05)


def running(pid: int) -> bool:
    """Whether a process is there, and has not ended; one that ended may wait for somebody to take note of it."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
