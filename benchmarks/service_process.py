"""The service as a process of its own: its start, its address, its memory."""

import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection
from pathlib import Path

PACKAGES = ("onnxruntime", "pillow", "fastapi", "starlette", "uvicorn", "h11")
"""What the service is made of."""
READY_SECONDS = 60.0


@dataclass(frozen=True)
class Service:
    """A service that is ready."""

    host: str
    port: int
    pid: int
    seconds_to_ready: float
    """From the start of the process until its models were proven."""


@contextmanager
def serving(models: Path, threads: int) -> Iterator[Service]:
    """python -m service at a free port, once it is ready.

    Raises:
        RuntimeError: it does not start.
    """
    command = [sys.executable, "-m", "service", "--port", "0", "--models", str(models), "--threads", str(threads)]
    began = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            if not line:
                raise RuntimeError(f"expected the service to start, found that it did not: {' '.join(command)}")
            address = next(word for word in line.split() if word.startswith("http://"))
            host, _, port = address.removeprefix("http://").rpartition(":")
            while _status(host, int(port)) != 200:
                if time.perf_counter() - began > READY_SECONDS:
                    raise RuntimeError(f"expected the models to be ready within {READY_SECONDS:g} s, found them not")
                time.sleep(0.005)
            yield Service(host, int(port), process.pid, time.perf_counter() - began)
        finally:
            process.terminate()
            process.wait()


def ask(service: Service, method: str, path: str, body: bytes, headers: Mapping[str, str]) -> tuple[int, bytes]:
    """Status and body of one answer."""
    connection = HTTPConnection(service.host, service.port, timeout=60)
    try:
        connection.request(method, path, body, dict(headers))
        response = connection.getresponse()
        return response.status, response.read()
    finally:
        connection.close()


def memory_mebibytes(service: Service) -> dict[str, float]:
    """Resident memory now, and the most that there ever was; Linux only, else empty."""
    status = Path(f"/proc/{service.pid}/status")
    if not status.exists():
        return {}
    fields = dict(line.split(":", 1) for line in status.read_text().splitlines())
    return {name: round(int(fields[key].split()[0]) / 1024, 1) for name, key in (("now", "VmRSS"), ("peak", "VmHWM"))}


def _status(host: str, port: int) -> int:
    return ask(Service(host, port, 0, 0.0), "GET", "/readyz", b"", {})[0]
