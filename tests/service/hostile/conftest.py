"""A service to attack: after each attack it lives, is not much larger, and has written no file."""

import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from tests.service.asking import post
from tests.service.hostile.target import Target

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="package")
def target(bundle_directory: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Target]:
    """A service that can write nothing to any file: a write would fail, and be answered with 500."""
    folder = tmp_path_factory.mktemp("elsewhere")
    command = [sys.executable, "-m", "service", "--port", "0", "--models", str(bundle_directory)]
    options = ["--max-upload-bytes", "400000", "--max-pixels", "1000000", "--upload-seconds", "1.5"]
    environment = {**os.environ, "TMPDIR": str(folder), "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        [*command, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder, env=environment
    ) as process:
        try:
            assert process.stdout is not None
            with httpx.Client(base_url=process.stdout.readline().split()[3], timeout=20) as client:
                deadline = time.monotonic() + 60
                while client.get("/readyz").status_code != 200:
                    assert time.monotonic() < deadline
                    time.sleep(0.05)
                # What onnxruntime and others leave there at their start.
                before = files_of(folder)
                resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (0, 0))
                yield Target(client, process.pid)
                assert client.get("/healthz").status_code == 200
        finally:
            process.terminate()
            _, log = process.communicate(timeout=20)
    assert "Traceback" not in log, log
    assert files_of(folder) == before


def files_of(folder: Path) -> list[tuple[str, int, int]]:
    """Name, size and time of the last change of every file."""
    return sorted((str(file), file.stat().st_size, file.stat().st_mtime_ns) for file in folder.rglob("*"))


@pytest.fixture(autouse=True)
def alive(target: Target, picture: bytes) -> Iterator[None]:
    """After whatever was sent, the next client is served, and the memory of the process has not grown much."""
    before = resident_mebibytes(target.pid)
    yield
    assert post(target.client, picture).content.startswith(b"glTF")
    assert resident_mebibytes(target.pid) < before + 60


def resident_mebibytes(pid: int) -> float:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
