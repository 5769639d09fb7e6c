"""`python -m service`: wrong options are answered with one sentence and exit status 2."""

import os
import signal
import socket
import statistics
import subprocess
import sys
import time
from pathlib import Path

import httpx
import pytest


def run(*options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "service", *options],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**os.environ, **environment},
    )


def test_help_explains_every_option() -> None:
    result = run("--help", COLUMNS="200")
    assert result.returncode == 0
    for option in ("--host", "--port", "--models", "--max-upload-bytes", "--max-pixels", "--threads"):
        assert option in result.stdout
    for word in ("bytes", "pixels", "10485760", "25000000", "8000", "CHIARO_PORT"):
        assert word in result.stdout


@pytest.mark.parametrize(
    ("options", "environment", "sentence"),
    [
        (["--port", "99999"], {}, "--port (or CHIARO_PORT): expected 0 to 65535, found 99999; see "),
        ([], {"CHIARO_PORT": "many"}, "found many; see python -m service --help"),
        ([], {"CHIARO_THREADS": "0"}, "--threads (or CHIARO_THREADS): expected 1 to 256, found 0"),
        (
            ["--models", "/nonexistent"],
            {},
            "/nonexistent: expected a bundle or a directory of bundles, found no directory",
        ),
        ([], {"CHIARO_MODELS": "/nonexistent"}, "/nonexistent: expected a bundle"),
    ],
)
def test_wrong_values_are_named(options: list[str], environment: dict[str, str], sentence: str) -> None:
    result = run(*options, **environment)
    assert result.returncode == 2
    assert sentence in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


def test_an_unknown_option_is_named() -> None:
    result = run("--modles", "x")
    assert result.returncode == 2
    assert "--modles" in result.stderr
    assert "--models" in result.stderr


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_it_cleanly(bundle_directory: Path, stop: signal.Signals) -> None:
    command = [sys.executable, "-m", "service", "--port", "0", "--models", str(bundle_directory)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().split()[3]
        assert httpx.get(f"{address}/healthz").status_code == 200
        process.send_signal(stop)
        _, log = process.communicate(timeout=20)
    assert (process.returncode, log) == (0, "")


def test_a_request_is_computed_on_one_core(bundle_directory: Path) -> None:
    program = """
import sys, threadpoolctl, uvicorn
from service.__main__ import main

def threads():
    return {pool["num_threads"] for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"}

before = threads()
uvicorn.Server.run = lambda server, sockets: print(before, threads())
sys.exit(main())
"""
    result = subprocess.run(
        [sys.executable, "-c", program, "--port", "0", "--models", str(bundle_directory)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "2"},
    )
    assert result.stdout.splitlines()[-1] == ("{1} {1}" if os.cpu_count() == 1 else "{2} {1}")


def test_answers_on_an_open_connection_are_not_held_back(client: httpx.Client) -> None:
    """The kernel would wait 40 ms for the client to confirm an answer's head before it sends the body, each time."""

    def seconds() -> float:
        started = time.perf_counter()
        assert client.get("/healthz").status_code == 200
        return time.perf_counter() - started

    assert statistics.median(seconds() for _ in range(30)) < 0.03


def test_a_port_in_use_is_named(bundle_directory: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as occupied:
        port = occupied.getsockname()[1]
        result = run("--port", str(port), "--models", str(bundle_directory))
    assert result.returncode == 2
    assert f"--port {port}: expected an address that is free, found: Address already in use" in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
