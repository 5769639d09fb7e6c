"""A real model, exported by the real exporter, and a real server that serves it."""

import io
import math
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import httpx
import numpy as np
import pytest
import torch
import uvicorn
from fastapi import FastAPI
from PIL import Image

from exporter.export import export
from service.bundle import Bundle, read_bundle
from service.inference import Engine, load_engine
from trainer.config import ModelConfig, SceneConfig, TrainConfig
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint

WIDTH, HEIGHT = 64, 48
AZIMUTH_OFFSET = math.radians(40)


def lively_checkpoint(category: str, seed: int) -> Checkpoint:
    """A small model with random weights, scaled so that poses differ and the mesh is far from a cube."""
    torch.manual_seed(seed)
    config = TrainConfig(width=WIDTH, height=HEIGHT, model=ModelConfig(encoder_channels=(4, 4, 4, 8, 8, 8)))
    model = Model(config.model, WIDTH, HEIGHT).eval()
    with torch.no_grad():
        model.decoder.displacements.weight.mul_(40)
        model.heads.azimuth_logits.weight.mul_(100)
        model.heads.azimuth_fine_mean.weight.mul_(10)
    return Checkpoint(config, SceneConfig(width=WIDTH, height=HEIGHT), category, 3, model, {}, {"seconds": 1.5})


@pytest.fixture(scope="session")
def bundle_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("bundle") / "car"
    export(lively_checkpoint("car", 0), directory, AZIMUTH_OFFSET, {"iou": 0.5})
    return directory


@pytest.fixture(scope="session")
def second_bundle_directory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("bundle") / "chair"
    export(lively_checkpoint("chair", 1), directory, 0.0, {})
    return directory


@pytest.fixture(scope="session")
def bundle(bundle_directory: Path) -> Bundle:
    return read_bundle(bundle_directory)


@pytest.fixture
def copy(bundle_directory: Path, tmp_path: Path) -> Path:
    """A bundle that may be altered."""
    return Path(shutil.copytree(bundle_directory, tmp_path / "copy"))


@pytest.fixture(scope="session")
def engine(bundle: Bundle) -> Engine:
    return load_engine(bundle)


@pytest.fixture(scope="session")
def encoded() -> Callable[..., bytes]:
    """encoded(image, format, **options): an image file in memory."""

    def encode(image: Image.Image, file_format: str = "PNG", **options: object) -> bytes:
        buffer = io.BytesIO()
        image.save(buffer, file_format, **options)
        return buffer.getvalue()

    return encode


@pytest.fixture(scope="session")
def picture(encoded: Callable[..., bytes]) -> bytes:
    """A PNG of a shaded disc on black."""
    rows, columns = np.mgrid[-1:1:96j, -1.33:1.33:128j]
    inside = rows**2 + columns**2 < 0.5
    shade = np.stack((0.5 + rows / 2, 0.5 + columns / 3, 0.5 - rows / 3), -1) * inside[..., None]
    return encoded(Image.fromarray((255 * shade).astype(np.uint8)))


@pytest.fixture(scope="session")
def server(bundle_directory: Path) -> Iterator[str]:
    """The address of `python -m service`, once it is ready."""
    command = [sys.executable, "-m", "service", "--port", "0", "--models", str(bundle_directory)]
    # Where the machine is busy, a second is not enough for as many iterations each time.
    options = ["--max-upload-bytes", "200000", "--max-pixels", "1000000", "--refine-seconds", "15"]
    with subprocess.Popen([*command, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("serving car at http://127.0.0.1:"), line
            address = line.split()[3]
            deadline = time.monotonic() + 30
            while httpx.get(f"{address}/readyz").status_code != 200:
                assert time.monotonic() < deadline
                time.sleep(0.02)
            yield address
        finally:
            process.terminate()
            _, log = process.communicate(timeout=20)
    assert "Traceback" not in log, log


@pytest.fixture(scope="session")
def client(server: str) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=server, timeout=20) as client:
        yield client


Serving = Callable[[FastAPI], AbstractContextManager[httpx.Client]]


@pytest.fixture(scope="session")
def serving() -> Serving:
    """serving(app): a client of an application that runs in a thread of this process, through real HTTP."""

    @contextmanager
    def serve(app: FastAPI) -> Iterator[httpx.Client]:
        with socket.create_server(("127.0.0.1", 0)) as listener:
            server = uvicorn.Server(uvicorn.Config(app, http="h11", log_level="critical"))
            thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
            thread.start()
            try:
                with httpx.Client(base_url=f"http://127.0.0.1:{listener.getsockname()[1]}", timeout=20) as client:
                    yield client
            finally:
                server.should_exit = True
                thread.join(20)
            assert not thread.is_alive()

    return serve
